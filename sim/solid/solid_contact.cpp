#include "sim/solid/solid_contact.h"

#include <algorithm>
#include <map>
#include <stdexcept>

#include "sim/solid/cell_batches.h"
#include "sim/solid/edge_pass.h"

namespace powbench::sim {
namespace {

void check_pair(const ContactPair& p, std::size_t parts, std::size_t number) {
  const auto need = [&](bool good, const char* key, double value, const char* range) {
    if (!good)
      throw std::invalid_argument("contact pair " + std::to_string(number) + ": " + key + " = " +
                                  std::to_string(value) + ", must be " + range);
  };
  const int count = static_cast<int>(parts);
  need(p.a >= 0 && p.a < count, "part a", p.a, "a part of the mesh");
  need(p.b >= 0 && p.b < count && p.b != p.a, "part b", p.b, "another part of the mesh");
  need(p.friction_static >= p.friction_dynamic, "friction_static", p.friction_static, ">= friction_dynamic");
  need(p.friction_dynamic >= 0, "friction_dynamic", p.friction_dynamic, ">= 0");
  need(p.decay >= 0, "decay", p.decay, ">= 0 s/m");
  need(p.shear_limit > 0, "shear_limit", p.shear_limit, "> 0 Pa");
  need(p.factor > 0, "factor", p.factor, "> 0");
  need(p.layer >= 0, "layer", p.layer, ">= 0 Pa/m");
  need(p.layer_damping >= 0, "layer_damping", p.layer_damping, ">= 0 Pa s/m");
  need(p.damping >= 0 && p.damping <= 1, "damping", p.damping, "in [0, 1]");
  need(p.stick_damping >= 0 && p.stick_damping <= 1, "stick_damping", p.stick_damping, "in [0, 1]");
}

}  // namespace

double friction_coefficient(const ContactPair& p, double speed) {
  return p.friction_dynamic + (p.friction_static - p.friction_dynamic) * std::exp(-p.decay * speed);
}

struct SolidContact::Impl {
  ContactOptions options;
  std::map<int, SolidSurface> surfaces;
  std::vector<double> inverse_mass;
  std::vector<ContactPass> passes;  ///< two a pair
  std::vector<EdgePass> edges;
  std::vector<ContactReport> reports;
  std::size_t nodes = 0;
  ContactSums sums;
  double margin = 0;               ///< m, within which candidates are known
  double fastest = 0, travel = 0;  ///< m/s at the latest check; m
  std::vector<Vec3> places;        ///< of the surface nodes at the latest search
  long searches = 0, until_check = 0;
  bool started = false;

  void search(const NodeView& view) {
    margin = 1e300;
    for (auto& p : passes) margin = std::min(margin, p.search(view));
    for (auto& e : edges) e.search(view);
    places.clear();
    for (const auto& [part, s] : surfaces)
      for (const int n : s.nodes) places.push_back(view.place(n));
    ++searches;
  }

  /// Searches anew when nodes may have come closer than the margin since the latest search; otherwise counts the steps
  /// until it could be so.
  void search_if_due(const NodeView& view, double dt) {
    if (until_check-- > 0) return;
    double moved = 0, speed = 0;
    std::size_t k = 0;
    const bool fresh = places.empty();
    for (const auto& [part, s] : surfaces)
      for (const int n : s.nodes) {
        if (!fresh) moved = std::max(moved, norm(view.place(n) - places[k++]));
        speed = std::max(speed, norm(view.velocity(n)));
      }
    fastest = speed;
    constexpr double steps = 8;
    if (fresh || 2 * (moved + 2 * steps * speed * dt) > margin) search(view);
    until_check = static_cast<long>(steps) - 1;
  }
};

SolidContact::SolidContact(const CellBatches& cells, const std::vector<double>& inverse_mass,
                           const ContactOptions& options)
    : impl_(std::make_unique<Impl>()) {
  Impl& m = *impl_;
  m.options = options;
  m.inverse_mass = inverse_mass;
  const SolidMesh& mesh = cells.mesh();
  for (std::size_t k = 0; k < m.options.pairs.size(); ++k) {
    const ContactPair& p = m.options.pairs[k];
    check_pair(p, mesh.parts.size(), k);
    for (const int part : {p.a, p.b})
      if (m.surfaces.count(part) == 0) m.surfaces[part] = surface_of(mesh, part, cells.material(part));
  }
  for (const ContactPair& p : m.options.pairs) {
    m.passes.emplace_back(p, m.surfaces.at(p.a), m.surfaces.at(p.b), m.inverse_mass);
    m.passes.emplace_back(p, m.surfaces.at(p.b), m.surfaces.at(p.a), m.inverse_mass);
    if (options.edges) m.edges.emplace_back(p, m.surfaces.at(p.a), m.surfaces.at(p.b));
  }
  m.reports.resize(m.options.pairs.size());
  m.nodes = mesh.nodes.size();
  const std::vector<double> rest(4 * mesh.nodes.size(), 0.0);
  const NodeView start{&mesh.nodes, rest.data(), rest.data()};
  m.search(start);
  for (std::size_t k = 0; k < m.passes.size(); ++k) {
    const double depth = -m.passes[k].deepest(start);
    const ContactPair& p = m.options.pairs[k / 2];
    if (depth > options.allowed_overlap)
      throw std::invalid_argument("parts '" + mesh.parts[static_cast<std::size_t>(p.a)] + "' and '" +
                                  mesh.parts[static_cast<std::size_t>(p.b)] + "': overlap by " +
                                  std::to_string(depth * 1e6) + " um at the start, allowed are " +
                                  std::to_string(options.allowed_overlap * 1e6));
  }
  m.places.clear();
  m.searches = 0;
}

SolidContact::~SolidContact() = default;

void SolidContact::apply(const NodeView& view, double dt, double ahead, NodeForces& forces,
                         NodeForces& damped) {
  Impl& m = *impl_;
  m.search_if_due(view, std::max(dt, ahead));
  m.travel += 4 * m.fastest *
              std::max(dt, ahead);  // twice what two nodes do, should they be faster by the next check
  for (auto& p : m.passes) p.set_travel(m.travel);
  m.sums.stored = 0;
  for (std::size_t k = 0; k < m.reports.size(); ++k) {
    m.reports[k] = {};
    m.passes[2 * k].apply(view, dt, 1, !m.started, forces, damped, m.sums, m.reports[k]);
    m.passes[2 * k + 1].apply(view, dt, -1, !m.started, forces, damped, m.sums, m.reports[k]);
    if (m.options.edges) m.edges[k].apply(view, forces, m.sums, m.reports[k]);
  }
  m.started = true;
}

double SolidContact::stored() const {
  return impl_->sums.stored;
}
double SolidContact::friction_lost() const {
  return impl_->sums.friction_lost;
}
const ContactReport& SolidContact::report(int pair) const {
  return impl_->reports.at(static_cast<std::size_t>(pair));
}
std::vector<double> SolidContact::node_pressure() const {
  std::vector<double> all(impl_->nodes, 0.0);
  for (const auto& p : impl_->passes) p.add_pressure(all);
  return all;
}
long SolidContact::searches() const {
  return impl_->searches;
}

std::vector<double> SolidContact::stiffness() const {
  std::vector<double> all(impl_->nodes, 0.0);
  for (const auto& p : impl_->passes) p.add_stiffness(all);
  return all;
}

std::vector<double> SolidContact::damping() const {
  std::vector<double> all(impl_->nodes, 0.0);
  for (const auto& p : impl_->passes) p.add_damping(all);
  return all;
}

std::vector<double> SolidContact::memory() const {
  const Impl& m = *impl_;
  std::vector<double> all{m.sums.stored, m.sums.friction_lost, m.started ? 1.0 : 0.0};
  for (const auto& p : m.passes)
    for (const Anchor& a : p.anchors)
      all.insert(all.end(), {a.force.x, a.force.y, a.force.z, a.area, a.zero, a.touching ? 1.0 : 0.0});
  return all;
}

void SolidContact::restore_memory(const std::vector<double>& all) {
  Impl& m = *impl_;
  std::size_t size = 3;
  for (const auto& p : m.passes) size += 6 * p.anchors.size();
  if (all.size() != size) throw std::invalid_argument("restart: the saved contact belongs to another mesh");
  m.sums = {all[0], all[1]};
  m.started = all[2] != 0;
  auto from = all.begin() + 3;
  for (auto& p : m.passes)
    for (Anchor& a : p.anchors) {
      a = {{from[0], from[1], from[2]}, from[3], from[4], from[5] != 0};
      from += 6;
    }
  m.places.clear();  // candidates are found anew; which faces are looked at does not change which is nearest
  m.until_check = 0;
}

}  // namespace powbench::sim
