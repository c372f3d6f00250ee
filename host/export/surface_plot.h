#pragma once

#include <functional>
#include <string>
#include <vector>

/// A function of two variables as a surface in a box with axes, as SVG.

namespace powbench::host {

/// From `low` to `high`. A `bend` above 0 stretches small values: steps are even in log(1 + |x| / bend), and `low` is
/// 0 then.
struct SurfaceAxis {
  std::string label;  ///< with unit
  double low = 0, high = 1;
  double bend = 0;

  double share(double value) const;           ///< 0 .. 1 along the axis
  double value(double share) const;           ///< the other way round
  std::vector<double> ticks(int most) const;  ///< round values within the axis, about that many, ascending
};

/// The corner of both largest values is behind, that of both smallest in front, so that `z` should rise along x and
/// y. Cells are filled from the back to the front, each over what it hides.
struct SurfacePlot {
  std::string title;
  SurfaceAxis x, y;  ///< along the left and the right edge in front
  SurfaceAxis z;     ///< upwards; its range is found, `low` and `high` are not read
  std::function<double(double x, double y)> value;
  int cells = 36;  ///< along each axis
};

inline constexpr double surface_width = 430, surface_height = 430;  ///< of the picture, SVG units

/// An SVG group with its upper left corner at `left`, `top`. Values below 0 or not finite stand at 0.
std::string surface_svg(const SurfacePlot&, double left, double top);

}  // namespace powbench::host
