#pragma once

#include <span>

#include "core/conditions.h"
#include "host/paper/evaluate.h"
#include "host/study/fit_file.h"

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

/// At each angle, the prediction of the fold that has not seen it; the view is all NaN where there is none. Core bounce
/// and forces are not predicted.
ClosingProvider held_out_provider(const FitFile&, const Conditions& = {});

}  // namespace powbench::host
