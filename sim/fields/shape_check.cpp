#include <cmath>
#include <cstdio>
#include <stdexcept>

#include "sim/fields/core_mesh.h"

namespace powbench::sim {
namespace {

std::string text(double value) {
  char buffer[32];
  std::snprintf(buffer, sizeof buffer, "%.6g", value);
  return buffer;
}

struct Length {
  const char* key;
  double MagnetShape::*field;
  double low, high;  ///< mm
};

constexpr Length lengths[] = {
    {"magnet.centre_width_mm", &MagnetShape::centre_width, 2, 200},
    {"magnet.outer_width_mm", &MagnetShape::outer_width, 1, 100},
    {"magnet.window_width_mm", &MagnetShape::window_width, 1, 200},
    {"magnet.fixed_window_mm", &MagnetShape::fixed_window, 2, 300},
    {"magnet.moving_window_mm", &MagnetShape::moving_window, 0, 300},
    {"magnet.yoke_mm", &MagnetShape::yoke, 1, 100},
    {"magnet.stack_mm", &MagnetShape::stack, 1, 300},
    {"magnet.coil_width_mm", &MagnetShape::coil_width, 0.5, 200},
    {"magnet.coil_height_mm", &MagnetShape::coil_height, 0.5, 300},
    {"magnet.coil_offset_mm", &MagnetShape::coil_offset, 0, 100},
    {"magnet.centre_gap_mm", &MagnetShape::centre_gap, 0, 2},
};

struct Checker {
  const MagnetShape& s;
  std::vector<ShapeError> errors;

  void length(const char* key, double value, double low, double high) {
    const double shown = value * 1e3;
    if (!(shown >= low * (1 - 1e-12) && shown <= high * (1 + 1e-12)))
      errors.push_back({key, text(shown), text(low) + " .. " + text(high)});
  }

  void ring() {
    if (!(s.ring_share >= 0 && s.ring_share < 1))
      errors.push_back({"magnet.ring_share", text(s.ring_share), "0 (no ring) .. below 1"});
    if (!(s.ring_share > 0)) return;
    const double outer = s.outer_width * 1e3;
    const double room = 0.5 * outer;
    length("magnet.ring_slot_mm", s.ring_slot, 0.2, room);
    length("magnet.ring_depth_mm", s.ring_depth, 0.2, 0.5e3 * s.fixed_window);
    const double clear = (s.window_width - s.coil_width) / 2;
    const double coil_top = s.fixed_window - s.coil_offset - s.coil_height;
    if (clear < 0.2e-3 && coil_top < s.ring_depth)
      errors.push_back(
          {"magnet.ring_depth_mm", text(s.ring_depth * 1e3),
           "up to " + text(std::fmax(0, coil_top * 1e3)) + ": the coil leaves no room beside the leg"});
  }
};

}  // namespace

std::vector<ShapeError> shape_errors(const MagnetShape& s) {
  Checker c{s, {}};
  for (const auto& l : lengths) c.length(l.key, s.*l.field, l.low, l.high);
  if (!(s.stack_factor >= 0.5 && s.stack_factor <= 1))
    c.errors.push_back({"magnet.stack_factor", text(s.stack_factor), "0.5 .. 1"});
  if (!c.errors.empty()) return c.errors;  // the fits below would only repeat them
  c.length("magnet.coil_width_mm", s.coil_width, 0.5, s.window_width * 1e3);
  c.length("magnet.coil_height_mm", s.coil_height, 0.5, (s.fixed_window - s.coil_offset) * 1e3);
  c.length("magnet.centre_gap_mm", s.centre_gap, 0, 0.1e3 * s.fixed_window);
  c.ring();
  return c.errors;
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
