#pragma once

#include <string_view>
#include <vector>

#include "host/compare/curves.h"
#include "host/report/report.h"
#include "host/report/ticks.h"

/// The campaign as the sections of the report look at it.

namespace powbench::host {

struct AngleView {
  double angle = 0;                      ///< rad, polarity included
  std::vector<const ReportShot*> shots;  ///< of this angle, in executed order
  const SimulatedClosing* simulated = nullptr;
};

/// Every angle with a shot or a simulation, ascending.
std::vector<AngleView> angles_of(const ReportInput&);

/// How far coil current (i_m) and travel (x_m) of the simulation are from the measured ones, from switch-on to 2 ms
/// after the last landing of either; only curves that were recorded and simulated.
std::vector<CurveRow> curve_rows(const AngleView&);

/// Row of the comparison, or nullptr.
const ComparisonRow* row_at(const Comparison&, std::string_view quantity, double angle);

/// Published row of the closing tables, or nullptr.
const PublishedRow* published_at(const ReportInput&, std::string_view quantity, double angle);

const Waveform* find_waveform(const std::vector<Waveform>&, std::string_view channel);

/// Time axis of all waveform figures, ms: from shortly before switch-on to shortly after the last contact has settled.
Range time_window(const ReportInput&);

/// Smallest and largest value of a channel inside the window over all shots and simulations, SI.
Range channel_range(const ReportInput&, std::string_view channel, const Range& window_ms);

}  // namespace powbench::host
