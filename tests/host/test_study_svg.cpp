#include <catch2/catch.hpp>

#include "host/study/study_svg.h"
#include "host/study/sweep_text.h"

using namespace powbench;
using namespace powbench::host;

TEST_CASE("pictures of studies are whole SVG files that show every point and angle", "[study]") {
  const auto count = [](const std::string& text, const std::string& word) {
    int n = 0;
    for (std::size_t at = text.find(word); at != std::string::npos; at = text.find(word, at + 1)) ++n;
    return n;
  };
  const sim::Design design({sim::uniform_axis("angle_deg", 0, 180)}, sim::Sampling::latin, 5, 1);
  std::vector<std::vector<double>> rows;
  for (int k = 0; k < 5; ++k) {
    sim::ClosingMetrics m;
    m.touch = 0.012 + 1e-3 * k;
    m.bounce = 0.005;
    rows.push_back(metric_values(m));
  }
  rows[4] = metric_values({});  // does not close: no point
  const std::string scatter = sweep_svg(design, rows);
  CHECK(scatter.starts_with("<svg"));
  CHECK(count(scatter, "<circle") == 8);
  CHECK(scatter.find("nan") == std::string::npos);

  const std::vector<sim::Sensitivity> list{{0.0, "supply_volts", 2.3, 0.0121, 0.012, 0.0118},
                                           {1.0, "supply_volts", 2.3, 0.0123, 0.012, 0.0117},
                                           {0.0, "core.mass_g", 1, 0.012, 0.012, 0.012}};
  const std::string bars = sensitivity_svg(list, *sim::find_metric("touch"));
  CHECK(bars.find("supply_volts") != std::string::npos);
  CHECK(bars.find("core.mass_g") != std::string::npos);

  sim::BestAngle best;
  best.angles = {0, 1, 2};
  best.draws = 4;
  best.closed = {4, 4, 4};
  best.mean = {0.006, 0.005, 0.007};
  best.low = {0.0055, 0.0045, 0.0065};
  best.high = {0.0065, 0.0055, 0.0075};
  best.mode_count = {1, 1, 2};
  best.best = 1;
  best.random_mean = 0.006;
  best.gain = 1.0 / 6;
  const std::string angle = best_angle_svg(best, *sim::find_metric("bounce"));
  CHECK(angle.find("Best closing angle 57 deg, 17 % below") != std::string::npos);

  FitCell cell{30, "t_ct1", 0.0119, 0.0118, {0.011, 0.0113, 0.0115}, 1, 5, 20};
  const std::string fitted = fit_svg({cell}, "fitted & held out");
  CHECK(fitted.find("fitted &amp; held out") != std::string::npos);
  CHECK(fitted.find("nan") == std::string::npos);
}
