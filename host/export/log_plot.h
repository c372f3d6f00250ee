#pragma once

#include <span>
#include <string>
#include <vector>

/// Two logarithmic axes and lines between them: work against precision, as SVG.

namespace powbench::host {

struct LogLine {
  struct Point {
    double x = 0, y = 0;  ///< above zero; others are left out
  };
  std::string name;  ///< in the legend; "" = not there
  std::vector<Point> points;
  int colour = 0;       ///< number in the palette, cyclic
  bool dashed = false;  ///< without marks
};

struct LogPlot {
  std::string title, x_label, y_label;
  std::vector<LogLine> lines;
  std::vector<std::string> notes = {};  ///< below the legend
};

std::string log_plot_svg(const LogPlot&);

}  // namespace powbench::host
