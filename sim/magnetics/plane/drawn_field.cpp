#include <algorithm>
#include <array>
#include <cmath>
#include <map>
#include <stdexcept>
#include <utility>

#include "sim/magnetics/plane/drawn_magnet.h"

namespace powbench::sim {
namespace {

std::size_t place(int i) {
  return static_cast<std::size_t>(i);
}

FieldSetup drawn_setup(const DrawnMagnet& d, int order) {
  FieldSetup f;
  f.order = order;
  f.axisymmetric = d.axisymmetric;
  f.depth = d.copies * d.depth;
  f.steels = d.steels;
  // of an armature mirrored at the gap, each copy of a winding links its own flux: all in series, as `copies` counts
  // them
  Winding coil, ring;
  for (std::size_t k = 0; k < d.parts.size(); ++k) {
    const auto& p = d.parts[k];
    f.steel_of_region.push_back(p.steel);
    if (p.role == DrawnRole::coil) coil.parts.emplace_back(static_cast<int>(k), p.turns);
    if (p.role == DrawnRole::ring) ring.parts.emplace_back(static_cast<int>(k), p.turns);
  }
  f.windings.push_back(coil);
  if (!ring.parts.empty()) f.windings.push_back(ring);
  return f;
}

/// The part that moves as one: 1, elsewhere 0.
std::vector<double> whole_only(const std::vector<double>& motion) {
  const double most = *std::max_element(motion.begin(), motion.end());
  std::vector<double> out;
  for (const double m : motion) out.push_back(m == most ? most : 0);
  return out;
}

}  // namespace

bool DrawnMagnet::has_ring() const {
  return std::any_of(parts.begin(), parts.end(),
                     [](const DrawnPart& p) { return p.role == DrawnRole::ring; });
}

double DrawnMagnet::turns() const {
  double out = 0, in = 0;
  for (const auto& p : parts)
    if (p.role == DrawnRole::coil) (p.turns > 0 ? out : in) += std::fabs(p.turns);
  return std::max(out, in) * (copies == 4 ? 2 : 1);
}

DrawnGap::DrawnGap(std::shared_ptr<const DrawnMagnet> drawing, int order)
    : GapField(FieldProblem(drawing->mesh, drawn_setup(*drawing, order))),
      drawing_(std::move(drawing)),
      layer_(whole_only(drawing_->motion)) {}

void DrawnGap::set_gap(double gap) {
  if (!(gap >= 0))
    throw std::invalid_argument("gap_mm = " + std::to_string(gap * 1e3) + ", allowed 0 and above");
  const auto& d = *drawing_;
  const double rise = gap + d.residual_gap - d.drawn_gap;
  auto y = d.mesh.y;
  for (std::size_t k = 0; k < y.size(); ++k) y[k] += rise * d.motion[k];
  problem_.move_vertices(d.mesh.x, std::move(y));
  pull_ = PullForm(problem_.space(), d.motion);
  rough_ = PullForm(problem_.space(), layer_);
}

DrawnField::DrawnField(DrawnGap gap, const NewtonOptions& options)
    : options_(options), gap_(std::move(gap)), newton_(gap_.problem()) {}

DrawnField::DrawnField(const DrawnField& other)
    : options_(other.options_), gap_(other.gap_), newton_(gap_.problem()) {}

FieldPoint DrawnField::at_flux(double psi, double ring, std::vector<double> start, bool ring_open) {
  return state_in(gap_.with_fluxes(psi, ring, ring_open), gap_, newton_, std::move(start), options_);
}

FieldPoint DrawnField::at_current(double current, double ring_current, std::vector<double> start) {
  return state_in(gap_.with_currents(current, ring_current), gap_, newton_, std::move(start), options_);
}

DrawnMagnet refined(const DrawnMagnet& d) {
  DrawnMagnet out = d;
  const auto& m = d.mesh;
  auto& fine = out.mesh;
  struct Middle {
    int vertex, triangles;
  };
  std::map<std::pair<int, int>, Middle> middles;
  const auto middle = [&](int a, int b) {
    auto [it, added] = middles.try_emplace(std::minmax(a, b), Middle{static_cast<int>(fine.x.size()), 0});
    ++it->second.triangles;
    if (added) {
      fine.x.push_back(0.5 * (m.x[place(a)] + m.x[place(b)]));
      fine.y.push_back(0.5 * (m.y[place(a)] + m.y[place(b)]));
      fine.zero.push_back(0);
      out.motion.push_back(0.5 * (d.motion[place(a)] + d.motion[place(b)]));
    }
    return it->second.vertex;
  };
  fine.triangle.clear();
  fine.region.clear();
  for (std::size_t t = 0; t < m.triangle.size(); ++t) {
    const auto [a, b, c] = m.triangle[t];
    const int ab = middle(a, b), bc = middle(b, c), ca = middle(c, a);
    for (const auto& part :
         {std::array{a, ab, ca}, std::array{ab, b, bc}, std::array{ca, bc, c}, std::array{ab, bc, ca}})
      fine.triangle.push_back(part);
    fine.region.insert(fine.region.end(), 4, m.region[t]);
  }
  for (const auto& [ends, mid] : middles)
    if (mid.triangles == 1 && m.zero[place(ends.first)] != 0 && m.zero[place(ends.second)] != 0)
      fine.zero[place(mid.vertex)] = 1;
  return out;
}

std::vector<double> on_refined(const FieldSpace& coarse, const std::vector<double>& a,
                               const FieldSpace& fine) {
  // corners of the four parts in the order of `refined`: those of the triangle, then the middles of 01, 12, 20
  constexpr std::array<std::array<double, 3>, 6> node{
      {{1, 0, 0}, {0, 1, 0}, {0, 0, 1}, {0.5, 0.5, 0}, {0, 0.5, 0.5}, {0.5, 0, 0.5}}};
  constexpr std::array<std::array<int, 3>, 4> parts{{{0, 3, 5}, {3, 1, 4}, {5, 4, 2}, {3, 4, 5}}};
  std::vector<double> out(place(fine.size()) + 1, 0);
  for (std::size_t t = 0; t < fine.mesh.triangle.size(); ++t) {
    const auto& corner = parts[t % 4];
    for (std::size_t n = 0; n < place(fine.nodes); ++n) {
      const auto &p = node[place(corner[n % 3])], &q = node[place(corner[n < 3 ? n : (n + 1) % 3])];
      const auto shape =
          shape_at(coarse, t / 4, {0.5 * (p[0] + q[0]), 0.5 * (p[1] + q[1]), 0.5 * (p[2] + q[2])});
      double sum = 0;
      for (std::size_t k = 0; k < place(coarse.nodes); ++k)
        sum += shape.value[k] * a[place(coarse.unknowns(t / 4)[k])];
      out[place(fine.unknowns(t)[n])] = sum;
    }
  }
  out.back() = 0;
  return out;
}

double saturated_flux(const std::shared_ptr<const DrawnMagnet>& drawing) {
  DrawnField field(DrawnGap(drawing, 1), {1e-6}), air(field);
  air.set_air();
  air.set_gap(0);
  field.set_gap(0);
  const double wanted = saturated_stiffness * air.at_flux(1e-3, 0, {}, true).response.current_psi;
  // 1 mT over the section of the drawing or thereabouts: far below saturation
  const auto [x0, x1] = std::minmax_element(drawing->mesh.x.begin(), drawing->mesh.x.end());
  double low = drawing->turns() * 1e-4 * (*x1 - *x0) * (drawing->axisymmetric ? *x1 : drawing->depth),
         high = low;
  std::vector<double> a, tangent;
  double at = 0;
  const auto stiff = [&](double psi) {
    for (std::size_t k = 0; k < a.size(); ++k) a[k] += (psi - at) * tangent[k];
    auto p = field.at_flux(psi, 0, std::move(a), true);
    if (!p.newton.converged) throw std::runtime_error("field: no convergence on the way to saturation");
    a = std::move(p.a);
    tangent = field.tangent(0);
    at = psi;
    return p.response.current_psi >= wanted;
  };
  if (stiff(low))
    throw std::invalid_argument(
        "the closed magnet is as stiff as half of air from no flux on: does its iron lack air, or meet "
        "nowhere?");
  constexpr double stride = 1.6;
  for (int k = 0; !stiff(high); ++k) {
    if (k == 40)
      throw std::invalid_argument("the steel does not saturate up to " + std::to_string(high) +
                                  " Wb: the end of the table, largest_flux_Wb, has to be given");
    low = high;
    high *= stride;
  }
  for (int k = 0; k < 4; ++k) {
    const double mid = std::sqrt(low * high);
    (stiff(mid) ? high : low) = mid;
  }
  return high;
}

}  // namespace powbench::sim
