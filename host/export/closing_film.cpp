#include "host/export/closing_film.h"

#include "sim/solid/solid_surface.h"

namespace powbench::host {
namespace {

using namespace sim;

constexpr double slower = 100;

/// z of the bodies, the closing direction, is up; up is y in glTF.
std::array<float, 3> upright(const Vec3& p) {
  return {static_cast<float>(p.x), static_cast<float>(p.z), static_cast<float>(-p.y)};
}

}  // namespace

VtuGrid state_grid(const ExplicitSolid& s, const ContactorMesh& c) {
  VtuGrid g;
  VtuField u{"displacement [m]", 3, {}}, v{"velocity [m/s]", 3, {}}, mises{"von Mises stress [Pa]", 1, {}},
      part{"part", 1, {}};
  for (int n = 0; n < static_cast<int>(c.mesh.nodes.size()); ++n) {
    const Vec3 &p = c.mesh.nodes[static_cast<std::size_t>(n)], d = s.displacement(n), w = s.velocity(n);
    for (int i = 0; i < 3; ++i) {
      g.points.push_back(p[i] + d[i]);
      u.values.push_back(d[i]);
      v.values.push_back(w[i]);
    }
  }
  const auto stress = s.cells().stresses(s.displacements());
  for (std::size_t e = 0; e < c.mesh.cells.size(); ++e) {
    const auto& n = c.mesh.cells[e].nodes;
    g.add_cell(VtkCell::hexahedron, {n.begin(), n.end()});
    mises.values.push_back(von_mises(stress[e]));
    part.values.push_back(c.mesh.cells[e].part);
  }
  g.point_fields = {u, v};
  g.cell_fields = {mises, part};
  return g;
}

ClosingFilm::ClosingFilm(Format format, Write write, double flight_interval)
    : format_(format), write_(std::move(write)), interval_(flight_interval) {}

void ClosingFilm::operator()(const ExplicitSolid& s, const ContactorMesh& c) {
  if (times_.empty()) contactor_ = c;
  const bool again = !times_.empty() && s.time() <= times_.back();
  if (!s.stopped() && (again || (s.is_rigid(c.mover) && s.time() < next_))) return;
  if (again) forget_last();  // what stopped the run shows in the newest state of its instant
  next_ = s.time() + interval_;
  times_.push_back(s.time());
  if (format_ == Format::gltf) {
    for (int p = 0; p < static_cast<int>(c.mesh.parts.size()); ++p)
      shifts_[p].push_back(upright(s.mean_displacement(p)));
    return;
  }
  const std::string name = "closing_" + std::to_string(steps_.size()) + ".vtu";
  write_(name, to_vtu(state_grid(s, c)));
  steps_.push_back({s.time(), name, 0});
}

void ClosingFilm::forget_last() {
  times_.pop_back();
  for (auto& [part, shift] : shifts_) shift.pop_back();
  if (!steps_.empty()) steps_.pop_back();
}

void ClosingFilm::finish() {
  if (format_ == Format::vtu) {
    write_("closing.pvd", to_pvd(steps_));
    return;
  }
  GltfFilm film;
  for (const double t : times_) film.times.push_back(static_cast<float>(slower * t));
  for (int p = 0; p < static_cast<int>(contactor_.mesh.parts.size()); ++p) film.bodies.push_back(body(p));
  write_("closing.gltf", to_gltf(film));
}

GltfBody ClosingFilm::body(int part) const {
  GltfBody b;
  b.name = contactor_.mesh.parts[static_cast<std::size_t>(part)];
  b.shift = shifts_.at(part);
  b.colour = part == contactor_.mover  ? std::array<float, 4>{0.35F, 0.45F, 0.6F, 1}
             : part == contactor_.base ? std::array<float, 4>{0.6F, 0.6F, 0.6F, 1}
                                       : std::array<float, 4>{0.8F, 0.45F, 0.2F, 1};
  const SolidSurface skin =
      surface_of(contactor_.mesh, part, contactor_.materials[static_cast<std::size_t>(part)]);
  for (const int n : skin.nodes)
    b.points.push_back(upright(contactor_.mesh.nodes[static_cast<std::size_t>(n)]));
  for (const Facet& f : skin.facets) {
    std::array<std::uint32_t, 4> k{};
    for (std::size_t c = 0; c < 4; ++c) k[c] = static_cast<std::uint32_t>(skin.place_of(f.nodes[c]));
    b.faces.push_back({k[0], k[1], k[2]});
    b.faces.push_back({k[0], k[2], k[3]});
  }
  return b;
}

}  // namespace powbench::host
