#include "sim/fields/solenoid_mesh.h"

#include <algorithm>
#include <array>
#include <cstdio>
#include <iterator>
#include <stdexcept>

#include "sim/fields/grid.h"

namespace powbench::sim {
namespace {

constexpr double least = 0.05e-3, longest = 0.5, gap_clearance = 1e-3;

void need(bool holds, const char* key, double value, const char* range) {
  if (holds) return;
  char text[160];
  std::snprintf(text, sizeof text, "solenoid.%s_mm = %g, allowed %s", key, value * 1e3, range);
  throw std::invalid_argument(text);
}

void append(std::vector<double>& lines, const std::vector<double>& more) {
  lines.insert(lines.end(), more.begin() + (lines.empty() ? 0 : 1), more.end());
}

double flange_bottom(const SolenoidShape& s) {
  return s.window - s.stop_length;
}

double coil_top(const SolenoidShape& s) {
  return flange_bottom(s) - s.coil_clearance;
}

std::vector<double> radii(const SolenoidShape& s, const CoreMeshSizes& z) {
  auto lines = graded_lines({{0, 0},
                             {s.plunger_radius, z.corner},
                             {s.bore_radius, z.corner},
                             {s.coil_inner, z.other},
                             {s.coil_outer, z.other},
                             {s.case_inner, z.other},
                             {s.case_outer, z.other}},
                            z.growth, z.iron);
  append(lines, graded_lines({{s.case_outer, z.other}, {6 * s.case_outer, 0}}, z.growth, z.far));
  return lines;
}

std::vector<double> levels(const SolenoidShape& s, const CoreMeshSizes& z, double gap, double far) {
  const double bottom = -s.stop_length - s.plate, flange_top = flange_bottom(s) + s.flange,
               end = gap + s.plunger_length;
  auto lines = graded_lines({{-far, 0}, {bottom, z.other}}, z.growth, z.far);
  append(lines, graded_lines({{bottom, z.other},
                              {-s.stop_length, z.other},
                              {s.coil_clearance - s.stop_length, z.other},
                              {0, z.corner}},
                             z.growth, z.iron));
  std::vector<double> layers;
  for (const double share : strip_layers(z, gap)) layers.push_back(share * gap);
  append(lines, layers);
  append(lines, graded_lines({{gap, z.corner},
                              {coil_top(s), z.other},
                              {flange_bottom(s), z.corner},
                              {flange_top, z.corner},
                              {end, z.other}},
                             z.growth, z.iron));
  append(lines, graded_lines({{end, z.other}, {far, 0}}, z.growth, z.far));
  return lines;
}

int region_of(const SolenoidShape& s, double r, double z, double gap) {
  if (r < s.plunger_radius && z > gap && z < gap + s.plunger_length) return SolenoidRegion::plunger;
  const double top = flange_bottom(s);
  if (r > s.case_outer || z > top + s.flange || z < -s.stop_length - s.plate) return SolenoidRegion::air;
  if (z < -s.stop_length || r > s.case_inner) return SolenoidRegion::fixed_iron;
  if (r < s.plunger_radius && z < 0) return SolenoidRegion::fixed_iron;
  if (z > top) return r > s.bore_radius ? SolenoidRegion::fixed_iron : SolenoidRegion::air;
  const bool coil = r > s.coil_inner && r < s.coil_outer && z > s.coil_clearance - s.stop_length &&
                    z < top - s.coil_clearance;
  return coil ? SolenoidRegion::coil : SolenoidRegion::air;
}

}  // namespace

void check_solenoid(const SolenoidShape& s, double largest_gap) {
  struct Length {
    const char* key;
    double value;
  };
  const std::array<Length, 6> radius{{{"plunger_radius", s.plunger_radius},
                                      {"bore_radius", s.bore_radius},
                                      {"coil_inner", s.coil_inner},
                                      {"coil_outer", s.coil_outer},
                                      {"case_inner", s.case_inner},
                                      {"case_outer", s.case_outer}}};
  double before = 0;
  for (const auto& [key, value] : radius) {
    need(value >= before + least && value <= longest, key, value, "0.05 above the radius inside it .. 500");
    before = value;
  }
  for (const auto& [key, value] :
       {Length{"plunger_length", s.plunger_length}, Length{"plate", s.plate}, Length{"flange", s.flange},
        Length{"coil_clearance", s.coil_clearance}, Length{"window", s.window}})
    need(value >= least && value <= longest, key, value, "0.05 .. 500");
  need(s.stop_length > s.coil_clearance + least && s.stop_length < s.window, "stop_length", s.stop_length,
       "above the coil's clearance, below the window");
  need(largest_gap >= 0.1e-3 && largest_gap <= coil_top(s) - gap_clearance, "gap", largest_gap,
       "0.1 .. 1 below the winding's end");
  need(s.plunger_length >= flange_bottom(s) + s.flange + gap_clearance, "plunger_length", s.plunger_length,
       "1 more than what reaches from the stop through the flange");
}

SolenoidGrid::SolenoidGrid(const SolenoidShape& shape, const CoreMeshSizes& sizes, double largest_gap)
    : shape_(shape), reference_(largest_gap) {
  check_solenoid(shape, largest_gap);
  far_ = 4 * (shape.plunger_length + largest_gap);
  mesh_ = tensor_mesh(radii(shape, sizes), levels(shape, sizes, reference_, far_),
                      [&](double r, double z) { return region_of(shape, r, z, reference_); }, {});
}

double SolenoidGrid::moved(double z, double gap) const {
  // pieces of the axis that stretch, each linearly; what lies between stands still
  const double top = coil_top(shape_), out = flange_bottom(shape_) + shape_.flange;
  const std::array<double, 6> from{0, reference_, top, out, reference_ + shape_.plunger_length, far_},
      to{0, gap, top, out, gap + shape_.plunger_length, far_};
  if (z <= 0 || z >= far_) return z;
  const auto k = static_cast<std::size_t>(
      std::distance(from.begin(), std::upper_bound(from.begin() + 1, from.end() - 1, z)));
  return to[k - 1] + (z - from[k - 1]) / (from[k] - from[k - 1]) * (to[k] - to[k - 1]);
}

std::vector<double> SolenoidGrid::heights(double gap) const {
  std::vector<double> z(mesh_.y);
  for (double& value : z) value = moved(value, gap);
  return z;
}

std::vector<double> SolenoidGrid::motion(double gap) const {
  std::vector<double> weight;
  const double end = gap + shape_.plunger_length;
  const auto z = heights(gap);
  for (std::size_t k = 0; k < z.size(); ++k) {
    const double across =
        std::clamp((shape_.bore_radius - mesh_.x[k]) / (shape_.bore_radius - shape_.plunger_radius), 0., 1.);
    const double below = std::clamp(z[k] / gap, 0., 1.);
    const double above = std::clamp(1 - (z[k] - end) / reference_, 0., 1.);
    weight.push_back(across * below * above);
  }
  return weight;
}

}  // namespace powbench::sim
