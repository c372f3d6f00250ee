#pragma once

#include <string>
#include <string_view>

#include "host/report/report.h"

namespace powbench::host {

/// The closings of the input that bring their raw films, in the form that `panels.js` draws: JSON, times in ms, each
/// curve as 16-bit counts in base64. Empty: there is none.
std::string closings_json(const ReportInput&);

/// What a page needs to draw them; each empty where the program was built without the charting library.
struct ChartAssets {
  std::string_view library, links, style;
  std::string_view panels;  ///< closingPanels(root, closings, options), ours
};
const ChartAssets& chart_assets();

}  // namespace powbench::host
