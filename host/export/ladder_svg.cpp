#include "host/export/ladder_svg.h"

#include <algorithm>
#include <cmath>

#include "host/export/log_plot.h"

namespace powbench::host {

std::string ladder_svg(const sim::Ladder& ladder, std::span<const sim::Rung> rungs,
                       const std::string& title) {
  const bool timed = std::none_of(ladder.rows.begin(), ladder.rows.end(),
                                  [](const auto& row) { return std::isnan(row.run.cpu); });
  const auto cost = [timed](const sim::LadderRun& run) {
    return timed ? run.cpu * 1e3 : static_cast<double>(run.evaluations);
  };
  LogPlot plot{title,
               timed ? "CPU time of a closing, ms" : "evaluations of the right-hand side",
               "worst of touch, seat, settled, us",
               {},
               {}};
  plot.notes = {"full: error against the", "rung's finest setting", "dashed: its estimate"};
  for (std::size_t r = 0; r < rungs.size(); ++r) {
    LogLine error{rungs[r].name(), {}, static_cast<int>(r)};
    LogLine estimate{"", {}, static_cast<int>(r), true};
    for (const auto& row : ladder.rows) {
      if (row.run.rung != r) continue;
      error.points.push_back({cost(row.run), sim::largest(row.error) * 1e6});
      estimate.points.push_back({cost(row.run), sim::largest(row.estimate) * 1e6});
    }
    plot.lines.push_back(std::move(error));
    plot.lines.push_back(std::move(estimate));
  }
  return log_plot_svg(plot);
}

}  // namespace powbench::host
