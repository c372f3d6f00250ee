#pragma once

#include <functional>
#include <limits>
#include <string>
#include <vector>

#include "core/events.h"
#include "host/paper/published.h"

/// Our own value beside each published one, with errors recomputed against the published measurement.

namespace powbench::host {

/// One closing in the terms of the papers. SI (s, A, m, N); NaN = unknown.
struct PublishedView {
  double t_ct1 = unknown;     ///< first contact touch
  double t_ct_bon = unknown;  ///< contact bounce time: t_ct2 - t_ct1
  double t_ct2 = unknown;     ///< last contact touch
  double t_xt1 = unknown;     ///< first arrival of the core; also serves as t_core
  double t_xt_bon = unknown;  ///< core bounce time: t_xt2 - t_xt1
  double t_xt2 = unknown;     ///< last arrival of the core
  double i_m = unknown;  ///< current where the curves differ most; NaN: the papers do not print the instant
  double x_m = unknown;  ///< travel where the curves differ most; NaN for the same reason
  double bounce_interval_1 = unknown;  ///< first to second touch
  double bounce_interval_2 = unknown;  ///< second to third touch
  double F_bounce_1 = unknown;         ///< largest force of one break during the first touch
  double F_bounce_2 = unknown;         ///< the same during the second touch
};

/// The view of extracted events: times from `timing_train`, forces from film A.
PublishedView published_view(const Events&);

/// Our closing at an angle in degrees, under the tables' conditions (230 V rms, 50 Hz). Called once per angle.
using ClosingProvider = std::function<PublishedView(double theta_deg)>;

/// One line of `powbench tables`. Values in `published.unit`.
struct TableRow {
  PublishedRow published;
  double ours = unknown;           ///< NaN = no comparable value exists; `note` says why
  double error_percent = unknown;  ///< ours against the published measurement
  double held_out = unknown;       ///< prediction of a specimen identified without this angle; NaN = none
  double held_out_error_percent = unknown;
  bool excluded = false;  ///< takes no part in the summary; `note` says why
  std::string note;
};

/// Every published row in its order. Statements without a closing angle are read at 0 deg. `held_out`, where given,
/// predicts an angle from closings at the others; its views may be NaN.
std::vector<TableRow> evaluate_tables(const ClosingProvider&, const ClosingProvider& held_out = {});

/// Mean and largest error of one quantity over the rows that are not excluded: in its unit over all of them, in per
/// cent over those whose measured value is not 0.
struct TableSummary {
  std::string quantity;
  int rows = 0;  ///< rows behind the means in the unit
  std::string unit{};
  double ours_off = unknown, ours_off_max = unknown;  ///< mean and largest |ours - measured|, in the unit
  int percent_rows = 0;  ///< of them, those with a measured value other than 0: a relative error exists
  int excluded = 0;      ///< rows left out
  double ours_mean = unknown, ours_max = unknown;
  int held_out_rows = 0;
  double held_out_mean = unknown, held_out_max = unknown;
  double paper_mean = unknown,
         paper_max = unknown;  ///< the paper's simulation over the same rows, recomputed
};

/// One entry per quantity of the closing tables, in order of appearance.
std::vector<TableSummary> summarise(const std::vector<TableRow>&);

}  // namespace powbench::host
