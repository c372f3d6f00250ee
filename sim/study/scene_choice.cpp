#include "sim/study/scene_choice.h"

#include <algorithm>
#include <cmath>
#include <cstdio>
#include <map>
#include <optional>
#include <stdexcept>

#include "sim/study/axis.h"

namespace powbench::sim {
namespace {

constexpr double coarsest = 1e-4, finest = 1e-11;
constexpr double step_share =
    0.1;  // of what is wanted, for each of up to three rungs: the rest is left for the model

void check(const SceneAxes& axes, const WantedTimes& wanted) {
  if (axes.fields.empty() || axes.mechanics.empty())
    throw std::invalid_argument("scene: at least one rung of fields and one of mechanics");
  bool any = false;
  for (const double w : wanted) {
    if (std::isnan(w)) continue;
    any = true;
    if (!(w >= 1e-9 && w <= 0.5)) throw std::invalid_argument("accuracy: allowed 1e-7 % .. 50 %");
  }
  if (!any) throw std::invalid_argument("wanted: at least one of touch, seat, settled");
}

/// A pair, refined until its step contributes little. A run that its guards stop tells nothing: a finer one is tried.
struct Refined {
  Rung rung;
  LadderRun run;
  LadderTimes step_error{nan_times};
  std::string stopped;  ///< no run came to its end: why
};

class Chooser {
 public:
  Chooser(const SceneAxes& axes, const Case& c, const WantedTimes& wanted, double duration,
          const CpuClock& clock)
      : axes_(axes), case_(c), wanted_(wanted), duration_(duration), clock_(clock) {}

  std::vector<SceneStep> look_at_all(const std::function<void(std::size_t)>& done) {
    std::vector<SceneStep> steps;
    every_rung_above_ = true;
    for (std::size_t f = 0; f < axes_.fields.size(); ++f)
      for (std::size_t m = 0; m < axes_.mechanics.size(); ++m) {
        steps.push_back(look(f, m));
        if (done) done(steps.size());
      }
    return steps;
  }

  SceneChoice choose(std::span<const InputUncertainty> inputs) {
    SceneChoice choice;
    std::size_t f = 0, m = 0;
    for (;;) {
      const SceneStep step = look(f, m);
      choice.steps.push_back(step);
      const Refined& here = refined(f, m);
      choice.rung = here.rung;
      choice.setting = here.run.tolerance;
      if (step.reached != Reached::not_met) break;  // what is not known, no higher rung tells
      const double by_fields = excess(step.fields.above, here.run),
                   by_mechanics = excess(step.mechanics.above, here.run);
      const bool fields_left = f + 1 < axes_.fields.size(), mechanics_left = m + 1 < axes_.mechanics.size();
      if (!fields_left && !mechanics_left) break;
      if (by_fields == 0 && by_mechanics == 0 && excess(step.to_best, here.run) == 0)
        break;  // the step alone is too coarse: nothing higher mends that
      ++(fields_left && (by_fields >= by_mechanics || !mechanics_left) ? f : m);
    }
    choice.inputs.assign(inputs.begin(), inputs.end());
    choice.input_error = input_error(choice.rung, choice.setting, case_, duration_, inputs, clock_, &spent_);
    choice.spent = spent_;
    return choice;
  }

 private:
  /// The run at the first of these settings from `at` on that comes to its end; `at` is then its place.
  std::optional<LadderRun> run_from(Refined& r, const std::vector<double>& settings, std::size_t& at) {
    for (; at < settings.size(); ++at) {
      const double begun = clock_();
      try {
        const LadderRun run = run_rung(std::span(&r.rung, 1), 0, case_, duration_, settings[at], clock_);
        spent_ += run.cpu;
        return run;
      } catch (const std::runtime_error& e) {
        spent_ += clock_() - begun;
        r.stopped = e.what();
      }
    }
    return std::nullopt;
  }

  /// What shares are of: the touch time.
  double whole_of(const LadderRun& run) const { return std::isnan(run.times[0]) ? duration_ : run.times[0]; }

  /// Largest error over what is wanted; 0 where nothing is known.
  double excess(const LadderTimes& error, const LadderRun& run) const {
    double worst = 0;
    const double whole = whole_of(run);
    for (std::size_t q = 0; q < error.size(); ++q)
      if (!std::isnan(wanted_[q]) && !std::isnan(error[q]))
        worst = std::max(worst, error[q] / (wanted_[q] * whole));
    return worst;
  }

  const Refined& refined(std::size_t f, std::size_t m) {
    const auto known = known_.find({f, m});
    if (known != known_.end()) return known->second;
    Refined r;
    r.rung = axes_.rung(f, m);
    const auto settings = settings_of(r.rung, coarsest, finest);
    std::size_t k = 0;
    r.run.times = nan_times;
    r.run.tolerance = settings.front();
    if (const auto first = run_from(r, settings, k)) {
      r.run = *first;
      r.stopped.clear();
    }
    while (++k < settings.size()) {
      const auto finer = run_from(r, settings, k);
      r.stopped.clear();
      if (!finer) break;
      r.step_error = error_estimate(r.run, *finer);
      if (excess(r.step_error, *finer) <= step_share || k + 1 == settings.size()) break;
      r.run = *finer;
    }
    return known_.emplace(std::pair{f, m}, std::move(r)).first->second;
  }

  SceneStep look(std::size_t f, std::size_t m) {
    const Refined& here = refined(f, m);
    SceneStep s;
    s.name = here.rung.name();
    s.setting_name = here.rung.setting;
    s.run = here.run;
    s.step_error = here.step_error;
    const auto to = [&](std::size_t other_f, std::size_t other_m) {
      const Refined& other = refined(other_f, other_m);
      if (!here.stopped.empty() || !other.stopped.empty()) return nan_times;
      return model_difference(here.run, other.run, other.step_error);
    };
    for (std::size_t h = f + 1; h < axes_.fields.size() && open(s.fields, here); ++h)
      s.fields.above = larger(s.fields.above, to(h, m));
    if (f > 0) s.fields.below = to(f - 1, m);
    for (std::size_t q = 0; f == 0 && q < s.fields.above.size(); ++q)
      for (const double known : {std::abs(here.run.times[q] - axes_.measured[q]), axes_.held_out_error[q]})
        s.fields.above[q] = std::fmax(s.fields.above[q], known);  // of the two that are known
    for (std::size_t h = m + 1; h < axes_.mechanics.size() && open(s.mechanics, here); ++h)
      s.mechanics.above = larger(s.mechanics.above, to(f, h));
    if (m > 0) s.mechanics.below = to(f, m - 1);
    s.model_error = model_error(s);
    const std::size_t top_f = axes_.fields.size() - 1, top_m = axes_.mechanics.size() - 1;
    if ((f < top_f || m < top_m) && (every_rung_above_ || excess(known_error(s), here.run) <= 1)) {
      s.to_best = to(top_f, top_m);
      s.model_error = model_error(s);
    }
    s.stopped = here.stopped;
    judge(s);
    return s;
  }

  /// Whether a further rung can change the verdict, or its distance is asked for anyway.
  bool open(const AxisError& error, const Refined& here) const {
    return every_rung_above_ || excess(error.above, here.run) <= 1;
  }

  /// Of each time; what is not known does not count.
  static LadderTimes larger(LadderTimes a, const LadderTimes& b) {
    for (std::size_t q = 0; q < a.size(); ++q) a[q] = std::fmax(a[q], b[q]);
    return a;
  }

  /// To what is above, of both axes together; what is not known counts nothing.
  static LadderTimes known_error(const SceneStep& s) {
    LadderTimes sum{};
    for (std::size_t q = 0; q < sum.size(); ++q) {
      for (const AxisError* axis : {&s.fields, &s.mechanics})
        if (!std::isnan(axis->above[q])) sum[q] += axis->above[q];
      sum[q] = std::fmax(sum[q], s.to_best[q]);
    }
    return sum;
  }

  /// Of both axes together, each to the rungs above or, at the top, from the one below.
  static LadderTimes model_error(const SceneStep& s) {
    LadderTimes sum{};
    for (std::size_t q = 0; q < sum.size(); ++q)
      for (const AxisError* axis : {&s.fields, &s.mechanics})
        sum[q] += std::isnan(axis->above[q]) ? axis->below[q] : axis->above[q];
    for (std::size_t q = 0; q < sum.size(); ++q)
      if (s.to_best[q] > sum[q]) sum[q] = s.to_best[q];
    return sum;
  }

  void judge(SceneStep& s) const {
    bool too_large = false;
    for (std::size_t q = 0; q < wanted_.size(); ++q) {
      if (std::isnan(wanted_[q])) continue;
      s.by_time[q] = judge_time(s, q);
      too_large = too_large || s.by_time[q] == Reached::not_met;
    }
    s.reached = too_large ? Reached::not_met : s.unknown.empty() ? Reached::met : Reached::not_known;
  }

  /// One of the times; what is not known of it is added to `unknown`.
  Reached judge_time(SceneStep& s, std::size_t q) const {
    const double allowed = wanted_[q] * whole_of(s.run);
    // a difference to another rung contains the error of this one's step
    const bool compared = !std::isnan(s.fields.above[q]) || !std::isnan(s.mechanics.above[q]);
    double sum = compared ? known_error(s)[q] : std::isnan(s.step_error[q]) ? 0.0 : s.step_error[q];
    s.share = std::max(s.share, sum / allowed);
    const bool too_large = sum > allowed;
    const std::size_t before = s.unknown.size();
    const std::string time(ladder_quantities[q]);
    if (!s.stopped.empty()) {
      s.unknown.push_back(time + ": not computable, " + s.stopped);
    } else if (std::isnan(s.run.times[q])) {
      s.unknown.push_back(time + ": does not happen");
    } else {
      if (std::isnan(s.step_error[q]) && !compared) s.unknown.push_back(time + ": error of the step");
      const auto judge_axis = [&](const AxisError& error, const char* axis, std::string_view rung,
                                  bool by_increment) {
        if (!std::isnan(error.above[q])) return;
        const double last = error.below[q];
        const std::string of =
            time + ": error of " + axis + ", nothing to compare " + std::string(rung) + " with";
        if (std::isnan(last))
          s.unknown.push_back(of);
        else if (!by_increment || sum + last > allowed)
          s.unknown.push_back(of + " but the rung below, which differs by " + microseconds(last));
        else
          sum += last;
      };
      judge_axis(s.fields, "the fields", s.name.substr(0, s.name.find('+')), false);
      const bool measured = !std::isnan(axes_.measured[q]) || !std::isnan(axes_.held_out_error[q]);
      if (!std::isnan(s.fields.above[q]) && !axes_.fields_left_out.empty() && !measured)
        s.unknown.push_back(time + ": error of the fields, " + axes_.fields_left_out + " is left out");
      judge_axis(s.mechanics, "the mechanics", s.name.substr(s.name.find('+') + 1), true);
    }
    return too_large ? Reached::not_met : s.unknown.size() == before ? Reached::met : Reached::not_known;
  }

  static std::string microseconds(double seconds) {
    std::array<char, 32> text{};
    std::snprintf(text.data(), text.size(), "%.3g us", seconds * 1e6);
    return text.data();
  }

  const SceneAxes& axes_;
  Case case_;
  WantedTimes wanted_;
  double duration_;
  CpuClock clock_;
  double spent_ = 0;
  bool every_rung_above_ = false;
  std::map<std::pair<std::size_t, std::size_t>, Refined> known_;
};

}  // namespace

LadderTimes input_error(const Rung& rung, double setting, const Case& c, double duration,
                        std::span<const InputUncertainty> inputs, const CpuClock& clock, double* spent) {
  LadderTimes variance = nan_times;
  if (rung.costly) return variance;  // two closings an input, each of seconds
  for (const auto& input : inputs) {
    const Variable v = variable(input.name);
    const double at = v.get(c);
    LadderTimes times[2];
    for (int side = 0; side < 2; ++side) {
      Case moved = c;
      v.set(moved, std::clamp(at + (side == 0 ? -input.u : input.u), v.low, v.high));
      const LadderRun run = run_rung(std::span(&rung, 1), 0, moved, duration, setting, clock);
      times[side] = run.times;
      if (spent != nullptr) *spent += run.cpu;
    }
    for (std::size_t q = 0; q < variance.size(); ++q) {
      const double half = 0.5 * (times[1][q] - times[0][q]);
      variance[q] = (&input == inputs.data() ? 0.0 : variance[q]) + half * half;
    }
  }
  for (double& x : variance) x = std::sqrt(x);
  return variance;
}

SceneChoice choose_scene(const SceneAxes& axes, const Case& c, const WantedTimes& wanted, double duration,
                         std::span<const InputUncertainty> inputs, const CpuClock& clock) {
  check(axes, wanted);
  return Chooser(axes, c, wanted, duration, clock).choose(inputs);
}

std::vector<SceneStep> look_at_all(const SceneAxes& axes, const Case& c, const WantedTimes& wanted,
                                   double duration, const CpuClock& clock,
                                   const std::function<void(std::size_t)>& done) {
  check(axes, wanted);
  return Chooser(axes, c, wanted, duration, clock).look_at_all(done);
}

}  // namespace powbench::sim
