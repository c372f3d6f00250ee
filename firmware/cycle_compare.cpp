#include "firmware/cycle_compare.h"

#include "firmware/math.h"

namespace powbench::firmware {

namespace {
constexpr float adaption = 0.01F;        ///< a block: a tenth of a second
constexpr float slip_share = 0.3F;       ///< of q: more than a jump shows when a cycle has not quite passed
constexpr float least_doubt = 0.05F;     ///< of the rms of the rest
constexpr float strange_factor = 10.0F;  ///< of the usual mean square of the rest

float magnitude(float x) {
  return x < 0.0F ? -x : x;
}
float square(float x) {
  return x * x;
}
}  // namespace

void CycleCompare::reset() {
  sum_ = 0.0F;
  samples_ = 0;
  ring_.fill({});
  newest_ = 0;
  usual_ = highest_limit;
  usual_rest_ = square(0.01F);
  step_ = other_ = rest_ = jump_ = half_rest_ = half_explained_ = 0.0F;
  since_sudden_ = 0;
  changing_ = false;
  sudden_ = true;
  slips_ = false;
  evidence_ = settled_ = 0.0F;
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

/// Over the newest `cycle` blocks, and over the newer half of them.
void CycleCompare::split(int cycle) {
  float energy = 0.0F;
  float cosine = 0.0F;
  float half_rest = 0.0F;
  float sine = 0.0F;
  int at = newest_;
  for (int i = 1; i <= cycle; ++i) {
    const Block& block = ring_[static_cast<unsigned>(at)];
    energy += square(block.change);
    cosine += block.cosine;
    sine += block.sine;
    at = at == 0 ? longest_cycle - 1 : at - 1;
    if (i != cycle / 2) continue;
    const float share = 1.0F / static_cast<float>(i);
    half_explained_ = 2.0F * square(share * cosine);
    half_rest = share * energy - half_explained_;
  }
  const float share = 1.0F / static_cast<float>(cycle);
  jump_ = 2.0F * share * cosine;
  const float rest = share * energy - 0.5F * square(jump_);
  rest_ = rest > 0.0F ? rest : 0.0F;
  step_ = 2.0F * share * sine;
  const float other = rest - 0.5F * square(step_);
  other_ = other > 0.0F ? other : 0.0F;
  half_rest_ = half_rest > 0.0F ? half_rest : 0.0F;
}

float CycleCompare::doubt() const {
  constexpr float turns = 1.0F / 6.2831853F;
  const float rest = square_root(rest_);
  const float beyond = magnitude(jump_) - jump_leak * rest;
  const float least = least_doubt * rest;
  return square((beyond > least ? beyond : least) * turns);
}

bool CycleCompare::judge(float turns, float cycle) {
  if (samples_ == 0) return false;
  newest_ = (newest_ + 1) % longest_cycle;
  const float change = sum_ / static_cast<float>(samples_);
  ring_[static_cast<unsigned>(newest_)] = {change, change * cos_turns(turns), change * sin_turns(turns)};
  sum_ = 0.0F;
  samples_ = 0;
  float mean = 0.0F;
  float newer = 0.0F;
  int at = newest_;
  for (int i = 0; i < blocks; ++i) {
    mean += square(ring_[static_cast<unsigned>(at)].change);
    if (i == blocks / 2 - 1) newer = mean;
    at = at == 0 ? longest_cycle - 1 : at - 1;
  }
  mean /= static_cast<float>(blocks);
  newer /= static_cast<float>(blocks / 2);
  const auto whole = static_cast<int>(cycle + 0.5F);
  split(whole < longest_cycle ? whole : longest_cycle);

  const float limit = usual_;
  const float wanted = 3.0F * square_root(mean);
  const float bounded =
      wanted < lowest_limit ? lowest_limit : (wanted > highest_limit ? highest_limit : wanted);
  usual_ += adaption * (bounded - usual_);
  const float strange = strange_factor * usual_rest_;
  const float least = square(least_strange);
  const float most = strange > least ? strange : least;
  const bool stranger =
      (rest_ > most && rest_ > square(jump_)) || (half_rest_ > most && half_rest_ > 2.0F * half_explained_);
  usual_rest_ += 2.0F * adaption * (rest_ - usual_rest_);

  const bool sudden = square(change) > square(sudden_limit);
  if (since_sudden_ < longest_cycle) ++since_sudden_;
  if (sudden) since_sudden_ = 0;
  sudden_ = since_sudden_ <= whole || rest_ > square(highest_limit);
  const float slip = square_root(2.0F * half_explained_) - magnitude(jump_);
  slips_ = slip > slip_limit + slip_share * magnitude(jump_) && rest_ < 0.5F * square(jump_);
  evidence_ = square(jump_) / (square(jump_limit) + square(jump_leak) * rest_);
  settled_ = square(jump_) / (square(jump_limit) + square(jump_leak) * other_ + square(step_leak * step_));
  const bool kept = !sudden && mean <= square(limit);
  changing_ = (!kept && newer > square(limit)) || stranger;
  return kept;
}

}  // namespace powbench::firmware
