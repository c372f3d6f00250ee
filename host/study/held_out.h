#pragma once

#include <span>

#include "core/conditions.h"
#include "host/paper/evaluate.h"
#include "host/study/fit_file.h"
#include "sim/study/misfit.h"

/// What an ensemble of identified specimens predicts.

namespace powbench::host {

/// Median over the specimens, with the 16 % and 84 % quantiles; s. NaN when fewer than half of them close.
struct Band {
  double low = unknown, median = unknown, high = unknown;
};
struct Prediction {
  Band touch, bounce, settled, seat;
};
Prediction predict(std::span<const sim::Specimen>, const Conditions&);

/// A prediction pooled with what is known without any model, the median m of the other angles (three or more):
///   w p + (1 - w) m,   w = s^2 / (s^2 + v),   v = ((high - low) / 2)^2 + (d p)^2,
/// s the standard deviation among the others, d the mean relative deviation that the fit granted them. Nothing of the angle that
/// is predicted enters. Where the others differ more than the model may err the model stands; where they hardly do, they count.
Prediction pooled(const Prediction&, std::span<const sim::MeasuredClosing> others);

/// At each angle, the prediction of the fold that has not seen it, pooled with the other published angles; the view is all NaN
/// where there is none. Core bounce and forces are not predicted.
ClosingProvider held_out_provider(const FitFile&, const Conditions& = {});

}  // namespace powbench::host
