#pragma once

#include <chrono>
#include <memory>
#include <string>
#include <string_view>
#include <utility>
#include <vector>

#include "core/channels.h"
#include "rigs/rig.h"

namespace powbench::rigs {

/// A state in which the coil is off. What is not known (another word, or none) confirms nothing.
inline bool coil_off(const std::string& state) {
  return state == "idle" || state == "captured" || state == "fault";
}

/// A rig's own sentence about a fault in the words of who uses the host: its last step, "write 1 to abort", is
/// to acknowledge.
inline std::string advice(std::string sentence) {
  constexpr std::string_view step = "write 1 to abort";
  if (const auto at = sentence.find(step); at != std::string::npos)
    sentence.replace(at, step.size(), "acknowledge the fault");
  return sentence;
}

/// What a rig says of itself at one moment, in its own words.
struct RigStatus {
  std::string state;       ///< idle, armed, firing, captured or fault
  std::string fault;       ///< number and name of the latched fault, or "0 none"
  std::string phase;       ///< of the mains
  std::string owner;       ///< who has the lease, or "free"
  std::string last_error;  ///< why the rig last refused or tripped
  /// The phase tracker in numbers; "" = an older rig: Hz; standard uncertainty of the phase now and 20 ms ahead,
  /// 0.001 deg ("4 6"); what is wrong with the mains ("144 cross_check disturbed"); tolerance of the closing angle,
  /// 0.001 deg.
  std::string hertz, phase_u, phase_faults, tolerance;
  std::string gate;   ///< "1": it energises the coil; "": not known
  std::string relay;  ///< "1": the safety relay is told to close; "": not known
  std::string ready;  ///< whether it would arm now: "yes", or why not; "": not known

  /// The coil is on, or could be without another command of its owner.
  bool live() const { return state == "armed" || state == "firing"; }
  bool operator==(const RigStatus&) const = default;
};

/// A second line to a rig, for whoever looks on. It takes no lease and can do one thing: switch the coil off. One
/// thread at a time.
class RigWatch {
 public:
  /// Throws RigError within `limit`. `request`: time for one answer.
  explicit RigWatch(const std::string& uri, std::chrono::milliseconds limit,
                    std::chrono::milliseconds request = std::chrono::milliseconds(1000));
  ~RigWatch();
  RigWatch(const RigWatch&) = delete;
  RigWatch& operator=(const RigWatch&) = delete;

  // each throws RigError: the line is of no use any more
  RigInfo info();
  RigStatus status();
  std::string state();
  /// Newest conversion of each channel of the channel table, counts; a channel that is not there is left out.
  std::vector<std::pair<Channel, double>> latest();
  /// Of one channel, counts; throws RigError too where it tells none.
  double newest(Channel);
  std::vector<std::pair<std::string, std::string>> attributes();
  /// Coil off, whoever owns the rig. The rig has taken the command; state() tells what came of it.
  void stop();

 private:
  struct Impl;
  std::unique_ptr<Impl> impl_;
};

}  // namespace powbench::rigs
