#include "firmware/controller.h"

namespace powbench::firmware {

std::string_view config_error(const ControllerConfig& c, std::size_t storage_values) {
  const InterlockConfig& i = c.interlocks;
  const BudgetConfig& b = c.fire.budget;
  if (c.sample_rate < 20'000 || c.sample_rate > 1'000'000) return "sample_rate outside 20000 .. 1000000 Hz";
  if (c.fire.sample_rate != c.sample_rate || c.phase.sample_rate != static_cast<float>(c.sample_rate))
    return "sample rates of fire control and phase tracker differ from the converter's";
  if (c.record_length <= 0 || c.pretrigger < 0 || c.pretrigger > c.record_length)
    return "pretrigger outside 0 .. record_length";
  if (storage_values / channel_count < static_cast<std::size_t>(c.record_length))
    return "record_length does not fit into the memory";
  if (!(c.phase.nominal_amplitude > 0.0F && c.phase.nominal_amplitude < 32768.0F))
    return "nominal_amplitude outside 0 .. 32767 counts";
  if (c.fire.hold_limit_ms < 1 || c.fire.hold_limit_ms > 10'000) return "hold_limit_ms outside 1 .. 10000";
  if (c.fire.gate_delay_samples_256 < 0) return "gate delay below 0";
  if (i.no_current_counts <= 0 || i.overcurrent_counts <= i.no_current_counts ||
      i.overcurrent_counts > 32'767)
    return "current thresholds not in the order 0 < no_current < overcurrent <= 32767";
  if (i.mains_lost_counts <= 0 || i.mains_lost_samples <= 0) return "mains_lost thresholds not above 0";
  if (i.no_current_samples <= 0 || i.stuck_on_samples <= 0) return "coil time limits not above 0";
  if (i.heartbeat_samples <= 0) return "heartbeat_samples not above 0";
  if (b.operations_per_minute < 0 ||
      b.operations_per_minute > static_cast<std::int64_t>(DutyBudget::most_operations))
    return "operations_per_minute outside 0 .. 64";
  if (b.pause_samples < 0 || b.heat_samples < 0 || b.duty_per_mille < 0 || b.duty_per_mille > 1000)
    return "budget outside its range";
  return {};
}

}  // namespace powbench::firmware
