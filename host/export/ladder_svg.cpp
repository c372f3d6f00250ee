#include "host/export/ladder_svg.h"

#include "host/export/log_plot.h"

namespace powbench::host {

std::string ladder_svg(const sim::Ladder& ladder, std::span<const sim::Rung> rungs,
                       const std::string& title) {
  LogPlot plot{title, "CPU time of a closing, ms", "worst of touch, seat, settled, us", {}, {}};
  plot.notes = {"full: error against the", "rung's finest setting", "dashed: its estimate"};
  for (std::size_t r = 0; r < rungs.size(); ++r) {
    LogLine error{rungs[r].name(), {}, static_cast<int>(r)};
    LogLine estimate{"", {}, static_cast<int>(r), true};
    for (const auto& row : ladder.rows) {
      if (row.run.rung != r) continue;
      error.points.push_back({row.run.cpu * 1e3, sim::largest(row.error) * 1e6});
      estimate.points.push_back({row.run.cpu * 1e3, sim::largest(row.estimate) * 1e6});
    }
    plot.lines.push_back(std::move(error));
    plot.lines.push_back(std::move(estimate));
  }
  return log_plot_svg(plot);
}

}  // namespace powbench::host
