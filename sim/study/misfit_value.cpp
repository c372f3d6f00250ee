#include <algorithm>
#include <atomic>
#include <cmath>
#include <memory>

#include "sim/specimen/validate.h"
#include "sim/study/closings_in_lanes.h"
#include "sim/study/misfit.h"

/// The sum of squares, closing by closing, at one point and at many.

namespace powbench::sim {
namespace {

constexpr double impossible = 1e9;

Conditions at_degrees(double degrees, double volts) {
  Conditions c;
  c.closing_angle = radians(degrees);
  c.supply_volts = volts;
  return c;
}

}  // namespace

/// First the measured closings, then those that the kind demands; the sum grows in this order.
class Misfit::Trial {
 public:
  Trial(const Misfit& misfit, std::span<const double> point, double give_up)
      : m_(misfit), specimen_(misfit.specimen(point)), give_up_(give_up) {
    if (!validate(specimen_).empty()) {
      sum_ = impossible;
      over_ = true;
      return;
    }
    const FitProblem& p = m_.problem_;
    for (std::size_t i = 0; i < point.size(); ++i) {
      const double u = point[i];
      const double near = std::max({p.edge - u, u - (1 - p.edge), 0.0});
      if (p.edge > 0) sum_ += std::pow(near / p.edge, 2);
      if (p.prior_deviation > 0) sum_ += std::pow((u - m_.middle(i)) / p.prior_deviation, 2);
    }
    std::vector<double> ranges;
    m_.range_residuals(specimen_, ranges);
    for (const double r : ranges) sum_ += r * r;
  }

  const Specimen& specimen() const { return specimen_; }
  double sum() const { return sum_; }

  struct Wanted {
    Conditions conditions;
    double duration = 0;  ///< s
  };
  /// Nothing: the sum is the value.
  std::optional<Wanted> next() {
    const FitProblem& p = m_.problem_;
    if (stage_ == Stage::measured && at_ == p.closings.size()) {
      sum_ += means_.excess();
      enter(Stage::calm);
    }
    if (stage_ == Stage::calm && (!p.plausible.calm || at_ == calm_degrees.size())) enter(Stage::pick_up);
    if (stage_ == Stage::pick_up && (!p.plausible.pick_up || at_ == pick_up_degrees.size())) over_ = true;
    if (over_ || sum_ > give_up_) return std::nullopt;
    const double volts = p.plausible.rated_volts;
    if (stage_ == Stage::measured) return Wanted{p.closings[at_].conditions, p.duration};
    if (stage_ == Stage::calm) return Wanted{at_degrees(calm_degrees[at_], volts), 0.06};
    return Wanted{at_degrees(pick_up_degrees[at_], 0.85 * volts), 0.06};
  }

  void take(const ClosingTruth& t) {
    const std::size_t k = at_++;
    if (stage_ == Stage::measured) {
      ClosingResiduals r;
      const MeasuredClosing& m = m_.problem_.closings[k];
      sum_ += m_.problem_.absolute ? m_.closing_distance(t, m, means_) : m_.closing_residuals(t, m, r);
    } else if (stage_ == Stage::calm) {
      constexpr PlausibleRange calm{0, 26e-3, 5e-3};
      const double late = t.settled ? calm.outside(*t.settled) : 10;
      sum_ += late * late;
    } else if (!t.core_seat) {
      sum_ += 50;
    }
  }

 private:
  enum class Stage : std::uint8_t { measured, calm, pick_up };
  static constexpr std::array calm_degrees{0.0, 45.0, 70.0, 80.0, 135.0};
  static constexpr std::array pick_up_degrees{0.0, 60.0, 120.0};
  void enter(Stage stage) {
    stage_ = stage;
    at_ = 0;
  }

  const Misfit& m_;
  Specimen specimen_;
  double give_up_;
  double sum_ = 0;
  Means means_;
  Stage stage_ = Stage::measured;
  std::size_t at_ = 0;  ///< of the closings of this stage
  bool over_ = false;
};

double Misfit::value(std::span<const double> point, double give_up) const {
  Trial trial(*this, point, give_up);
  const auto& run = problem_.model.run;
  while (const auto w = trial.next())
    trial.take(run ? run(trial.specimen(), w->conditions, w->duration, problem_.tolerance)
                   : tried_closing(trial.specimen(), w->conditions, w->duration, problem_.tolerance));
  return trial.sum();
}

std::vector<double> Misfit::values(std::span<const std::vector<double>> points,
                                   std::span<const double> give_up, Team& team) const {
  std::vector<double> values(points.size());
  if (problem_.model.run) {
    for_each_index(team, static_cast<int>(points.size()), [&](int i) {
      const auto k = static_cast<std::size_t>(i);
      values[k] = value(points[k], give_up[k]);
    });
    return values;
  }
  std::atomic<std::size_t> begun{0};
  team.run([&](int) {
    struct Begun {
      std::size_t place;
      Trial trial;
    };
    std::vector<std::unique_ptr<Begun>> trials;
    std::vector<std::size_t> ready;  // of the trials, which of them can go on
    const auto one = [&]() -> std::optional<std::size_t> {
      if (!ready.empty()) {
        const std::size_t k = ready.back();
        ready.pop_back();
        return k;
      }
      const std::size_t i = begun.fetch_add(1);
      if (i >= points.size()) return std::nullopt;
      trials.push_back(std::make_unique<Begun>(Begun{i, Trial(*this, points[i], give_up[i])}));
      return trials.size() - 1;
    };
    closings_in_lanes(
        [&]() -> std::optional<LaneClosing> {
          while (const auto k = one()) {
            Trial& trial = trials[*k]->trial;
            if (const auto w = trial.next())
              return LaneClosing{*k, {trial.specimen(), w->conditions}, w->duration, problem_.tolerance};
            values[trials[*k]->place] = trial.sum();
            trials[*k].reset();
          }
          return std::nullopt;
        },
        [&](std::size_t k, const ClosingTruth& t) {
          trials[k]->trial.take(t);
          ready.push_back(k);
        },
        OnFailure::no_closing);
  });
  return values;
}

}  // namespace powbench::sim
