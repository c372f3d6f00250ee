#include "firmware/beat_watch.h"

#include "firmware/math.h"

namespace powbench::firmware {

namespace {
constexpr float two_pi = 6.2831853F;
constexpr float fewest = 250.0F;        ///< products
constexpr float least_share = 3.0e-4F;  ///< rms, of the amplitude
constexpr float least_likeness = 0.5F, sure_likeness = 0.9F;
constexpr float most_unequal = 2.0F;  ///< mean squares of d p and d a
constexpr float followed = 0.54F;     ///< 4 sin^2(wD/2) at 6 Hz and D = 20 ms: faster beats are averaged out
}  // namespace

void BeatWatch::reset() {
  at_ = 0;
  filled_ = 0;
  count_ = 0.0F;
  usual_ = mean_a_ = mean_p_ = a_a_ = p_p_ = d_d_ = p_a_ = 0.0F;
  variance_ = 0.0F;
}

void BeatWatch::push(float amplitude, std::uint32_t phase, std::uint32_t step) {
  at_ = (at_ + 1) % slots;
  amplitude_[at_] = amplitude;
  phase_[at_] = phase;
  if (filled_ <= lag) ++filled_;
  if (filled_ <= lag) return;
  if (usual_ <= 0.0F) {
    usual_ = amplitude;
    step_ = step;
  }
  if (count_ < memory) count_ += 1.0F;
  const float gain = 1.0F / count_;
  const unsigned before = (at_ + slots - lag) % slots, middle = (at_ + slots - lag / 2) % slots;
  const float a = amplitude_[middle] / usual_ - 1.0F;
  const float d = (amplitude - amplitude_[before]) / usual_;
  const auto moved =
      static_cast<std::int32_t>(phase - phase_[before] - step_ * static_cast<std::uint32_t>(lag));
  const float p = static_cast<float>(moved) * (two_pi * 0x1p-32F);
  mean_a_ += (a - mean_a_) * gain;
  mean_p_ += (p - mean_p_) * gain;
  a_a_ += (a * a - a_a_) * gain;
  p_p_ += (p * p - p_p_) * gain;
  d_d_ += (d * d - d_d_) * gain;
  p_a_ += (p * a - p_a_) * gain;

  variance_ = 0.0F;
  const float own = a_a_ - mean_a_ * mean_a_;
  if (count_ < fewest || own < least_share * least_share) return;
  const float p_p = p_p_ - mean_p_ * mean_p_, p_a = p_a_ - mean_p_ * mean_a_;
  if (p_p > most_unequal * d_d_ || d_d_ > most_unequal * p_p) return;
  const float likeness = p_a * p_a / (p_p * own);
  if (likeness <= least_likeness) return;
  const float sure = (likeness - least_likeness) * (1.0F / (sure_likeness - least_likeness));
  const float fast = d_d_ / own * (1.0F / followed);
  variance_ = (sure < 1.0F ? sure : 1.0F) * own / ((1.0F + fast * fast) * (two_pi * two_pi));
}

}  // namespace powbench::firmware
