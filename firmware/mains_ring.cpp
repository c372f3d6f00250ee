#include "firmware/mains_ring.h"

namespace powbench::firmware {

namespace {
constexpr int slope_base = 2;    ///< samples the slope of the line is taken over
constexpr float wander = 0.02F;  ///< of nominal amplitude and sample

float magnitude(float x) {
  return x < 0.0F ? -x : x;
}
}  // namespace

void MainsRing::reset() {
  count_ = 0;
  open_ = 0;
  returned_ = 0;
  quiet_ = slope_base + 2;
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
    if (depth_ <= notch_threshold) return;
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
  const float reach = notch_threshold + wander * static_cast<float>(open_);
  const bool back_again = distance <= reach || distance <= 0.5F * depth_;
  returned_ = back_again ? returned_ + 1 : 0;
  if (returned_ == 2) {
    close_notch();
  } else if (open_ == final_age) {
    give_up();
  } else {
    slot(0) = line;
  }
}

void MainsRing::close_notch() {
  const float end = raw_[static_cast<std::uint32_t>(open_ - 1)];
  const auto length = static_cast<float>(open_);
  const float chord = (end - anchor_) / length;
  const float bend = (chord - slope_) / (length + static_cast<float>(slope_base));
  for (int i = 1; i < open_; ++i) {
    const auto u = static_cast<float>(i);
    slot(open_ - i) = anchor_ + u * (chord + bend * (u - length));
  }
  slot(0) = end;
  open_ = 0;
  quiet_ = 1;
}

void MainsRing::give_up() {
  for (int i = 0; i < open_; ++i) slot(open_ - 1 - i) = raw_[static_cast<std::uint32_t>(i)];
  open_ = 0;
  quiet_ = slope_base + 2;
}

}  // namespace powbench::firmware
