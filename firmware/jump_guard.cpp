#include "firmware/jump_guard.h"

namespace powbench::firmware {

namespace {
constexpr float gain = 0.002F;  ///< a point: 50 ms
constexpr int longest = 1 << 10;
constexpr float at_once_factor = 2.2F;  ///< squared: one point alone
constexpr float least_share = 0.2F;     ///< squared: of the limit, for each point alone
constexpr int notch_edge = 2;           ///< points that a notch yet to open may still take
constexpr float first_usual = 0.02F * 0.02F;

/// The one nearest to 0 of three numbers of one sign; 0 when they have not.
float least_of(float a, float b, float c) {
  if (a < 0.0F) a = -a, b = -b, c = -c;
  const float least = a < b ? (a < c ? a : c) : (b < c ? b : c);
  return least > 0.0F ? least : 0.0F;
}
}  // namespace

void JumpGuard::reset() {
  before_ = {};
  usual_ = first_usual;
  since_ = longest;
  quiet_ = 0;
}

void JumpGuard::push(const MainsRing& mains, float cycle) {
  if (since_ < longest) ++since_;
  if (quiet_ < longest) ++quiet_;
  const bool notched = mains.notched();
  if (notched && mains.notch_open()) return;
  const int age = notched ? notch_edge : 0;
  const auto whole = static_cast<int>(cycle);
  const float part = cycle - static_cast<float>(whole);
  const float before = mains.back(age + whole);
  const float then = before + part * (mains.back(age + whole + 1) - before);
  const float difference = (notched ? mains.back(age) : mains.newest()) - then;
  const float least = least_of(difference, before_[0], before_[1]);
  const float mean = (difference + before_[0] + before_[1]) * (1.0F / 3.0F);
  before_[1] = before_[0];
  before_[0] = difference;
  const float wanted = usual_factor * usual_factor * usual_;
  const float limit = wanted > least_limit * least_limit ? wanted : least_limit * least_limit;
  const float square = mean * mean;
  const bool at_once = !notched && difference * difference > at_once_factor * limit;
  if (at_once || (square > limit && least * least > least_share * limit)) {
    if (quiet_ > whole) since_ = 0;
    quiet_ = 0;
  }
  usual_ += ((square < limit ? square : limit) - usual_) * gain;
}

}  // namespace powbench::firmware
