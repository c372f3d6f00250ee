#include "firmware/phase_bank.h"

namespace powbench::firmware {

namespace {

constexpr float first_expectation = 4.0e-7F;  ///< turns^2: (0.23 deg)^2, until errors have been seen
constexpr float known_after = 50.0F;          ///< errors: then the expectation does not count any more
constexpr float trusted_after = 20.0F;        ///< errors: then a memory may outdo the others
constexpr float longest_count = 200.0F;       ///< errors that the slow mean remembers: 0.4 s
constexpr float quick_gain = 0.04F;           ///< an error: 50 ms
constexpr float largest_square = 1.7e-5F;     ///< turns^2: beyond 1.5 deg nothing is valid anyway
constexpr float deviation_unit = 0x1p-22F;    ///< turns
constexpr float two_pi = 6.2831853F;
constexpr PhaseWord half_turn = 1U << 31;
constexpr float swing_gain = 0.02F;     ///< an update: 50 ms
constexpr float least_swing = 7.0e-9F;  ///< turns^2: (0.03 deg)^2
constexpr float largest_swing = 4.0e-7F;
constexpr float wild_swing = 6.4e-6F;  ///< turns^2: (0.9 deg)^2, more than 3 % half an order away
constexpr float most_left = 0.6F;      ///< |cos| of a swing that is still told from movement
constexpr float swing_own = 0.6F;      ///< of the mean square: the rest is that of the windows judged by
constexpr float swing_left =
    6.0e-4F;  ///< of the square of the swing: what of it is left in the windows judged by
constexpr float white_factor = 1.2F;  ///< of the scatter of amplitudes: that of phases may be chance
/// What recent errors count against the larger of recent and lasting ones: now, 20 ms ahead.
constexpr std::array<float, 2> recent_share = {0.4F, 0.25F};
constexpr float least_variance = 5.0e-13F;
constexpr float test_factor = 9.0F;    ///< of the innovation test: squares
constexpr float surprise_gain = 9.0F;  ///< from the newest cycle to 20 ms ahead, squared
constexpr float least_share = 0.13F;   ///< of the mean square that a long memory is left with
constexpr float revision_factor = 6.0F, revision_share = 0.35F, alarm_decay = 0.95F;
constexpr float now_share = 0.04F;      ///< of an alarm 20 ms ahead, now
constexpr float step_square = 1.9e-4F;  ///< turns^2: (5 deg)^2
constexpr float slope_reach = 40.0F;    ///< updates
constexpr float slope_factor = 30.0F, level_factor = 4.0F;
constexpr float around_share = 0.5F;   ///< of the variance of windows about their level: they overlap
constexpr float level_decay = 0.995F;  ///< an update: the windows behind the change become more
constexpr float slope_free = 8.0e-8F;  ///< turns^2: (0.1 deg)^2
constexpr int scatter_lag = 20;        ///< updates
constexpr int keep_interval = 12;      ///< updates
constexpr std::array<int, 3> lags = {5, 10, 20};  ///< updates

/// What counts of the first expectation after so many errors.
float unproven(float errors) {
  const float rest = 1.0F - errors * (1.0F / known_after);
  return rest > 0.0F ? rest * rest : 0.0F;
}

float fourth_power(float x) {
  return x * x * x * x;
}

}  // namespace

void PhaseBank::Track::add(float square) {
  if (count < longest_count) count += 1.0F;
  const float gain = 1.0F / (count + 2.0F);
  const float limit = 100.0F * (slow + 1.0e-9F);
  slow += ((count > known_after && square > limit ? limit : square) - slow) * gain;
  const float bounded = square < largest_square ? square : largest_square;
  fast += (bounded - fast) * (gain > quick_gain ? gain : quick_gain);
}

void PhaseBank::reset() {
  history_ = {};
  forget_predictions();
  track_ = {};
  kept_ = {};
  since_kept_ = 0;
  innovation_.fill({});
  amplitude_.fill(1.0F);
  phase_scatter_ = amplitude_scatter_ = scatter_count_ = 0.0F;
  said_count_ = 0;
  revision_.fill(0.0F);
  alarm_ = level_doubt_ = 0.0F;
  swing_ = swing_square_ = swing_across_ = 0.0F;
  since_joint_ = 3 * scatter_lag + 1;
  swings_ = false;
  swing_of_.fill(0.0F);
  step_ = 1U << 26;
  bend_ = 0.0F;
}

void PhaseBank::event() {
  forget_predictions();
  if (since_kept_ < 0) return;
  // errors seen since the older state was kept may be those of the event, but smaller ones are not
  for (unsigned h = 0; h < 2; ++h)
    for (unsigned p = 0; p <= predictor_count; ++p)
      if (kept_[1][h][p].worse() < track_[h][p].worse()) track_[h][p] = kept_[1][h][p];
  kept_[1] = track_;
  kept_[0] = kept_[1];
  since_kept_ = -1;
  said_count_ = 0;
  alarm_ = 0.0F;
}

bool PhaseBank::resume(float level, float slope, int count, float around) {
  since_joint_ = count;
  said_count_ = 0;
  // what the slope would be wrong by 20 ms ahead
  const float wrong = slope * slope * slope_reach * slope_reach;
  const float usual = expected_[1] + phase_scatter_;
  const bool fits = wrong <= slope_factor * usual + slope_free;
  // the expectation of this moment already holds what the change did to the newest windows
  const bool moved = level * level > level_factor * (track_[1][mixed].fast + phase_scatter_);
  history_.take_seen(count, moved ? to_word(level) : 0U);
  if (fits && wrong > alarm_) alarm_ = wrong;
  const float doubt = around_share * around;
  if (moved) level_doubt_ = phase_scatter_ > doubt ? phase_scatter_ : doubt;
  if (!fits) level_doubt_ = 0.0F;
  return fits;
}

void PhaseBank::push_late(PhaseWord phase, int after) {
  // the grid of one cycle slips against that of two when the frequency changes: a place left out gets the middle
  const std::int32_t place = history_.newest + after;
  const PhaseWord before = history_.late_at(history_.newest_late);
  if (place == history_.newest_late + 2)
    history_.late[static_cast<std::uint32_t>(place - 1) % phase_memory] = before + (phase - before) / 2;
  history_.late[static_cast<std::uint32_t>(place) % phase_memory] = phase;
  history_.newest_late = place;
  if (history_.late_count < phase_memory) ++history_.late_count;
}

/// The window has come to a place that was predicted. If the windows swing to and fro from cycle to cycle, what it
/// was is the mean of the two half a cycle before and after it, less what the mains bends meanwhile, with a share of
/// the window itself: a tone beside the fundamental has its zero there, and would else be taken for a movement that
/// repeats itself.
void PhaseBank::judge() {
  const float half = 0.5F * 4294967296.0F / static_cast<float>(step_);
  const auto whole = static_cast<std::int32_t>(half) + 1;
  const std::int32_t place = history_.newest - whole;
  const float part = static_cast<float>(whole) - half;
  const auto between = [&](std::int32_t end, std::int32_t towards) {
    const PhaseWord word = history_.at(end);
    return word + to_word(part * to_turns(history_.at(towards) - word));
  };
  const PhaseWord newer = between(history_.newest, history_.newest - 1);
  const PhaseWord older = between(place - whole, place - whole + 1);
  const PhaseWord mean =
      older + half_turn + to_word(0.5F * to_turns(newer - older)) - to_word(0.5F * half * half * bend_);
  const float swing = to_turns(history_.at(place) - mean);
  const auto at = static_cast<std::uint32_t>(place);
  const float before = swing_of_[(at - static_cast<std::uint32_t>(2.0F * half + 0.5F)) % swing_of_.size()];
  swing_of_[at % swing_of_.size()] = swing;
  const auto half_ago = [&](std::uint32_t ago) { return swing_of_[(at - ago) % swing_of_.size()]; };
  const auto ago = static_cast<std::uint32_t>(whole);
  const float across = swing * (half_ago(ago) + part * (half_ago(ago - 1) - half_ago(ago)));
  const float turned = -swing * before;
  const float bounded =
      turned > -largest_swing ? (turned < largest_swing ? turned : largest_swing) : -largest_swing;
  if (history_.newest > 4 * whole) swing_ += (bounded - swing_) * swing_gain;
  if (history_.newest > 4 * whole && swing * swing < wild_swing) {
    swing_square_ += (swing * swing - swing_square_) * swing_gain;
    swing_across_ += (across - swing_across_) * swing_gain;
  }
  swings_ = swing_ > (swings_ ? 0.5F : 1.0F) * least_swing;
  if (swings_)
    judge(place, mean + to_word(swing_share() * swing));
  else
    judge(history_.newest, history_.at(history_.newest));
}

/// A tone that advances by c = cos x within half a cycle leaves c of itself in the mean of the two windows about a
/// place, and 1 - c of it in the swing: the mean less c / (1 - c) of the swing is free of it.
float PhaseBank::swing_share() const {
  const float like = swing_across_ / (swing_square_ + 1.0e-12F);
  const float c = like > most_left ? most_left : (like < -most_left ? -most_left : like);
  return -c / (1.0F - c);
}

void PhaseBank::judge(std::int32_t place, PhaseWord phase) {
  if (place % 2 != 0) return;
  for (unsigned h = 0; h < 2; ++h) {
    Predicted& then = predicted(h, place);
    const std::uint32_t known = then.known;
    then.known = 0;
    if (known == 0) continue;
    const float error = to_turns(phase - then.mixed);
    track_[h][mixed].add(error * error);
    for (unsigned p = 0; p < predictor_count; ++p) {
      if ((known >> p & 1U) == 0) continue;
      const float own = error - static_cast<float>(then.less[p]) * deviation_unit;
      track_[h][p].add(own * own);
    }
  }
}

void PhaseBank::note_predictions(const Predictions& said, PhaseWord base, unsigned horizon, float average,
                                 std::int32_t place) {
  if (place % 2 != 0) return;
  Predicted& then = predicted(horizon, place);
  then.mixed = base + to_word(average);
  then.known = static_cast<std::uint16_t>(said.usable | 1U << mixed);
  for (unsigned p = 0; p < predictor_count; ++p) {
    if ((said.usable >> p & 1U) == 0) continue;
    const float less = (said.at[horizon][p] - average) * (1.0F / deviation_unit);
    then.less[p] =
        static_cast<std::int16_t>(less > 32767.0F ? 32767.0F : (less < -32767.0F ? -32767.0F : less));
  }
}

void PhaseBank::forget_predictions() {
  for (auto& horizon : predicted_)
    for (Predicted& then : horizon) then.known = 0;
}

/// What differs from window to window without being a movement, of phases and of amplitudes: a disturbance that is
/// added to the mains moves both alike, a mains that moves fast the phases alone.
void PhaseBank::note_scatter() {
  const auto y = [&](int lags_ago) { return history_.at(history_.newest - lags_ago * scatter_lag); };
  const float third = to_turns(y(0) - y(3) - 3U * (y(1) - y(2)));
  if (scatter_count_ < 250.0F) scatter_count_ += 1.0F;
  const auto a = [&](int lags_ago) {
    return amplitude_[static_cast<std::uint32_t>(history_.newest - lags_ago * scatter_lag) % phase_memory];
  };
  const float wide = (a(0) - a(3) - 3.0F * (a(1) - a(2))) / (two_pi * a(0));
  phase_scatter_ += (third * third * (1.0F / 16.0F) - phase_scatter_) / scatter_count_;
  amplitude_scatter_ += (wide * wide * (1.0F / 16.0F) - amplitude_scatter_) / scatter_count_;
}

void PhaseBank::weigh(const Predictions& said, bool judged) {
  std::array<float, predictor_count> expected;
  float best = 1.0e9F;
  for (unsigned p = 0; p < predictor_count; ++p) {
    weight_[p] = 0.0F;
    if ((said.usable >> p & 1U) == 0) continue;
    const Track& track = track_[1][p];
    float e = track.worse() + first_expectation * unproven(track.count) + phase_predictors[p].doubt;
    Usual& usual = innovation_[p];
    const float surprise = said.late_error[p] * said.late_error[p];
    const float limit = test_factor * usual.mean_square + 1.0e-10F;
    if (surprise > limit && usual.count > 20.0F) e += surprise_gain * surprise;
    if (judged) {
      if (usual.count < 2.0F * longest_count) usual.count += 1.0F;
      const bool wild = usual.count > 50.0F && surprise > 4.0F * limit;
      usual.mean_square += ((wild ? 4.0F * limit : surprise) - usual.mean_square) / usual.count;
    }
    expected[p] = e;
    if (track.count >= trusted_after && e < best) best = e;
  }
  // one whose errors are not known yet must not outdo those that have been right
  const float least = best < 1.0e8F ? 4.0F * best : 0.0F;
  for (unsigned p = 0; p < predictor_count; ++p) {
    if ((said.usable >> p & 1U) == 0) continue;
    if (track_[1][p].count < trusted_after && expected[p] < least) expected[p] = least;
    if (expected[p] < best) best = expected[p];
  }
  float total = 0.0F;
  expected_ = {};
  for (unsigned p = 0; p < predictor_count; ++p) {
    if ((said.usable >> p & 1U) == 0) continue;
    const float weight = fourth_power(best / expected[p]);
    const Track &now = track_[0][p], &ahead = track_[1][p];
    weight_[p] = weight;
    total += weight;
    expected_[0] += weight * (now.expected(recent_share[0]) + first_expectation * unproven(now.count));
    const float surplus = ahead.worse() - ahead.expected(recent_share[1]);
    expected_[1] += weight * (expected[p] - phase_predictors[p].doubt - surplus);
  }
  const float scale = 1.0F / total;
  for (float& weight : weight_) weight *= scale;
  for (float& e : expected_) e *= scale;
}

float PhaseBank::variance(unsigned horizon) const {
  const float recent = track_[horizon][mixed].fast;
  const float seen = recent > expected_[horizon] ? recent : expected_[horizon];
  const float white = white_factor * amplitude_scatter_;
  const float windows = horizon == 0 || phase_scatter_ < white ? phase_scatter_ : white;
  const float own = swings_ ? swing_own * seen + swing_left * swing_square_ : seen - windows;
  const float least = least_share * seen;
  return (own > least ? own : least) + level_doubt_ + least_variance;
}

/// How much has what was said lately of 20 ms ahead been revised?
void PhaseBank::revise(BankSay& out, Said said, bool long_known) {
  const auto at = static_cast<std::uint32_t>(history_.newest);
  said_[at % said_slots] = said;
  for (unsigned l = 0; l < lags.size() && said_count_ >= lags[l]; ++l) {
    const Said& old = said_[(at - static_cast<std::uint32_t>(lags[l])) % said_slots];
    const auto later = static_cast<float>(said.place - old.place);
    const float moved =
        to_turns(said.ahead - old.ahead - old.step * static_cast<std::uint32_t>(said.place - old.place)) -
        later * (old.slope + 0.5F * old.bend * later);
    const float square = moved * moved;
    float& usual = revision_[l];
    const float limit = revision_factor * (usual > out.variance_ahead ? usual : out.variance_ahead);
    if (square > limit && revision_share * square > alarm_) alarm_ = revision_share * square;
    if (square > 4.0F * limit && square > step_square && long_known) out.broken = true;
    usual += ((square > 4.0F * limit ? 4.0F * limit : square) - usual) *
             (said_count_ < static_cast<int>(said_slots) ? 0.1F : 0.01F);
  }
  if (alarm_ > out.variance_ahead) out.variance_ahead = alarm_;
  if (now_share * alarm_ > out.variance_now) out.variance_now = now_share * alarm_;
  alarm_ *= alarm_decay;
  if (said_count_ < static_cast<int>(said_slots)) ++said_count_;
}

/// What is put back at an event is from before it.
void PhaseBank::keep_tracks() {
  if (++since_kept_ < keep_interval) return;
  since_kept_ = 0;
  kept_[1] = kept_[0];
  kept_[0] = track_;
}

BankSay PhaseBank::say(int clean, PhaseWord step, int now, int ahead) {
  const bool judged = clean >= fewest;
  step_ = step;
  level_doubt_ *= level_decay;
  const std::array<int, 2> reach = {now, ahead};
  const Predictions said = predict(history_, clean, step, reach);
  if (since_joint_ <= 3 * scatter_lag) ++since_joint_;
  if (clean > 3 * scatter_lag && since_joint_ > 3 * scatter_lag) note_scatter();
  weigh(said, judged);
  if (judged) keep_tracks();

  BankSay out;
  std::array<float, 2> value{};
  const PhaseWord origin = history_.at(history_.newest);
  for (unsigned h = 0; h < 2; ++h) {
    const PhaseWord base = origin + step * static_cast<std::uint32_t>(reach[h]);
    for (unsigned p = 0; p < predictor_count; ++p) {
      if ((said.usable >> p & 1U) == 0) continue;
      value[h] += weight_[p] * said.at[h][p];
      if (h == 0) out.rate += weight_[p] * said.bend[p];
    }
    if (judged) note_predictions(said, base, h, value[h], history_.newest + reach[h]);
  }
  bend_ = out.rate;
  out.now = value[0];
  out.ahead = value[1];
  out.variance_now = variance(0);
  out.variance_ahead = variance(1);
  const auto span = static_cast<float>(ahead - now);
  revise(out,
         {origin + step * static_cast<std::uint32_t>(ahead) + to_word(out.ahead), step,
          (out.ahead - out.now) / span + 0.5F * out.rate * span, out.rate, history_.newest + ahead},
         clean > 128);
  if (!judged) said_count_ = 0;
  return out;
}

}  // namespace powbench::firmware
