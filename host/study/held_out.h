#pragma once

#include <span>

#include "core/conditions.h"
#include "host/paper/evaluate.h"
#include "host/study/fit_file.h"
#include "sim/study/misfit.h"

/// What an ensemble of identified specimens predicts.

namespace powbench::host {

/// Median over the specimens, with the 16 % and 84 % quantiles, by weight; s. NaN when less than half of the weight closes.
struct Band {
  double low = unknown, median = unknown, high = unknown;
};
struct Prediction {
  Band touch, bounce, settled, seat;
};
/// `weights`: one for each specimen, or none: equal. They weigh bounce and settled time alone: a specimen that chatters says nothing
/// about those, but its touch and seat are as good as any.
Prediction predict(std::span<const sim::Specimen>, const Conditions&, std::span<const double> weights = {});

/// The bounce pooled with what is known of it without any model, the median m of the other angles (three or more):
///   w p + (1 - w) m,   w = s^2 / (s^2 + v),   v = ((high - low) / 2)^2 + (d p)^2,
/// s the standard deviation among the others, d the mean relative deviation that the fit granted them. Nothing of the angle that
/// is predicted enters. The other quantities follow the closing angle, so that their median elsewhere says nothing: they stand.
Prediction pooled(const Prediction&, std::span<const sim::MeasuredClosing> others);

/// At each angle, the prediction of the fold that has not seen it, pooled with the other published angles; the view is all NaN
/// where there is none. Core bounce and forces are not predicted.
ClosingProvider held_out_provider(const FitFile&, const Conditions& = {});

}  // namespace powbench::host
