// A surface in a box: ticks, order of the cells, range.

#include "host/export/surface_plot.h"

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

TEST_CASE("surface: ticks are round, ascend and lie on the axis, stretched or not", "[host]") {
  CHECK(SurfaceAxis{"", 0, 1.3, 0}.ticks(5) == std::vector<double>{0, 0.5, 1});
  CHECK(SurfaceAxis{"", 0, 880, 0}.ticks(6) == std::vector<double>{0, 200, 400, 600, 800});
  const SurfaceAxis bent{"", 0, 7, 0.3};
  const auto list = bent.ticks(5);
  CHECK(list.front() == 0);
  CHECK(list.size() >= 4);
  for (std::size_t k = 1; k < list.size(); ++k) CHECK(bent.share(list[k]) - bent.share(list[k - 1]) > 0.15);
  CHECK(list.back() <= 7);
  for (const double s : {0.0, 0.2, 0.7, 1.0}) CHECK(bent.share(bent.value(s)) == Approx(s).margin(1e-12));
}

TEST_CASE("surface: every cell once, from the back to the front; the vertical axis ends at the largest value",
          "[host]") {
  SurfacePlot plot{
      "bowl", {"x", 0, 2, 0}, {"y", 0, 3, 0}, {"z", 0, 1, 0}, [](double x, double y) { return x * y; }};
  plot.cells = 7;
  const std::string svg = "<svg xmlns=\"http://www.w3.org/2000/svg\">" + surface_svg(plot, 0, 0) + "</svg>";
  CHECK(test::xml_error(svg).empty());
  CHECK(count(svg, "Z\" fill=") == 49);
  CHECK(count(svg, ">6</text>") == 1);  // 2 times 3
  // the first cell reaches the corner behind, which is highest; the last one the corner in front, which is lowest
  const auto last_y = [&](std::size_t path) {
    double low = 0;
    for (std::size_t at = path; svg[at] != 'Z'; ++at)
      if (svg[at] == ' ') low = std::fmax(low, std::stod(svg.substr(at + 1)));
    return low;
  };
  const std::string cell = "<path d=\"M";
  const std::size_t group = svg.find("stroke-linejoin");
  CHECK(last_y(svg.find(cell, group) + 9) < last_y(svg.rfind(cell) + 9));
}

TEST_CASE("surface: what is not a number, or below zero, stands at zero", "[host]") {
  const SurfacePlot plot{"odd", {"x", 0, 1, 0}, {"y", 0, 1, 0}, {"z", 0, 1, 0}, [](double x, double) {
                           return x > 0.5 ? std::nan("") : x - 9;
                         }};
  const std::string svg = surface_svg(plot, 0, 0);
  CHECK(count(svg, "nan") == 0);
  CHECK(count(svg, "inf") == 0);
}
