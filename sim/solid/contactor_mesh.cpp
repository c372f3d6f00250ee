#include "sim/solid/contactor_mesh.h"

#include <algorithm>
#include <cmath>
#include <stdexcept>

namespace powbench::sim {
namespace {

constexpr double pitch = 14e-3;       ///< m, pole to pole
constexpr double bridge_half = 3e-3;  ///< m, half width of a bridge
constexpr double column_from = 4e-3;  ///< m, from a pole's middle to the columns beside it
constexpr double bar_height = 4e-3;   ///< m, hook bar
constexpr double spring_room = 3e-3;  ///< m, between bridge and armature

/// Planes through all `marks`, no further apart than `cell`.
std::vector<double> planes(std::vector<double> marks, double cell) {
  std::sort(marks.begin(), marks.end());
  std::vector<double> all{marks.front()};
  for (std::size_t k = 1; k < marks.size(); ++k) {
    const double from = all.back(), length = marks[k] - from;
    if (length < 1e-9) continue;
    const int n = static_cast<int>(std::ceil(length / cell - 1e-9));
    for (int i = 1; i <= n; ++i) all.push_back(from + length * i / n);
  }
  return all;
}

double middle(const std::vector<double>& p, int k) {
  return 0.5 * (p[static_cast<std::size_t>(k)] + p[static_cast<std::size_t>(k) + 1]);
}

/// Rest of a mass spread over an area gives a thickness.
double thickness(const char* key, double mass, double density, double other_volume, double area) {
  const double t = (mass / density - other_volume) / area;
  if (!(t > 0.5e-3))
    throw std::invalid_argument(std::string(key) + " = " + std::to_string(mass * 1e3) + " g, must be > " +
                                std::to_string((other_volume + 0.5e-3 * area) * density * 1e3) +
                                " g for the lengths of this specimen");
  return t;
}

}  // namespace

ContactorMesh contactor_mesh(const Specimen& specimen, double cell) {
  if (!(cell >= 1e-4 && cell <= 1e-2))
    throw std::invalid_argument("cell = " + std::to_string(cell * 1e3) + " mm, must be in [0.1, 10] mm");
  const Bridges& b = specimen.bridges;
  const double seat = b.seat_half_length, outer = b.half_length + 2e-3, inner = b.half_length - 2e-3;
  if (!(inner > seat))
    throw std::invalid_argument("half_length = " + std::to_string(b.half_length * 1e3) +
                                " mm, must be > seat_half_length + 2 mm");
  if (!(specimen.core.travel > b.gap)) throw std::invalid_argument("travel_mm must be > gap_mm");
  const double half_y = 0.5 * pitch * b.poles;
  std::vector<double> poles, y_marks{-half_y, half_y};
  for (int k = 0; k < b.poles; ++k) {
    poles.push_back((k - 0.5 * (b.poles - 1)) * pitch);
    for (const double side : {-column_from, -bridge_half, bridge_half, column_from})
      y_marks.push_back(poles.back() + side);
  }
  ContactorMesh c;
  const SolidMaterial steel = known_material("steel"), iron = known_material("electrical_steel"),
                      copper = known_material("copper");
  c.bridge_thickness = thickness("bridges.mass_g", b.mass, copper.density, 0, 4 * outer * bridge_half);
  const double under = -c.bridge_thickness, floor = under - spring_room,
               stop = bar_height + specimen.core.travel;
  const double columns = 2 * half_y - 2 * column_from * b.poles;
  const double armature =
      thickness("core.mass_g", specimen.core.mass, iron.density,
                2 * seat * (2 * half_y * bar_height + columns * -floor), 4 * outer * half_y);
  const double plate = thickness("base.mass_g", specimen.base.mass, steel.density,
                                 2.0 * b.poles * 2 * bridge_half * 4e-3 * (stop - b.gap), 4 * outer * half_y);
  const std::vector<double> x = planes({-outer, -inner, -seat, seat, inner, outer}, cell),
                            y = planes(y_marks, cell);
  const auto pole_at = [&](double at, double half) {
    return std::any_of(poles.begin(), poles.end(), [&](double p) { return std::fabs(at - p) < half; });
  };
  c.mover = c.mesh.add_part("mover");
  const auto zm = planes({floor - armature, floor, 0, bar_height}, cell);
  add_grid(c.mesh, c.mover, x, y, zm, [&](int i, int j, int k) {
    const double z = middle(zm, k);
    if (z < floor) return true;
    return std::fabs(middle(x, i)) < seat && (z > 0 || !pole_at(middle(y, j), column_from));
  });
  c.materials.push_back(iron);
  c.base = c.mesh.add_part("base");
  const auto zb = planes({b.gap, stop, stop + plate}, cell);
  add_grid(c.mesh, c.base, x, y, zb, [&](int i, int j, int k) {
    return middle(zb, k) > stop || (std::fabs(middle(x, i)) > inner && pole_at(middle(y, j), bridge_half));
  });
  c.materials.push_back(steel);
  const auto zc = planes({under, 0}, cell);
  for (const double p : poles) {
    c.bridges.push_back(c.mesh.add_part("bridge " + std::to_string(c.bridges.size() + 1)));
    add_grid(c.mesh, c.bridges.back(), x, planes({p - bridge_half, p + bridge_half}, cell), zc,
             [](int, int, int) { return true; });
    c.materials.push_back(copper);
  }
  return c;
}

}  // namespace powbench::sim
