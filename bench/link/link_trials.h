#pragma once

#include <algorithm>
#include <array>
#include <cstdint>
#include <functional>
#include <map>
#include <string>
#include <vector>

#include "rigs/fault_line.h"

/// What becomes of shots when the line to the rig, or the other host on it, misbehaves. Each trial is one shot of the
/// real client at the real server, and everything in it follows from a seed.

namespace powbench::bench {

using rigs::LineFault;

/// What came of the shots under one kind of fault.
struct FaultRow {
  LineFault::Kind kind = LineFault::Kind::none;
  bool to_rig = false;
  int tried = 0;
  int struck = 0;                        ///< the fault fell into the shot
  int same = 0;                          ///< complete at once, and equal to the undisturbed record
  int fetched = 0;                       ///< the same, after the connection had been reported lost
  int reported = 0;                      ///< no record, and said so
  int silent = 0;                        ///< a record that differs, taken for good
  int lost = 0;                          ///< the rig holds the complete record, the host never got it
  int twice = 0;                         ///< the coil was energised more than once
  int late = 0;                          ///< answered later than the deadline
  double longest = 0;                    ///< s
  std::map<std::string, int> reasons{};  ///< of what was reported
  std::vector<std::string> wrong{};      ///< one sentence for each trial that did what must not happen

  FaultRow& operator+=(const FaultRow& other) {
    for (auto field :
         {&FaultRow::tried, &FaultRow::struck, &FaultRow::same, &FaultRow::fetched, &FaultRow::reported,
          &FaultRow::silent, &FaultRow::lost, &FaultRow::twice, &FaultRow::late})
      this->*field += other.*field;
    longest = std::max(longest, other.longest);
    for (const auto& [reason, times] : other.reasons) reasons[reason] += times;
    wrong.insert(wrong.end(), other.wrong.begin(), other.wrong.end());
    return *this;
  }
};

using Progress = std::function<void(int done, int of)>;

/// Faults on TCP: every kind in both directions, in turn, at a random byte of the shot.
std::vector<FaultRow> tcp_faults(int count, std::uint64_t seed, const Progress& = {});
/// The same on a paced serial line of 2 Mbaud behind the bridge; flip, drop, delay and stall.
std::vector<FaultRow> serial_faults(int count, std::uint64_t seed, const Progress& = {});
/// Deadline of the trials: the limit of the shot, one connection behind it and two requests.
double trial_deadline();

/// Two hosts whose requests take turns by a seeded schedule.
struct InterleavingRow {
  int schedules = 0, shots = 0;
  int own = 0;      ///< records that are what the host asked for
  int refused = 0;  ///< refused in words
  int foreign = 0;  ///< records that are not
};
InterleavingRow interleavings(int count, std::uint64_t seed, const Progress& = {});

/// The owner hangs up without a word.
struct VanishRow {
  std::string state;
  int spectators = 0;
  bool off = false;       ///< gate off and disarmed at the end
  double virtual_ms = 0;  ///< energised: gate on after the owner's connection closed, on the sampling clock
};
std::vector<VanishRow> vanishing_owners();

struct ServerRow {
  int connections = 0;
  double connections_growth_mb = 0;  ///< of the resident set over them
  double flood_mb = 0;               ///< sent behind a pending READBUF
  double flood_growth_mb = 0;
  double slow_lines_wait_s = 0;  ///< a new client's wait while 16 half-typed lines hold all places
};
ServerRow server_under_attack(int connections, int flood_megabytes);

}  // namespace powbench::bench
