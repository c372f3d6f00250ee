#pragma once

#include <string>
#include <string_view>
#include <vector>

#include "host/report/decimate.h"
#include "host/report/markup.h"
#include "host/report/ticks.h"

/// Small SVG plots: one panel with axes, to be put alone or stacked into an <svg>. Lengths are in user units of the
/// SVG.

namespace powbench::host {

/// Colours that stay apart for colour-blind eyes (after Okabe and Ito) and in grey print.
namespace colour {
inline constexpr std::string_view measured = "#0072B2";
inline constexpr std::string_view simulated = "#D55E00";
inline constexpr std::string_view published = "#00795A";
inline constexpr std::string_view ink = "#1f2933";
inline constexpr std::string_view soft = "#5b6875";
inline constexpr std::string_view frame = "#b8c1ca";
inline constexpr std::string_view grid = "#e6eaee";
}  // namespace colour

struct Stroke {
  std::string_view color = colour::ink;
  double width = 1.0;
  double opacity = 1.0;
  std::string_view dash = "";  ///< SVG dash pattern; empty = solid
};

enum class Shape { circle, square, triangle, diamond };

/// How a series of points is marked.
struct Marker {
  Shape shape = Shape::circle;
  std::string_view color = colour::ink;
  double size = 4.0;
  bool filled = true;
  double opacity = 1.0;
};

struct XY {
  double x = 0, y = 0;
};

class Plot {
 public:
  /// Area inside the axes; labels and legend go around it.
  struct Box {
    double left = 0, top = 0, width = 0, height = 0;
  };

  Plot(Box box, Range x, Range y);

  // Drawn in the order of the calls; everything but labels is clipped to the box. Points that are not finite are left
  // out.
  void grid(const Ticks& x_ticks, const Ticks& y_ticks);
  void shade_x(double from, double to, std::string_view color, double opacity);
  void shade_y(double from, double to, std::string_view color, double opacity);
  void vertical(double x, const Stroke&);
  void horizontal(double y, const Stroke&);
  void trace(const std::vector<TracePoint>&, double y_scale, const Stroke&);
  void line(const std::vector<XY>&, const Stroke&);
  /// Filled between y - half[i] and y + half[i] around each point; a point that is not finite ends an area and begins
  /// the next.
  void band(const std::vector<XY>&, const std::vector<double>& half, std::string_view color, double opacity);
  void error_bar(XY at, double half_height, const Stroke&);
  void point(XY at, const Marker&);
  void bar(double x0, double x1, double y0, double y1, std::string_view color, double opacity);

  // Around the box.
  void frame();
  void x_labels(const Ticks&, std::string_view title, std::string_view suffix = "");
  void y_labels(const Ticks&, std::string_view title);
  void note(double x, std::string_view text, std::string_view color,
            int row);                               ///< above the box, centred on x
  void text_left(double y, std::string_view text);  ///< beside the axis, level with y

  struct LegendEntry {
    std::string text;
    Stroke stroke;
    bool has_line = true;
    Marker marker = {};
    bool has_marker = false;
  };
  /// One row of entries, right-aligned above the box.
  void legend(const std::vector<LegendEntry>&, double height_above);

  Markup finish() const;

 private:
  double px(double x) const;
  double py(double y) const;
  bool visible(double x) const;
  void path(std::string_view d, const Stroke&);

  Box box_;
  Range x_, y_;
  Markup inside_;   // clipped
  Markup outside_;  // axes and labels
};

/// A figure as a file of its own: with background, font, and a line above that says what it shows.
std::string standing_alone(std::string svg, std::string_view about);

/// Opens nothing: a whole <svg> of this size around the panels, with a title for those who cannot see it.
Markup figure(double width, double height, std::string_view title, const std::vector<Markup>& panels);

}  // namespace powbench::host
