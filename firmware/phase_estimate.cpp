#include "firmware/phase_estimate.h"

#include <bit>

#include "firmware/math.h"

namespace powbench::firmware {

namespace {

/// Turns, [0, 1), as a fraction of 2^64; what is below 2^-64 is cut off. Integers only: a processor without
/// double precision would call a library for the conversion.
std::uint64_t phase_word(float turns) {
  const auto bits = std::bit_cast<std::uint32_t>(turns) & 0x7FFFFFFFU;  // 0 may come as -0
  const auto exponent = static_cast<std::int32_t>(bits >> 23);
  const std::uint64_t mantissa = (bits & 0x7FFFFFU) | 0x800000U;
  // value = mantissa 2^(exponent - 150), to be multiplied by 2^64
  const std::int32_t shift = exponent - 86;
  if (exponent == 0 || shift <= -24) return 0;
  return shift >= 0 ? mantissa << shift : mantissa >> -shift;
}

}  // namespace

float PhaseEstimate::deviation(float horizon) const {
  if (!(variance >= 0.0F) || !(variance_ahead >= 0.0F)) return 1.0F;  // not a number: nothing is known
  // What is not in the model grows with the square of the time since the middle of the window.
  constexpr float age = 0.020F;
  constexpr float ahead = (ahead_seconds + age) / age;
  const float there = (horizon > 0.0F ? horizon + age : age) / age;
  const float growth = (there * there * there * there - 1.0F) / (ahead * ahead * ahead * ahead - 1.0F);
  const float more = variance_ahead > variance ? variance_ahead - variance : 0.0F;
  return square_root(variance + growth * more);
}

PhaseInstant next_instant(const PhaseEstimate& estimate, float rate, CentiDegrees target,
                          std::int64_t earliest) {
  // Phase in a 64-bit word, one turn = 2^64: whole turns fall off by themselves, however far away `earliest`
  // is.
  const float slope = estimate.frequency_rate;
  const std::int64_t distance = earliest - estimate.sample;
  const auto horizon = static_cast<std::int32_t>(rate_horizon * rate);
  const auto curved =
      static_cast<std::int32_t>(distance > horizon ? horizon : (distance < -horizon ? -horizon : distance));
  const float curved_time = static_cast<float>(curved) / rate;
  const float there_hertz = clamp_hertz(estimate.frequency + slope * curved_time);
  const std::uint64_t phase =
      phase_word(estimate.phase_turns) +
      static_cast<std::uint64_t>(std::int64_t{curved}) * phase_word(estimate.frequency / rate) +
      phase_word(wrap_turns(0.5F * slope * curved_time * curved_time)) +
      static_cast<std::uint64_t>(distance - curved) * phase_word(there_hertz / rate);
  const std::uint64_t wanted = phase_word(static_cast<float>(target) / static_cast<float>(full_turn_centi));
  const auto ahead = static_cast<std::uint32_t>((wanted - phase) >> 40U);
  const float turns = static_cast<float>(ahead) * 0x1p-24F;
  const float bend = distance < horizon ? 0.5F * slope : 0.0F;
  float time = turns / there_hertz;
  time = turns / (there_hertz + bend * time);
  const float samples = time * rate;
  const auto whole = static_cast<std::int32_t>(samples);
  return {earliest + whole, samples - static_cast<float>(whole)};
}

}  // namespace powbench::firmware
