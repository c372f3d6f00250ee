#include "firmware/sogi.h"

#include "firmware/math.h"

namespace powbench::firmware {

namespace {
constexpr float two_pi = 6.28318531F;
constexpr float lowest_hertz = 40.0F;
constexpr float highest_hertz = 70.0F;
constexpr float lost_amplitude = 0.05F;  ///< of nominal: below it the loop coasts
constexpr float found_amplitude = 0.4F;  ///< then it starts again at the angle of the integrators
}  // namespace

SogiPll::SogiPll(const Config& config) : config_(config), period_(1.0F / config.rate) {
  // Loop in turns: theta' = f + kp s, s = 2 pi (phi - theta): natural frequency w0 and damping 0.707.
  const float w0 = two_pi * config.loop_hertz;
  proportional_ = 1.41421356F * w0 / two_pi;
  integral_ = w0 * w0 / two_pi * period_;
  reset();
}

void SogiPll::reset() {
  direct_ = quadrature_ = offset_ = theta_ = 0.0F;
  hertz_ = config_.nominal_hertz;
  lost_ = true;
}

void SogiPll::push(float value) {
  const float step = two_pi * hertz_ * period_;
  const float error = value - direct_ - offset_;
  direct_ += config_.gain * step * error;
  offset_ += config_.offset_gain * step * error;
  const float square = step * step;
  const float cosine = 1.0F - square * (0.5F - square * (1.0F / 24.0F));
  const float sine = step * (1.0F - square * (1.0F / 6.0F - square * (1.0F / 120.0F)));
  const float direct = cosine * direct_ - sine * quadrature_;
  quadrature_ = sine * direct_ + cosine * quadrature_;
  direct_ = direct;

  theta_ += hertz_ * period_;
  const float size = amplitude();
  if (size < lost_amplitude) lost_ = true;
  if (lost_ && size > found_amplitude) {
    lost_ = false;
    theta_ = atan2_turns(direct_, -quadrature_);
  }
  if (!lost_) {
    const float slip = (direct_ * cos_turns(theta_) + quadrature_ * sin_turns(theta_)) / size;
    theta_ += proportional_ * slip * period_;
    hertz_ += integral_ * slip;
    if (hertz_ < lowest_hertz) hertz_ = lowest_hertz;
    if (hertz_ > highest_hertz) hertz_ = highest_hertz;
  }
  theta_ = wrap_turns(theta_);
}

float SogiPll::turns() const {
  return wrap_turns(theta_ - hertz_ * period_);
}

float SogiPll::amplitude() const {
  return square_root(direct_ * direct_ + quadrature_ * quadrature_);
}

}  // namespace powbench::firmware
