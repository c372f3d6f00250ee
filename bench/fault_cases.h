#pragma once

#include <array>
#include <string>
#include <string_view>

#include "bench/fault_bench.h"

/// The faults, injected into a running bench at any phase of the mains and in any state of a shot.

namespace powbench::bench {

/// Where the shot stands when the fault appears. In `idle` and `armed` the host goes on as if nothing were
/// wrong: it arms and fires right after.
enum class Start { idle, armed, scheduled, energised };
inline constexpr std::array<std::string_view, 4> start_names{"idle", "armed", "scheduled", "energised"};

struct CaseResult {
  bool passed = false;
  double reaction_us = 0;  ///< from the cause until the coil is off for good and the core knows it
  std::string why;         ///< what went wrong
};

class FaultCases {
 public:
  FaultCases();
  /// `phase`: of the mains at the injection, whole degrees, 0 .. 359.
  CaseResult run(firmware::Fault, Start, int phase);

 private:
  void arm_with(int centi_degrees, std::int64_t hold_ms);
  void start(firmware::Fault, Start, int phase);
  CaseResult judge_latched(firmware::Fault, Start);
  CaseResult phase_invalid(Start);
  CaseResult blocks_stop(Start);
  CaseResult bad_parameter(Start);
  CaseResult double_fire(Start);
  CaseResult deadline_missed(Start);
  CaseResult relay_welded();
  CaseResult relay_open(Start);
  CaseResult clean_reset();
  CaseResult ignored(Start);
  CaseResult finished_shot(firmware::Fault, Start);
  bool run_until_over(std::int64_t most);

  FaultBench bench_;
  FaultBench::Snapshot idle_, armed_, energised_, energised_long_;
  std::int64_t at_ = 0;           ///< sample of the injection
  std::int64_t asked_at_ = 0;     ///< from when on there is a shot
  std::uint32_t ons_before_ = 0;  ///< times the pin had gone on before it
};

}  // namespace powbench::bench
