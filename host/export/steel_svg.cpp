#include "host/export/steel_svg.h"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <functional>

#include "host/export/log_axis.h"
#include "sim/magnetics/circuit/magnetic_circuit.h"

namespace powbench::host {
namespace {

constexpr double width = 720, left = 70, right = 690;
constexpr double most_b = 2.4;  // T shown

/// A box with its two axes; `across` and `up` give shares of width and height.
struct Panel {
  double top, bottom;
  std::function<double(double)> across, up;

  std::string place(double x, double y) const {
    return fmt::format("{:.1f},{:.1f}", left + across(x) * (right - left), bottom - up(y) * (bottom - top));
  }
  std::string frame(const std::vector<double>& xs, const std::vector<double>& ys, const char* x_label,
                    const char* y_label) const {
    std::string svg;
    for (const double x : xs) {
      const double px = left + across(x) * (right - left);
      svg += fmt::format("<path d=\"M{0:.1f} {1} V{2}\" stroke=\"#ddd\"/>\n", px, top, bottom);
      svg +=
          fmt::format("<text x=\"{:.1f}\" y=\"{}\" text-anchor=\"middle\">{:g}</text>\n", px, bottom + 16, x);
    }
    for (const double y : ys) {
      const double py = bottom - up(y) * (bottom - top);
      svg += fmt::format("<path d=\"M{0} {1:.1f} H{2}\" stroke=\"#ddd\"/>\n", left, py, right);
      svg +=
          fmt::format("<text x=\"{}\" y=\"{:.1f}\" text-anchor=\"end\">{:g}</text>\n", left - 6, py + 4, y);
    }
    svg += fmt::format("<rect x=\"{}\" y=\"{}\" width=\"{}\" height=\"{}\" fill=\"none\" stroke=\"#333\"/>\n",
                       left, top, right - left, bottom - top);
    svg += fmt::format("<text x=\"{}\" y=\"{}\" text-anchor=\"middle\">{}</text>\n", (left + right) / 2,
                       bottom + 36, x_label);
    return svg +
           fmt::format("<text transform=\"translate(18 {}) rotate(-90)\" text-anchor=\"middle\">{}</text>\n",
                       (top + bottom) / 2, y_label);
  }
};

struct Place {
  double x, y;
};

std::string line(const Panel& panel, const std::vector<Place>& places, bool dashed) {
  std::string path;
  for (const auto& p : places) path += panel.place(p.x, p.y) + " ";
  return fmt::format("<polyline points=\"{}\" fill=\"none\" stroke=\"#0b6fa4\" stroke-width=\"1.8\"{}/>\n",
                     path, dashed ? " stroke-dasharray=\"5 4\"" : "");
}

std::string mark(const Panel& panel, double x, double y) {
  const double px = panel.across(x), py = panel.up(y);
  if (!(px >= 0 && px <= 1 && py >= 0 && py <= 1)) return "";
  const auto at = panel.place(x, y);
  const auto comma = at.find(',');
  return fmt::format("<circle cx=\"{}\" cy=\"{}\" r=\"2.6\" fill=\"none\" stroke=\"#c2410c\"/>\n",
                     at.substr(0, comma), at.substr(comma + 1));
}

}  // namespace

std::string steel_svg(const sim::Steel& steel, const std::vector<sim::BhRow>& measured,
                      const std::string& title) {
  constexpr int points = 400;
  LogAxis h_axis, mu_axis;
  std::vector<Place> known, beyond, mu_known, mu_beyond;
  const double first = measured.empty() ? 0.02 : 0.005;
  for (int k = 0; k <= points; ++k) {
    const double b = first + (most_b - first) * k / points, h = steel.h(b), mu = b / (sim::mu0 * h);
    const bool inside = b <= steel.data_end();
    h_axis.include(h);
    mu_axis.include(mu);
    (inside ? known : beyond).push_back({h, b});
    (inside ? mu_known : mu_beyond).push_back({b, mu});
    if (inside) continue;
    if (beyond.size() == 1 && !known.empty()) {
      beyond.insert(beyond.begin(), known.back());
      mu_beyond.insert(mu_beyond.begin(), mu_known.back());
    }
  }
  h_axis.widen(1.1);
  mu_axis.widen(1.3);
  const std::vector<double> teslas{0, 0.4, 0.8, 1.2, 1.6, 2.0, 2.4};
  const auto tesla = [](double b) { return b / most_b; };
  const Panel curve{50, 330, [&](double h) { return h_axis.share(h); }, tesla};
  const Panel permeability{400, 600, tesla, [&](double m) { return mu_axis.share(m); }};
  std::string svg = fmt::format(
      "<svg xmlns=\"http://www.w3.org/2000/svg\" width=\"{0}\" height=\"680\" viewBox=\"0 0 {0} 680\" "
      "font-family=\"sans-serif\" font-size=\"12\">\n<rect width=\"{0}\" height=\"680\" fill=\"#fff\"/>\n",
      width);
  svg +=
      fmt::format("<text x=\"{}\" y=\"28\" font-weight=\"bold\" font-size=\"14\">{}</text>\n", left, title);
  svg += curve.frame(h_axis.ticks(), teslas, "H, A/m", "B, T");
  svg += permeability.frame(teslas, mu_axis.ticks(), "B, T", "B / (mu0 H)");
  for (const auto& r : measured) {
    svg += mark(curve, std::max(r.h, 1e-9), r.b);
    if (r.h > 0 && r.b > 0) svg += mark(permeability, r.b, r.b / (sim::mu0 * r.h));
  }
  svg += line(curve, known, false) + line(curve, beyond, true);
  svg += line(permeability, mu_known, false) + line(permeability, mu_beyond, true);
  svg += fmt::format("<text x=\"{}\" y=\"664\" fill=\"#555\">{}</text>\n", left,
                     measured.empty() ? "line: the curve; dashed: extrapolated"
                                      : "circles: rows of the file; line: the curve; dashed: extrapolated");
  return svg + "</svg>\n";
}

}  // namespace powbench::host
