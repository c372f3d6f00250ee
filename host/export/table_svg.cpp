#include <fmt/format.h>

#include "host/export/field_svg.h"
#include "host/export/surface_plot.h"

namespace powbench::host {

std::string table_svg(const sim::TablePotential& t, const std::string& title) {
  constexpr double milli = 1e-3, even_gap = 0.3, even_current = 0.02;
  const SurfaceAxis psi{"flux linkage, Wb", 0, t.table().largest_psi(), 0};
  const SurfaceAxis gap{"gap, mm", 0, t.table().gap.back() / milli, even_gap};
  const auto at = [&](double flux, double mm) {
    // the ring flux in step with the coil's
    const double ring = t.has_ring() ? t.table().ring.back() * flux / t.table().largest_psi() : 0;
    return t.at({flux, ring, mm * milli});
  };
  const std::string heading =
      "<text x=\"14\" y=\"24\" font-weight=\"bold\" font-size=\"14\">" + title + "</text>\n";
  const SurfacePlot plots[] = {
      {"energy W", psi, gap, {"J", 0, 1, 0}, [&](double x, double y) { return at(x, y).energy; }},
      {"current i = dW/dpsi",
       psi,
       gap,
       {"A", 0, 1, even_current},
       [&](double x, double y) { return at(x, y).current; }},
      {"pull F = dW/dgap", psi, gap, {"N", 0, 1, 0}, [&](double x, double y) { return at(x, y).pull; }}};
  const double width = 3 * surface_width, height = surface_height + 30;
  std::string svg = fmt::format(
      "<svg xmlns=\"http://www.w3.org/2000/svg\" width=\"{0:.0f}\" height=\"{1:.0f}\" "
      "viewBox=\"0 0 {0:.0f} {1:.0f}\" font-family=\"sans-serif\" font-size=\"12\">\n"
      "<rect width=\"{0:.0f}\" height=\"{1:.0f}\" fill=\"#fff\"/>\n",
      width, height);
  svg += heading;
  double left = 0;
  for (const auto& plot : plots) {
    svg += surface_svg(plot, left, 30);
    left += surface_width;
  }
  return svg + "</svg>\n";
}

}  // namespace powbench::host
