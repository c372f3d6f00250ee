#include "firmware/interlocks.h"

namespace powbench::firmware {

std::string_view reason(Fault fault) {
  switch (fault) {
    case Fault::none:
      return "no fault";
    case Fault::mains_lost:
      return "mains lost: check the supply, then write 1 to abort";
    case Fault::phase_invalid:
      return "mains phase not valid for 1 s: see phase_faults, then write 1 to abort";
    case Fault::coil_overcurrent:
      return "coil current above the trip level: check the coil, then write 1 to abort";
    case Fault::coil_stuck_on:
      return "coil current flows with the gate off: switch the supply off and replace the coil switch";
    case Fault::coil_not_energising:
      return "no coil current after the gate: check the coil circuit, then write 1 to abort";
    case Fault::samples_lost:
      return "converter samples were lost: the record is void, write 1 to abort and fire again";
    case Fault::emergency_stop:
      return "emergency stop is open: close it, then write 1 to abort";
  }
  return "unknown fault";
}

void Interlocks::reset(std::int64_t sample) {
  last_mains_ = sample;
  over_ = 0;
}

Fault Interlocks::check(const Block& block, bool gate_on, std::int64_t gate_since) {
  Fault fault = Fault::none;
  if (next_sample_ >= 0 && block.first_sample != next_sample_) fault = Fault::samples_lost;
  next_sample_ = block.first_sample + block.samples();

  for (std::int64_t i = 0; i < block.samples(); ++i) {
    const std::int64_t sample = block.first_sample + i;
    const std::int32_t mains = block.at(i, Channel::mains_voltage);
    const std::int32_t current = block.at(i, Channel::coil_current);
    const std::int32_t magnitude = current < 0 ? -current : current;
    if ((mains < 0 ? -mains : mains) > config_.mains_lost_counts) last_mains_ = sample;
    if (magnitude > config_.no_current_counts) last_current_ = sample;
    over_ = magnitude > config_.overcurrent_counts ? over_ + 1 : 0;
    if (over_ >= 2) fault = Fault::coil_overcurrent;
  }
  if (fault != Fault::none) return fault;

  const std::int64_t now = next_sample_;
  if (block.emergency_stop) return Fault::emergency_stop;
  if (now - last_mains_ > config_.mains_lost_samples) return Fault::mains_lost;
  const std::int64_t since = now - gate_since;
  if (gate_on && since > config_.no_current_samples && last_current_ < gate_since)
    return Fault::coil_not_energising;
  if (!gate_on && since > config_.stuck_on_samples && now - last_current_ < block.samples() + 1)
    return Fault::coil_stuck_on;
  return Fault::none;
}

}  // namespace powbench::firmware
