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

/// m: no point of one box is nearer to any of the other.
double gap_between(const Box& a, const Box& b) {
  double gap = 0;
  for (int i = 0; i < 3; ++i) gap = std::max({gap, a.lo[i] - b.hi[i], b.lo[i] - a.hi[i]});
  return gap;
}

}  // namespace

double friction_coefficient(const ContactPair& p, double speed) {
  if (p.friction_static == p.friction_dynamic) return p.friction_dynamic;
  return p.friction_dynamic + (p.friction_static - p.friction_dynamic) * std::exp(-p.decay * speed);
}

struct SolidContact::Impl {
  /// How far the nodes within reach of one pair have moved against each other.
  struct Course {
    double travel = 0;    ///< m, all ways added up
    double check_at = 0;  ///< m, travel before which no search is needed
  };

  ContactOptions options;
  std::map<int, SolidSurface> surfaces;
  std::map<int, NearSurface> near;  ///< by part, as the surfaces
  std::vector<double> inverse_mass;
  std::vector<ContactPass> passes;  ///< two a pair
  std::vector<EdgePass> edges;
  std::vector<ContactReport> reports;
  std::vector<Course> courses;  ///< one a pair
  std::size_t nodes = 0;
  ContactSums sums;
  double reach = 0;  ///< m, beyond which nothing was taken in at the latest survey
  double margin = 0, largest_margin = 0;
  long searches = 0;
  long unwatched = 0;  ///< steps to the next look at what is beyond reach
  bool known = false;  ///< candidates are
  bool started = false;

  const NearSurface& first(std::size_t pair) const { return near.at(options.pairs[pair].a); }
  const NearSurface& second(std::size_t pair) const { return near.at(options.pairs[pair].b); }

  /// What is within reach of another part. The rest needs no look until it has moved that far.
  void survey(const NodeView& view) {
    std::map<int, Box> boxes;
    largest_margin = 0;
    for (auto& [part, s] : near) {
      s.forget(view);
      boxes[part] = s.box(view);
      largest_margin = std::max(largest_margin, s.largest_margin(view, options.edges));
    }
    double apart = 1e300;
    for (const ContactPair& p : options.pairs)
      apart = std::min(apart, gap_between(boxes.at(p.a), boxes.at(p.b)));
    reach = options.exhaustive ? 1e300 : std::max(6 * largest_margin, 0.9 * apart);
    for (auto& [part, box] : boxes) box.grow(reach);
    for (const ContactPair& p : options.pairs) {
      near.at(p.a).reach_into(boxes.at(p.b), view);
      near.at(p.b).reach_into(boxes.at(p.a), view);
    }
    for (auto& [part, s] : near) s.settle(view);
    unwatched = 0;
  }

  void search(const NodeView& view) {
    margin = 1e300;
    for (auto& p : passes) margin = std::min(margin, p.search(view, options.exhaustive));
    for (auto& e : edges) margin = std::min(margin, e.search(view, options.exhaustive));
    for (auto& [part, s] : near) s.note_search();
    for (Course& c : courses) c.check_at = c.travel + 0.5 * margin;
    known = true;
    ++searches;
  }

  /// Whether a node may have come into reach, and so near that it could meet a face which is no candidate. While there
  /// is way left, nobody needs to look: in a step no node moves by more than half of the largest face against another,
  /// or it would skip the depth in which contact acts.
  bool survey_due(const NodeView& view) {
    if (--unwatched > 0) return false;
    double left = reach - largest_margin;
    for (std::size_t k = 0; k < courses.size(); ++k)
      left = std::min(left, reach - largest_margin -
                                largest_between(first(k).since_reach(view), second(k).since_reach(view)));
    unwatched = left > largest_margin ? static_cast<long>(left / largest_margin) : 1;
    return left < 0;
  }

  /// The same for the nodes within reach. The travel adds up all the ways; only where they could be long enough is it
  /// measured how far the nodes are from where they were.
  bool search_due() {
    for (std::size_t k = 0; k < courses.size(); ++k) {
      Course& c = courses[k];
      if (c.travel < c.check_at) continue;
      const double left = 0.5 * margin - largest_between(first(k).since_search(), second(k).since_search());
      if (left <= 0) return true;
      c.check_at = c.travel + left;
    }
    return false;
  }

  void follow(const NodeView& view) {
    if (!known || options.exhaustive || survey_due(view)) {
      survey(view);
      search(view);
      return;
    }
    for (auto& [part, s] : near) s.follow(view);
    for (std::size_t k = 0; k < courses.size(); ++k)
      courses[k].travel += largest_between(first(k).step(), second(k).step());
    if (search_due()) search(view);
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
  for (const auto& [part, s] : m.surfaces) m.near.emplace(part, NearSurface(s));
  for (const ContactPair& p : m.options.pairs) {
    const NearSurface &a = m.near.at(p.a), &b = m.near.at(p.b);
    m.passes.emplace_back(p, a, b, m.inverse_mass);
    m.passes.emplace_back(p, b, a, m.inverse_mass);
    if (options.edges) m.edges.emplace_back(p, a, b);
  }
  for (auto& p : m.passes) p.keeps_pressed = options.pressures;
  m.courses.resize(m.options.pairs.size());
  m.reports.resize(m.options.pairs.size());
  m.nodes = mesh.nodes.size();
  const std::vector<double> rest(4 * mesh.nodes.size(), 0.0);
  const NodeView start{&mesh.nodes, rest.data(), rest.data()};
  m.follow(start);
  for (std::size_t k = 0; k < m.passes.size(); ++k) {
    const double depth = -m.passes[k].deepest(start);
    const ContactPair& p = m.options.pairs[k / 2];
    if (depth > options.allowed_overlap)
      throw std::invalid_argument("parts '" + mesh.parts[static_cast<std::size_t>(p.a)] + "' and '" +
                                  mesh.parts[static_cast<std::size_t>(p.b)] + "': overlap by " +
                                  std::to_string(depth * 1e6) + " um at the start, allowed are " +
                                  std::to_string(options.allowed_overlap * 1e6));
  }
  m.known = false;
  m.searches = 0;
}

SolidContact::~SolidContact() = default;

void SolidContact::apply(const NodeView& view, double dt, NodeForces& forces, NodeForces& damped) {
  Impl& m = *impl_;
  m.follow(view);
  m.sums.stored = 0;
  for (std::size_t k = 0; k < m.reports.size(); ++k) {
    const double travel = m.courses[k].travel;
    ContactReport& report = m.reports[k];
    report = {};
    m.passes[2 * k].apply(view, dt, 1, !m.started, travel, forces, damped, m.sums, report);
    m.passes[2 * k + 1].apply(view, dt, -1, !m.started, travel, forces, damped, m.sums, report);
    if (m.options.edges) m.edges[k].apply(view, forces, m.sums, report);
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
  m.known = false;  // candidates are found anew; which faces are looked at does not change which is nearest
}

}  // namespace powbench::sim
