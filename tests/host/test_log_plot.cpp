// Work against precision as a picture.

#include "host/export/log_plot.h"

#include <algorithm>
#include <catch2/catch.hpp>
#include <cmath>

#include "tests/host/report_xml_check.h"

using namespace powbench::host;

namespace {

std::size_t count(const std::string& text, const std::string& word) {
  std::size_t n = 0;
  for (std::size_t at = text.find(word); at != std::string::npos; at = text.find(word, at + 1)) ++n;
  return n;
}

}  // namespace

TEST_CASE("logarithmic plot: a mark a point, none where it has no place, names in the legend", "[host]") {
  LogPlot plot{"error against cost", "ms", "s", {}};
  plot.lines.push_back({"own", {{1, 1e-6}, {2, 1e-8}, {3, 0}, {4, std::nan("")}}, 0});
  plot.lines.push_back({"", {{1, 2e-6}, {2, 3e-8}}, 0, true});
  plot.lines.push_back({"other", {{10, 1e-5}}, 1});
  const std::string svg = log_plot_svg(plot);
  CHECK(test::xml_error(svg).empty());
  CHECK(count(svg, "<circle") == 3);
  CHECK(count(svg, "<polyline") == 3);
  CHECK(count(svg, "stroke-dasharray") == 1);
  CHECK(count(svg, ">own</text>") == 1);
  CHECK(count(svg, ">other</text>") == 1);
  CHECK(count(svg, "nan") == 0);
  CHECK(test::xml_error(log_plot_svg({"empty", "x", "y", {}})).empty());
}
