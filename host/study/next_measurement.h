#pragma once

#include <limits>
#include <optional>
#include <string>
#include <vector>

#include "host/study/fit_job.h"

/// What to measure next: the quantity and the angle from which most is to be learnt about the device.

namespace powbench::host {

struct NextMeasurement {
  double theta_deg = 0;
  std::string quantity;  ///< symbol
  double bits = 0;       ///< expected information about the device, given the lines before
  double spread = 0;     ///< of the posterior's values there, relative
  double deviation = 0;  ///< of one measured value, relative: the model's and that of the measurement
  std::optional<int>
      shots;  ///< until their scatter adds less than a tenth to the model's; nothing: scatter not known
  double bounce_left = 0;  ///< spread of the bounce over all angles once this is known too, relative (rms)
};

struct NextMeasurements {
  int samples = 0, of = 0;   ///< of the posterior: those that close at every angle, all
  double bounce_spread = 0;  ///< of those samples, before any of them
  std::vector<NextMeasurement> list;
};

/// Touch, bounce, seat and core velocity every 15 deg of a half-wave that was not measured, best first: at most
/// `job.next`. Deviations are those granted, 5 % of the velocity. `posterior`: of all closings. Samples
/// that do not close at every angle take no part; empty without two.
NextMeasurements next_measurements(const FitJob& job, const FitFile&, const FitFold& posterior, sim::Team&);

std::string next_text(const NextMeasurements&);

}  // namespace powbench::host
