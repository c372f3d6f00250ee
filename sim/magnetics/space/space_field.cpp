#include <algorithm>
#include <cmath>
#include <cstdio>
#include <functional>

#include "sim/magnetics/space/space_magnet.h"

namespace powbench::sim {
namespace {

using SourceField = std::function<Vec3(const Vec3&)>;

/// T of all parts of a role in series; nothing without one.
SourceField series_field(const SpaceMagnet& d, DrawnRole role) {
  std::vector<SourceField> parts;
  for (const auto& p : d.parts)
    if (p.role == role) parts.push_back(space::coil_field(p.coil));
  if (parts.empty()) return {};
  return [parts](const Vec3& at) {
    Vec3 sum{};
    for (const auto& t : parts) sum += t(at);
    return sum;
  };
}

std::string in_mm(double metres) {
  char text[32];
  std::snprintf(text, sizeof text, "%.5g", metres * 1e3);
  return text;
}

}  // namespace

bool SpaceMagnet::has_ring() const {
  return std::any_of(parts.begin(), parts.end(),
                     [](const SpacePart& p) { return p.role == DrawnRole::ring; });
}

double SpaceMagnet::turns() const {
  double sum = 0;
  for (const auto& p : parts)
    if (p.role == DrawnRole::coil) sum += p.images * std::fabs(p.coil.turns);
  return sum;
}

space::MagnetField space_field(const SpaceMagnet& d, bool bare, const space::NewtonOptions& options) {
  space::Moving m;
  m.problem.mesh = d.mesh;
  for (const auto& p : d.parts) {
    if (p.steel < 0 || bare) {
      m.problem.media.push_back(space::air());
      continue;
    }
    const Steel& steel = d.steels[static_cast<std::size_t>(p.steel)];
    m.problem.media.push_back(d.sheets < 0 ? space::solid(steel)
                                           : space::laminated(steel, d.stack_factor, d.sheets));
  }
  m.problem.windings.push_back(series_field(d, DrawnRole::coil));
  if (d.has_ring()) m.problem.windings.push_back(series_field(d, DrawnRole::ring));
  m.problem.copies = d.copies;
  m.motion = d.motion;
  for (const double rise : d.motion) m.layer.push_back(rise == 1 ? 1 : 0);
  if (d.mesh.cell == space::Cell::tet10) set_middles(d.mesh, m.layer);
  m.gap = d.drawn_gap;
  m.residual = d.residual_gap;
  return space::MagnetField(std::move(m), options);
}

std::string winding_error(const SpaceMagnet& d, std::size_t number) {
  const SpacePart& part = d.parts[number];
  const space::BoxCoil& coil = part.coil;
  const auto along = static_cast<std::size_t>(coil.axis);
  const char axis = "xyz"[coil.axis];
  const double little = 1e-4 * (coil.high - coil.low);
  double volume = 0;
  for (int c = 0; c < d.mesh.count(); ++c) {
    const int* cell = d.mesh.cells.data() + static_cast<std::ptrdiff_t>(c) * 10;
    Vec3 centre{};
    double low = 1e300, high = -1e300;
    Vec3 corner[4];
    for (int k = 0; k < 4; ++k) {
      corner[k] = d.mesh.nodes[static_cast<std::size_t>(cell[k])];
      centre += 0.25 * corner[k];
      low = std::min(low, corner[k][along]);
      high = std::max(high, corner[k][along]);
    }
    const auto region = static_cast<std::size_t>(d.mesh.region[static_cast<std::size_t>(c)]);
    if (region == number) volume += space::six_volumes(corner[0], corner[1], corner[2], corner[3]) / 6;
    if (coil.from_opening(centre) >= (region == number ? 1 : 0.9) * coil.width) continue;
    const std::string& name = d.parts[region].name;
    for (const double end : {coil.low, coil.high})
      if (low < end - little && high > end + little && region != number)
        return "tetrahedra of '" + name + "' pass through the plane " + axis + " = " + in_mm(end) +
               " mm, in which the section ends: cut the drawing there, across the whole opening";
    if (high <= coil.low + little || low >= coil.high - little) continue;
    for (int k = 0; k < 4; ++k)
      if (d.motion[static_cast<std::size_t>(cell[k])] != 0 || d.parts[region].role == DrawnRole::stretch)
        return "'" + name +
               "' reaches into its opening, and moves or stretches: what lies there has to stand still";
  }
  const double drawn = volume * d.copies / part.images, wanted = coil.volume();
  if (std::fabs(drawn - wanted) <= 0.03 * wanted) return "";
  char text[200];
  std::snprintf(text, sizeof text,
                "the group and its mirror images fill %.5g mm3, a winding of this width and corner round the "
                "same box %.5g mm3",
                drawn * 1e9, wanted * 1e9);
  return text;
}

}  // namespace powbench::sim
