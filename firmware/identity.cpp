#include "firmware/identity.h"

#include <bit>

#include "core/crc32.h"

namespace powbench::firmware {

namespace {

class Sum {
 public:
  [[gnu::noinline]] Sum& add(std::int64_t value) {
    std::uint8_t bytes[8];
    for (int i = 0; i < 8; ++i)
      bytes[i] = static_cast<std::uint8_t>(static_cast<std::uint64_t>(value) >> (8 * i) & 0xFFU);
    crc_ = crc32(bytes, crc_);
    return *this;
  }
  Sum& add(float value) { return add(std::int64_t{std::bit_cast<std::uint32_t>(value)}); }
  std::uint32_t value() const { return crc_; }

 private:
  std::uint32_t crc_ = 0;
};

}  // namespace

std::uint32_t config_crc32(const ControllerConfig& c) {
  Sum sum;
  sum.add(c.sample_rate).add(c.record_length).add(c.pretrigger);
  for (const ChannelCalibration& k : c.calibration)
    sum.add(k.scale_pico)
        .add(k.delay_ns)
        .add(k.corner_microhertz)
        .add(k.film_area_pico)
        .add(k.sensitivity_femto)
        .add(k.zero_counts);
  for (const char letter : c.calibration_id) sum.add(std::int64_t{static_cast<unsigned char>(letter)});
  sum.add(c.phase.sample_rate).add(c.phase.nominal_amplitude).add(c.phase.nominal_hertz);
  const FireConfig& f = c.fire;
  sum.add(f.sample_rate).add(f.hold_limit_ms).add(f.gate_delay_samples_256).add(f.lead_samples);
  sum.add(f.phase_timeout_samples).add(f.phase_age_samples).add(f.quiet_samples);
  const BudgetConfig& b = f.budget;
  sum.add(b.operations_per_minute).add(b.pause_samples).add(b.heat_samples).add(b.duty_per_mille);
  const InterlockConfig& i = c.interlocks;
  sum.add(std::int64_t{i.overcurrent_counts}).add(std::int64_t{i.current_zero_counts});
  sum.add(std::int64_t{i.no_current_counts}).add(i.no_current_samples).add(i.stuck_on_samples);
  sum.add(std::int64_t{i.mains_lost_counts}).add(i.mains_lost_samples).add(i.heartbeat_samples);
  sum.add(std::int64_t{i.contact_open_counts}).add(i.contact_open_samples).add(i.weld_samples);
  sum.add(std::int64_t{i.travel_least_counts}).add(std::int64_t{i.travel_most_counts});
  sum.add(std::int64_t{i.travel_open_counts}).add(std::int64_t{i.travel_closed_counts});
  sum.add(i.implausible_samples).add(std::int64_t{i.saturation_counts});
  return sum.value();
}

}  // namespace powbench::firmware
