#include "bench/phase_calibration.h"

namespace powbench::bench {

namespace {

double signed_degrees(double a, double b) {
  const double turns = a - b;
  return (turns - std::floor(turns + 0.5)) * 360.0;
}

double ahead_turns(const PhaseSay& say, double horizon) {
  return say.turns + say.hertz * horizon + 0.5 * say.rate * horizon * horizon;
}

/// A shot that waits for its angle as fire control does: the instant is refined with every estimate until it is due.
struct WaitingShot {
  double ready = 0;  ///< s
  double delay = 0;  ///< s from the edge to the touch that is aimed at
  CentiDegrees angle = 0;
};

WaitingShot next_shot(Random& random, double after) {
  static constexpr double delays[] = {0.0, 0.012, 0.025};
  return {after + 0.01 + 0.04 * random.uniform(), delays[random.below(3)],
          static_cast<CentiDegrees>(random.below(36000))};
}

/// Fires when the touch, predicted by this estimate, is due within the next millisecond.
void maybe_fire(FamilyScore& score, const CaseSource& source, const firmware::PhaseEstimate& estimate,
                double t, Random& random, WaitingShot& shot) {
  if (t < shot.ready) return;
  const auto horizon = static_cast<float>(shot.delay + 0.001);
  if (!estimate.valid(horizon, static_cast<float>(stated_tolerance / 360))) return;
  const auto earliest = estimate.sample + 1 + static_cast<std::int64_t>(shot.delay * mains_rate);
  const auto instant = firmware::next_instant(estimate, static_cast<float>(mains_rate), shot.angle, earliest);
  if (instant.sample >= earliest + samples_per_say) return;
  const double at =
      (static_cast<double>(instant.sample) + static_cast<double>(instant.fraction)) / mains_rate;
  if (at < case_seconds + 0.1 && !source.breaks(t, at)) {
    const double error = std::abs(signed_degrees(source.phase(at), shot.angle / 36000.0));
    const double u = 360.0 * static_cast<double>(estimate.deviation(static_cast<float>(at - t)));
    ++score.shots;
    score.shots_beyond += error > stated_tolerance ? 1 : 0;
    const bool outside = error > stated_tolerance + 3 * u;
    score.shots_outside += outside ? 1 : 0;
    score.shots_outside_later += outside && !source.breaks(t - unknowable_break, t) ? 1 : 0;
    score.worst_shot = std::max(score.worst_shot, error);
  }
  shot = next_shot(random, t);
}

}  // namespace

void FamilyScore::add(const FamilyScore& o) {
  judged += o.judged;
  valid += o.valid;
  valid_soon += o.valid_soon;
  beyond += o.beyond;
  surprised += o.surprised;
  for (int i = 0; i < 3; ++i) now[i].add(o.now[i]), ahead[i].add(o.ahead[i]);
  valid_now.add(o.valid_now);
  valid_ahead.add(o.valid_ahead);
  u_now.add(o.u_now);
  u_ahead.add(o.u_ahead);
  fair_now.add(o.fair_now);
  fair_ahead.add(o.fair_ahead);
  beyond_later += o.beyond_later;
  shots += o.shots;
  shots_beyond += o.shots_beyond;
  shots_outside += o.shots_outside;
  shots_outside_later += o.shots_outside_later;
  worst_shot = std::max(worst_shot, o.worst_shot);
}

FamilyScore judge_case(const MainsCase& drawn) {
  CaseSource source(drawn);
  OurTracker ours;
  SogiPeer sogi;
  ZeroCrossPeer crossing;
  Random random(drawn.seed + 5);
  FamilyScore score;
  score.family = drawn.family;
  WaitingShot shot = next_shot(random, case_settles);
  const auto samples = static_cast<std::int64_t>(case_seconds * mains_rate);
  for (std::int64_t n = 0; n < samples; ++n) {
    const std::int16_t counts = source.next();
    ours.push(counts);
    sogi.push(counts);
    crossing.push(counts);
    const double t = static_cast<double>(n) / mains_rate;
    if ((n + 1) % samples_per_say != 0 || t < case_settles) continue;
    const PhaseSay says[3] = {ours.say(), sogi.say(), crossing.say()};
    const double truth = source.phase(t), later = source.phase(t + look_ahead);
    const bool fair = !source.breaks(t - after_break, t + look_ahead);
    for (int i = 0; i < 3; ++i) {
      if (!fair) continue;
      score.now[i].add(signed_degrees(says[i].turns, truth));
      score.ahead[i].add(signed_degrees(ahead_turns(says[i], look_ahead), later));
    }
    ++score.judged;
    const firmware::PhaseEstimate& estimate = ours.tracker.estimate();
    const auto tolerance = static_cast<float>(stated_tolerance / 360);
    score.valid_soon += estimate.valid(0.001F, tolerance) ? 1 : 0;
    maybe_fire(score, source, estimate, t, random, shot);
    if (!estimate.valid(static_cast<float>(look_ahead), tolerance)) continue;
    ++score.valid;
    const double error_now = signed_degrees(says[0].turns, truth);
    const double error_ahead = signed_degrees(ahead_turns(says[0], look_ahead), later);
    const bool wrong = std::abs(error_ahead) > stated_tolerance;
    const bool unforeseen = source.breaks(t, t + look_ahead);
    (unforeseen ? score.surprised : score.beyond) += wrong ? 1 : 0;
    if (unforeseen) continue;
    const bool knowable =
        !source.breaks(t - unknowable_break, t) && !source.onsets(t - unknowable_onset, t + look_ahead);
    score.beyond_later += wrong && knowable ? 1 : 0;
    score.valid_now.add(error_now);
    score.valid_ahead.add(error_ahead);
    const double u_now = 360.0 * static_cast<double>(estimate.deviation(0.0F));
    const double u_ahead = 360.0 * static_cast<double>(estimate.deviation(static_cast<float>(look_ahead)));
    score.u_now.add(error_now, u_now);
    score.u_ahead.add(error_ahead, u_ahead);
    if (!knowable) continue;
    score.fair_now.add(error_now, u_now);
    score.fair_ahead.add(error_ahead, u_ahead);
  }
  return score;
}

}  // namespace powbench::bench
