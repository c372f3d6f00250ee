#pragma once

#include <cstdint>
#include <string_view>

#include "core/phase.h"
#include "firmware/gate.h"
#include "firmware/interlocks.h"
#include "firmware/phase_tracker.h"
#include "firmware/recorder.h"

/// The state machine between a command and the coil: armed, told to fire, waiting for the angle, energised,
/// recorded.

namespace powbench::firmware {

enum class State : std::uint8_t { idle, armed, firing, captured, fault };
std::string_view name(State);

/// Answer to a command: accepted, or why not.
enum class Refusal : std::uint8_t { accepted, wrong_state, out_of_range, faulted };

struct FireConfig {
  std::int64_t sample_rate = 100'000;   ///< Hz
  std::int64_t hold_limit_ms = 10'000;  ///< hard cap of the on-time
  std::int64_t gate_delay_samples_256 =
      0;                          ///< gate command to coil voltage, 1/256 sample: the edge is advanced by it
  std::int64_t lead_samples = 0;  ///< time the port needs from the end of a block until it can make an edge
  std::int64_t phase_timeout_samples = 100'000;  ///< longest wait for a valid phase after fire
  std::int64_t quiet_samples =
      500;  ///< current must have been absent this long before the shot counts as over
};

class FireControl {
 public:
  FireControl(const FireConfig&, Interlocks&, PhaseTracker&, Recorder&);

  /// Sets the complete state for one shot. Refused while firing or in fault.
  Refusal arm();
  /// Back to idle; refused while firing.
  Refusal disarm();
  /// Spends the token that arm() gave: the coil will be energised at the next valid instant. Returns at once.
  Refusal fire();
  /// Coil off, back to idle; clears a fault when its cause is gone.
  void abort();
  Refusal set_closing_angle(std::int64_t centi_degrees);
  Refusal set_hold_time_ms(std::int64_t ms);

  /// After each block: checks, scheduling, state changes. Edges for the output compare: those before the end
  /// of the block that follows, and the port's lead before that.
  std::span<const GateEdge> step(const Block&);

  State state() const { return state_; }
  Fault fault() const { return fault_; }
  std::string_view last_error() const { return last_error_; }
  bool gate_on() const { return gate_.on(); }
  CentiDegrees closing_angle() const { return closing_angle_; }
  std::int64_t hold_time_ms() const { return hold_time_ms_; }
  std::uint32_t shots_armed() const { return shots_armed_; }
  const PhaseEstimate& phase() const { return tracker_.estimate(); }
  /// Sample index of the rising zero crossing next before the gate edge, by the estimate the edge was
  /// scheduled from.
  std::int64_t zero_cross_sample() const { return zero_cross_sample_; }

 private:
  void trip(Fault, std::int64_t next_sample);
  void schedule(const Block&);
  void note_gate_change(std::span<const GateEdge>);
  Refusal refuse(Refusal, std::string_view why);

  FireConfig config_;
  Interlocks& interlocks_;
  PhaseTracker& tracker_;
  Recorder& recorder_;
  Gate gate_;
  State state_ = State::idle;
  Fault fault_ = Fault::none;
  std::string_view last_error_ = "no error";
  CentiDegrees closing_angle_ = 0;
  std::int64_t hold_time_ms_ = 100;
  std::uint32_t shots_armed_ = 0;
  bool token_ = false;    ///< armed and not yet fired
  bool fired_ = false;    ///< the token is spent, the edge not yet committed
  bool planned_ = false;  ///< a crossing has been chosen; only its instant is refined
  std::int64_t fired_at_ = 0;
  Tick plan_{};                      ///< gate edge as predicted by the latest estimate
  std::int64_t next_sample_ = 0;     ///< first sample not yet seen
  std::int64_t tracker_origin_ = 0;  ///< sample index of the tracker's sample 0
  std::int64_t gate_since_ = 0;
  std::int64_t zero_cross_sample_ = 0;
};

}  // namespace powbench::firmware
