#pragma once

#include <span>
#include <string>

#include "host/study/fit_job.h"
#include "host/study/held_out.h"
#include "host/study/next_measurement.h"

/// A fit for people and for programs.

namespace powbench::host {

/// One measured value beside what was fitted and what was predicted without it, s.
struct FitCell {
  double theta_deg = 0;
  std::string quantity;
  double measured = unknown, fitted = unknown;
  Band held_out;                    ///< prediction of the fit that has not seen this angle
  double fitted_percent = unknown;  ///< |fitted - measured| / |measured|
  double held_out_percent = unknown;
  double others_percent =
      unknown;  ///< the same for the median of the other angles: what no model would reach
};

/// touch, bounce, settled and seat of every closing in `closings`; simulated anew from the file's members. At an angle
/// of `unseen`, rad, nothing is fitted, and no median holds it. `model`: that of the fit.
std::vector<FitCell> fit_cells(const FitFile&, const std::vector<sim::MeasuredClosing>& closings,
                               std::span<const double> unseen = {}, const sim::ClosingModel& model = {});

std::string fit_text(const FitJob&, const FitReport&, const std::vector<FitCell>&);
std::string fit_json(const FitJob&, const FitReport&, const std::vector<FitCell>&,
                     const NextMeasurements& = {});

}  // namespace powbench::host
