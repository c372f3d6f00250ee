#include "host/export/field_frame.h"

#include <fmt/format.h>

#include <algorithm>

#include "host/export/colour_scale.h"

namespace powbench::host {
namespace {

constexpr double largest_b = 2.4;  // T
constexpr int shades = 32;

std::string legend(double x, double y) {
  std::string out;
  constexpr double width = 14, height = 180;
  for (int k = 0; k < shades; ++k)
    out += fmt::format("<rect x=\"{:.1f}\" y=\"{:.1f}\" width=\"{}\" height=\"{:.2f}\" fill=\"{}\"/>\n", x,
                       y + height * (shades - 1 - k) / shades, width, height / shades + 0.3,
                       scale_colour((k + 0.5) / shades));
  for (const double b : {0.0, 0.6, 1.2, 1.8, 2.4})
    out += fmt::format("<text x=\"{:.1f}\" y=\"{:.1f}\">{:.1f} T{}</text>\n", x + width + 5,
                       y + height * (1 - b / largest_b) + 4, b, b < largest_b ? "" : " +");
  return out;
}

}  // namespace

int field_shade(double b) {
  return std::min(shades, static_cast<int>(b / largest_b * shades));
}

std::string framed_field(const FieldDrawing& picture, const std::string& title) {
  const double x = (picture.left - field_margin) * field_pixels,
               right = (picture.right + field_margin) * field_pixels,
               y = (picture.top + field_margin) * field_pixels;
  const double height = (picture.top - picture.bottom + 2 * field_margin) * field_pixels;
  std::string body = "<g id=\"mesh\">\n";
  for (const auto& [shade, path] : picture.fills) {
    const auto c = scale_colour((shade + 0.5) / shades);
    body += fmt::format("<path d=\"{}\" fill=\"{}\" stroke=\"{}\" stroke-width=\"0.4\"/>\n", path, c, c);
  }
  body +=
      fmt::format("<path d=\"{}\" fill=\"none\" stroke=\"#222\" stroke-width=\"0.7\"/>\n", picture.contours);
  body += fmt::format("<path d=\"{}\" fill=\"none\" stroke=\"#000\" stroke-width=\"1.3\"/>\n</g>\n",
                      picture.outlines);
  const double top_room = 34, legend_room = 80;
  std::string svg = fmt::format(
      "<svg xmlns=\"http://www.w3.org/2000/svg\" xmlns:xlink=\"http://www.w3.org/1999/xlink\" "
      "width=\"{0:.0f}\" height=\"{1:.0f}\" "
      "viewBox=\"{2:.0f} {3:.0f} {0:.0f} {1:.0f}\" font-family=\"sans-serif\" font-size=\"13\">\n",
      right - x + legend_room, height + top_room, x, -y - top_room);
  svg += fmt::format("<rect x=\"{:.0f}\" y=\"{:.0f}\" width=\"100%\" height=\"100%\" fill=\"#fff\"/>\n", x,
                     -y - top_room);
  svg += fmt::format(
      "<clipPath id=\"frame\"><rect x=\"{:.0f}\" y=\"{:.0f}\" width=\"{:.0f}\" "
      "height=\"{:.0f}\"/></clipPath>\n",
      x, -y, right - x, height);
  svg += "<g clip-path=\"url(#frame)\">\n" + body;
  if (picture.half) svg += "<use xlink:href=\"#mesh\" transform=\"scale(-1,1)\"/>\n";
  svg += "</g>\n";
  svg +=
      fmt::format("<text x=\"{:.0f}\" y=\"{:.0f}\" font-weight=\"bold\">{}</text>\n", x + 8, -y - 12, title);
  svg += legend(right + 14, -y + 20);
  return svg + "</svg>\n";
}

}  // namespace powbench::host
