#include <cmath>
#include <cstdio>
#include <stdexcept>

#include "sim/magnetics/magnet_shape_fields.h"
#include "sim/magnetics/plane/core_mesh.h"

namespace powbench::sim {
namespace {

std::string text(double value) {
  char buffer[32];
  std::snprintf(buffer, sizeof buffer, "%.6g", value);
  return buffer;
}

/// What single ranges cannot say: parts that overlap.
struct Fit {
  const MagnetShape& s;
  std::vector<ShapeError> errors;

  /// `key` must not exceed `most`, m.
  void within(const char* key, double value, double most, const std::string& because) {
    constexpr double round_off = 1e-9;
    if (value > most + round_off)
      errors.push_back(
          {key, text(value * 1e3), "up to " + text(std::fmax(0, most * 1e3)) + " (" + because + ")"});
  }

  void check() {
    within("shape.coil_width_mm", s.coil_width, s.window_width, "shape.window_width_mm");
    within("shape.coil_height_mm", s.coil_height, s.fixed_window - s.coil_offset,
           "fixed window less coil offset");
    within("shape.centre_gap_mm", s.centre_gap, 0.1 * s.fixed_window, "a tenth of shape.fixed_window_mm");
    const bool closed = s.closed_leg != 0;
    if (closed && s.legs != 2)
      errors.push_back({"shape.closed_leg", text(s.closed_leg), "0 (shape.legs is not 2)"});
    if (closed && s.ring_share > 0)
      errors.push_back(
          {"shape.ring_share", text(s.ring_share), "0 (shape.closed_leg: no pole face for a ring)"});
    if (!(s.ring_share > 0)) return;
    within("shape.ring_slot_mm", s.ring_slot, 0.5 * s.outer_width,
           "half of shape.outer_width_mm: the pole around the ring");
    within("shape.ring_depth_mm", s.ring_depth, 0.5 * s.fixed_window, "half of shape.fixed_window_mm");
    constexpr double least_side = 0.2e-3;  // of the ring between coil and leg
    if ((s.window_width - s.coil_width) / 2 < least_side)
      within("shape.ring_depth_mm", s.ring_depth, s.fixed_window - s.coil_offset - s.coil_height,
             "the coil leaves no room beside the leg");
  }
};

}  // namespace

std::vector<ShapeError> shape_errors(const MagnetShape& shape) {
  std::vector<ShapeError> errors;
  const auto range = [&](const char* key, double value, double si_per_unit, double low, double high) {
    constexpr double round_off = 1e-12;
    const double shown = value / si_per_unit;
    if (shown >= low - round_off * std::fabs(low) && shown <= high + round_off * std::fabs(high)) return;
    errors.push_back({std::string("shape.") + key, text(shown), text(low) + " .. " + text(high)});
  };
#define POWBENCH_X(member, key, unit, low, high, meaning) range(key, shape.member, unit, low, high);
  POWBENCH_MAGNET_SHAPE(POWBENCH_X)
#undef POWBENCH_X
  if (!errors.empty()) return errors;
  Fit fit{shape, {}};
  fit.check();
  return fit.errors;
}

void check_shape(const MagnetShape& s) {
  const auto errors = shape_errors(s);
  if (errors.empty()) return;
  std::string all;
  for (const auto& e : errors)
    all += (all.empty() ? "" : "\n") + e.key + " = " + e.value + ", allowed " + e.range;
  throw std::invalid_argument(all);
}

}  // namespace powbench::sim
