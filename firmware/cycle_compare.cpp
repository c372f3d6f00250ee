#include "firmware/cycle_compare.h"

#include "firmware/math.h"

namespace powbench::firmware {

namespace {
constexpr float adaption = 0.01F;  ///< a block: a tenth of a second
}  // namespace

void CycleCompare::reset() {
  sum_ = 0.0F;
  samples_ = 0;
  mean_square_.fill(0.0F);
  newest_ = 0;
  usual_ = highest_limit;
  changing_ = false;
}

void CycleCompare::push(const MainsRing& mains, float cycle) {
  const auto whole = static_cast<int>(cycle);
  const float part = cycle - static_cast<float>(whole);
  const int age = MainsRing::final_age + whole;
  const float before = mains.back(age) + part * (mains.back(age + 1) - mains.back(age));
  const float difference = mains.back(MainsRing::final_age) - before;
  sum_ += difference;
  ++samples_;
}

bool CycleCompare::judge() {
  if (samples_ == 0) return false;
  newest_ = (newest_ + 1) % blocks;
  const float change = sum_ / static_cast<float>(samples_);
  const float block = change * change;
  mean_square_[static_cast<unsigned>(newest_)] = block;
  sum_ = 0.0F;
  samples_ = 0;
  float mean = 0.0F;
  for (const float square : mean_square_) mean += square;
  mean /= static_cast<float>(blocks);
  const float rms = square_root(mean);
  const float limit = usual_;
  const float wanted = 3.0F * rms;
  const float bounded =
      wanted < lowest_limit ? lowest_limit : (wanted > highest_limit ? highest_limit : wanted);
  usual_ += adaption * (bounded - usual_);
  const bool kept = block <= sudden_limit * sudden_limit && mean <= limit * limit;
  float newer = 0.0F;
  for (int i = 0; i < blocks / 2; ++i)
    newer += mean_square_[static_cast<unsigned>((newest_ - i + blocks) % blocks)];
  changing_ = !kept && newer > static_cast<float>(blocks / 2) * limit * limit;
  return kept;
}

}  // namespace powbench::firmware
