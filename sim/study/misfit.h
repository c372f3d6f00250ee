#pragma once

#include <algorithm>
#include <array>
#include <limits>
#include <optional>
#include <span>
#include <vector>

#include "core/events.h"
#include "sim/models/closing.h"
#include "sim/study/least_squares.h"
#include "sim/study/parameter.h"
#include "sim/team.h"

/// How far a specimen is from what was measured, and from what its kind may be.

namespace powbench::sim {

/// One closing that was measured, in s; `u` holds the standard deviation, that of the model included. What is not known
/// takes no part.
struct MeasuredClosing {
  Conditions conditions;
  Measured touch;        ///< t_ct1
  Measured bounce;       ///< t_ct_bon
  Measured seat;         ///< t_xt1
  Measured core_bounce;  ///< t_xt_bon
  /// t_ot, seat - touch. Known: a target beside those two, for a model that misses both of them alike.
  Measured overtravel_time{};
  /// t_ct2, touch and bounce together: only its `u` is read, and only where deviations are summed.
  Measured settled{};
};

/// A range that a derived quantity should keep; outside, the distance counts in units of `deviation`.
struct PlausibleRange {
  double low = 0, high = 0;
  double deviation = 1;
  double outside(double value) const { return std::max({low - value, value - high, 0.0}) / deviation; }
};

/// What the kind of contactor demands beside the measured closings. Absent: not asked for.
struct Plausible {
  std::optional<PlausibleRange> inrush;         ///< VA, core held open
  std::optional<PlausibleRange> holding;        ///< VA, core closed
  std::optional<PlausibleRange> overtravel;     ///< of the contact gap
  std::optional<PlausibleRange> contact_force;  ///< N, one break, closed
  std::optional<PlausibleRange> base_travel;  ///< m, static deflection under 100 N: softness of the mounting
  std::optional<PlausibleRange>
      held_load;         ///< closed springs' load over the least pull: above 1 the core lets go
  bool pick_up = false;  ///< closes at 0.85 of the rated voltage at 0, 60 and 120 deg
  bool calm = false;     ///< settles within 26 ms at 0, 45, 70, 80 and 135 deg and stays so: no chatter
  double rated_volts = 230;
};
/// Catalogue ranges of the 25 .. 40 A frame.
Plausible catalogue_ranges();

struct FitProblem {
  Specimen base;         ///< numbers that are not free
  ClosingModel model{};  ///< that simulates; empty: the plant, in lanes
  std::vector<Parameter> parameters;
  std::vector<MeasuredClosing> closings;
  Plausible plausible;
  double prior_deviation = 0.35;     ///< normal, of each coordinate about the middle of its bounds; 0: flat
  std::vector<double> prior_middle;  ///< of each coordinate; empty: 0.5
  double edge = 0.04;                ///< share of the range next to a bound that costs something
  double tolerance = 1e-4;           ///< of the integrator
  double duration =
      0.06;  ///< s simulated for each closing: a late release, when the offset flux dies out, is seen
  bool robust = true;  ///< bounce times beyond two deviations count linearly
  /// Sum of absolute deviations, the settled time's among them, in place of squares, and a steep cost of every
  /// quantity whose mean is above two: what a table of mean errors judges by.
  bool absolute = false;
};

/// The sum of squares and its parts. Pure: equal points give equal bits.
class Misfit {
 public:
  explicit Misfit(FitProblem);

  const FitProblem& problem() const { return problem_; }
  std::size_t dimension() const { return problem_.parameters.size(); }
  Specimen specimen(std::span<const double> point) const {
    return specimen_at(problem_.base, problem_.parameters, point);
  }

  /// Residuals of one closing: four, and one more where overtravel times are a target.
  std::size_t per_closing() const { return per_closing_; }

  /// Sum of squared residuals; leaves off early, with what it has, once that is above `give_up`.
  double value(std::span<const double> point, double give_up = std::numeric_limits<double>::infinity()) const;

  /// The same at many points, each with its own limit; their closings run side by side (sim/models/lanes).
  std::vector<double> values(std::span<const std::vector<double>> points, std::span<const double> give_up,
                             Team&) const;

  /// Residuals whose squares sum to the smooth part of the misfit: those of each closing (touch, bounce, seat, core
  /// bounce, overtravel time; 0 where not measured), the ranges, the prior. Pick-up and calm, which are steps, are left
  /// out.
  std::vector<double> residuals(std::span<const double> point, double tolerance) const;
  /// The same at many points, their closings side by side.
  std::vector<std::vector<double>> residuals(std::span<const std::vector<double>> points, double tolerance,
                                             Team&) const;

  /// Simulated bounce of every closing at every point, s; NaN where it does not close.
  std::vector<std::vector<double>> bounces(std::span<const std::vector<double>> points, double tolerance,
                                           Team&) const;

  /// The part without jumps: touch, seat and overtravel, simulated no longer than those may take. `held_load`, which is
  /// smooth, replaces the absence of chatter, which is a step function.
  Misfit motion() const;

  /// Standard normal shifts move the measured values, and the middles of the prior where given: for fits to data with
  /// noise.
  Misfit perturbed(std::span<const double> shifts, std::span<const double> prior_shifts = {}) const;

 private:
  class Trial;  ///< `value` at one point, closing by closing
  friend std::vector<std::vector<double>> residuals_of(std::span<const Misfit>, std::span<const PointOf>,
                                                       double tolerance, Team&);

  using ClosingResiduals = std::array<double, 5>;
  double closing_residuals(const ClosingTruth&, const MeasuredClosing&, ClosingResiduals&) const;
  /// Deviations by quantity, for their means.
  struct Means {
    std::array<double, 6> sum{};
    std::array<int, 6> count{};
    double excess() const;  ///< steep cost of every mean above two deviations
  };
  double closing_distance(const ClosingTruth&, const MeasuredClosing&, Means&) const;
  void range_residuals(const Specimen&, std::vector<double>& out) const;
  std::vector<double> residuals(const Specimen&, std::span<const double> point,
                                std::span<const ClosingTruth>) const;

  double middle(std::size_t coordinate) const {
    return problem_.prior_middle.empty() ? 0.5 : problem_.prior_middle[coordinate];
  }

  FitProblem problem_;
  std::size_t per_closing_ = 4;
};

/// `Misfit::residuals` at points of several problems of one model, all closings side by side.
std::vector<std::vector<double>> residuals_of(std::span<const Misfit>, std::span<const PointOf>,
                                              double tolerance, Team&);

/// Forces and powers that `Plausible` bounds.
struct Derived {
  double inrush = 0, holding = 0;  ///< VA
  double overtravel = 0;           ///< of the contact gap
  double contact_force = 0;        ///< N, one break, closed
  double base_travel = 0;          ///< m under 100 N
};
Derived derived(const Specimen&, double rated_volts);

}  // namespace powbench::sim
