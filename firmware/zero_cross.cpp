#include "firmware/zero_cross.h"

#include "firmware/math.h"

namespace powbench::firmware {

namespace {
constexpr float two_pi = 6.28318531F;
constexpr float longest_wait = 1.0e6F;  ///< samples; the age stops counting here
}  // namespace

ZeroCross::ZeroCross(const Config& config) : config_(config) {
  // Pole of a one-pole low-pass by its time constant, backward difference.
  keep_ = 1.0F / (1.0F + two_pi * config.corner_hertz / config.rate);
}

void ZeroCross::reset() {
  first_ = second_ = swing_ = since_last_ = hertz_ = 0.0F;
  half_[0] = half_[1] = 0.0F;
  crossings_ = 0;
}

void ZeroCross::push(float value) {
  const float before = second_;
  first_ = value + keep_ * (first_ - value);
  second_ = first_ + keep_ * (second_ - first_);
  if (since_last_ < longest_wait) since_last_ += 1.0F;
  const float size = second_ < 0.0F ? -second_ : second_;
  const bool crossed = (before < 0.0F) != (second_ < 0.0F);
  if (crossed && swing_ > config_.hysteresis) {
    crossing(second_ / (second_ - before), before < 0.0F);
    swing_ = 0.0F;
  }
  if (size > swing_) swing_ = size;
}

void ZeroCross::crossing(float age, bool rising) {
  half_[1] = half_[0];
  half_[0] = since_last_ - age;
  since_last_ = age;
  last_rising_ = rising;
  if (crossings_ < 4) ++crossings_;
  const float cycle = half_[0] + half_[1];
  if (crossings_ >= 3 && cycle > 0.0F) hertz_ = config_.rate / cycle;
}

float ZeroCross::delay_turns(float hertz) const {
  const float turn = hertz / config_.rate;
  return 2.0F * atan2_turns(keep_ * sin_turns(turn), 1.0F - keep_ * cos_turns(turn));
}

float ZeroCross::turns(float hertz) const {
  const float per_sample = hertz / config_.rate;
  float phase = last_rising_ ? 0.0F : 0.5F;
  float age = since_last_;
  if (config_.cancel_offset) {
    // A trough lies half-way before a rising crossing, a crest half-way before a falling one.
    phase = last_rising_ ? 0.75F : 0.25F;
    age += 0.5F * half_[0];
  }
  return wrap_turns(phase + age * per_sample + delay_turns(hertz));
}

}  // namespace powbench::firmware
