#pragma once

#include <map>
#include <string>

/// What all pictures of fields share: scale, size, frame.

namespace powbench::host {

inline constexpr double field_pixels = 6e3;   ///< a metre
inline constexpr double field_margin = 8e-3;  ///< m, around what is shown

/// Number of the shade of a flux density, T.
int field_shade(double b);

struct FieldDrawing {
  double left = 0, right = 0, bottom = 0, top = 0;  ///< m, without the margin; y grows upwards
  bool half = false;                                ///< the other half is the mirror image at x = 0
  std::map<int, std::string> fills;                 ///< [shade] path data, in pixels
  std::string contours, outlines;                   ///< path data, in pixels
};

/// The picture with its title and the scale of |B|, as SVG.
std::string framed_field(const FieldDrawing&, const std::string& title);

}  // namespace powbench::host
