#include "firmware/mains_ring.h"

namespace powbench::firmware {

namespace {
constexpr int slope_base = 2;           ///< samples the slope of the line is taken over
constexpr float median_step = 0.0004F;  ///< of nominal amplitude: a tenth of it in 25 ms
constexpr float usual_factor = 4.0F, repeated_factor = 7.0F;
constexpr float repeated_threshold = 0.03F;  ///< of nominal amplitude: where one notch is, there are more
constexpr int remembered = 110;              ///< samples
constexpr float wander = 0.02F, repeated_wander = 0.012F;  ///< of nominal amplitude and sample
constexpr float altered_gain = 0.005F;                     ///< a sample: remembered for a cycle

float magnitude(float x) {
  return x < 0.0F ? -x : x;
}
}  // namespace

void MainsRing::reset() {
  count_ = 0;
  open_ = 0;
  returned_ = 0;
  quiet_ = slope_base + 2;
  usual_ = altered_ = 0.0F;
  recent_ = seen_ = 0;
}

float MainsRing::threshold() const {
  const float least = usual_factor * usual_;
  const float alone = notch_threshold > least ? notch_threshold : least;
  if (!repeated()) return alone;
  const float doubtless = repeated_factor * usual_;
  const float among_others = repeated_threshold > doubtless ? repeated_threshold : doubtless;
  return among_others < alone ? among_others : alone;
}

float MainsRing::hidden() const {
  const float beyond = repeated_factor * usual_ - repeated_threshold;
  return repeated() && beyond > 0.0F ? beyond : 0.0F;
}

void MainsRing::push(float raw) {
  ++count_;
  slot(0) = raw;
  if (quiet_ > 0) {
    --quiet_;
    return;
  }
  if (open_ == 0) {
    // The sample just before a notch may hold part of it, so the line ends one sample earlier.
    anchor_ = back(2);
    slope_ = (back(2) - back(2 + slope_base)) / static_cast<float>(slope_base);
    depth_ = magnitude(raw - (anchor_ + 2.0F * slope_));
    usual_ += depth_ > usual_ ? median_step : -median_step;
    altered_ -= altered_ * altered_gain;
    const bool small = depth_ <= threshold();
    if (recent_ > 0) --recent_;
    if (small) return;
    raw_[0] = back(1);
    raw_[1] = raw;
    open_ = 2;
    returned_ = 0;
    slot(1) = anchor_ + slope_;
    slot(0) = anchor_ + 2.0F * slope_;
    return;
  }
  raw_[static_cast<std::uint32_t>(open_)] = raw;
  ++open_;
  const float line = anchor_ + static_cast<float>(open_) * slope_;
  const float distance = magnitude(raw - line);
  if (distance > depth_) depth_ = distance;
  // The line leaves the wave the further the longer the notch.
  const float reach = threshold() + (repeated() ? repeated_wander : wander) * static_cast<float>(open_);
  const bool back_again = distance <= reach || distance <= 0.5F * depth_;
  returned_ = back_again ? returned_ + 1 : 0;
  if (returned_ == 2) {
    close_notch();
  } else if (open_ == (repeated() ? longest_notch : usual_notch) + 2) {
    give_up();
  } else {
    slot(0) = line;
  }
}

void MainsRing::close_notch() {
  note_notch();
  const float end = raw_[static_cast<std::uint32_t>(open_ - 1)];
  const auto length = static_cast<float>(open_);
  const float chord = (end - anchor_) / length;
  const float bend = (chord - slope_) / (length + static_cast<float>(slope_base));
  for (int i = 1; i < open_; ++i) {
    const auto u = static_cast<float>(i);
    const float repaired = anchor_ + u * (chord + bend * (u - length));
    slot(open_ - i) = repaired;
    altered_ += (magnitude(raw_[static_cast<std::uint32_t>(i - 1)] - repaired) - altered_) * altered_gain;
  }
  slot(0) = end;
  open_ = 0;
  quiet_ = 1;
}

void MainsRing::note_notch() {
  if (depth_ <= notch_threshold) return;
  seen_ = recent_ > 0 ? seen_ + 1 : 1;
  recent_ = remembered;
}

void MainsRing::give_up() {
  note_notch();
  for (int i = 0; i < open_; ++i) slot(open_ - 1 - i) = raw_[static_cast<std::uint32_t>(i)];
  open_ = 0;
  quiet_ = slope_base + 2;
}

}  // namespace powbench::firmware
