#pragma once

#include <optional>
#include <span>

#include "core/conditions.h"
#include "host/paper/evaluate.h"
#include "host/study/fit_file.h"
#include "sim/models/closing.h"

/// What an ensemble of identified specimens predicts.

namespace powbench::host {

/// s; NaN when less than half of the specimens close.
struct Band {
  double low = unknown, median = unknown, high = unknown;
};

/// What one measured value deviates from the device's model, standard deviations, relative but for the last: those that
/// the fit granted its data (`ModelDeviation`). A band holds a value that is measured, not what the model says of it.
struct OneMeasured {
  double touch = 0, seat = 0;
  double overtravel_time = 0;  ///< s
};

/// Touch, seat and overtravel time: median over the specimens; 16 % and 84 % quantiles of the specimens' values, each
/// spread normally by the deviation of one measured value. Bounce and settled time: by the specimens alone. With a
/// calibration, of which each specimen has a factor, the bounce is pooled and its sides are quantiles of the law of its
/// error (sim/study/bounce_calibration.h). Where the calibration has no deviations: quantiles of factor x simulated.
/// Settled time is then touch and bounce added up, the sides as independent ones.
struct Prediction {
  Band touch, bounce, settled, seat, overtravel_time;
};
Prediction predict(std::span<const sim::Specimen>, const Conditions&,
                   const std::optional<sim::BounceCalibration>& = {}, const OneMeasured& = {},
                   const sim::ClosingModel& = {});

/// At each angle, the prediction of the fold that has not seen it; the view is all NaN where there is none. Core
/// bounce and forces are not predicted.
ClosingProvider held_out_provider(const FitFile&, const Conditions& = {});

}  // namespace powbench::host
