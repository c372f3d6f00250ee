#include "sim/magnetics/plane/solenoid_mesh.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <cstdio>
#include <initializer_list>
#include <iterator>
#include <stdexcept>

#include "sim/magnetics/plane/grid.h"

namespace powbench::sim {
namespace {

constexpr double least = 0.05e-3, longest = 0.5, gap_clearance = 1e-3, face_clearance = 1e-3;
constexpr int least_across = 4;  ///< cells, of the clearance beside a pin
constexpr double radian = 0.017453292519943295;

void need(bool holds, const char* key, double value, const std::string& range) {
  if (holds) return;
  char text[160];
  std::snprintf(text, sizeof text, "solenoid.%s_mm = %g, allowed %s", key, value * 1e3, range.c_str());
  throw std::invalid_argument(text);
}

/// Of a length in m.
std::string millimetres(double length) {
  char text[40];
  std::snprintf(text, sizeof text, "%.4g", length * 1e3);
  return text;
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

/// Air kept between pin and rim of a stepped face where their levels cross, m.
double seam_height(const SolenoidShape& s, double gap) {
  return std::min(0.25 * gap, s.step_clearance);
}

/// Beside the hole: the level of the pin's face, kept between rim and shoulder.
double upper_seam(const SolenoidShape& s, double gap) {
  const double seam = seam_height(s, gap);
  return std::clamp(gap - s.step_depth, seam, gap - seam);
}

/// Below the pin: the level of the rim, kept between hole and pin.
double lower_seam(const SolenoidShape& s, double gap) {
  const double seam = seam_height(s, gap);
  return std::clamp(0.0, seam - s.step_depth, gap - s.step_depth - seam);
}

std::vector<double> radii(const SolenoidShape& s, const CoreMeshSizes& z) {
  std::vector<GridStop> stops{{0, 0}};
  if (s.face == PlungerFace::conical && s.tip_radius > 0) stops.push_back({s.tip_radius, z.corner});
  if (s.face == PlungerFace::stepped) {
    const double fine = std::min(z.corner, s.step_clearance / least_across);
    stops.push_back({s.step_radius, fine});
    stops.push_back({s.step_radius + s.step_clearance, fine});
  }
  for (const GridStop& stop : std::initializer_list<GridStop>{{s.plunger_radius, z.corner},
                                                              {s.bore_radius, z.corner},
                                                              {s.coil_inner, z.other},
                                                              {s.coil_outer, z.other},
                                                              {s.case_inner, z.other},
                                                              {s.case_outer, z.other}})
    stops.push_back(stop);
  auto lines = graded_lines(stops, z.growth, z.iron);
  append(lines, graded_lines({{s.case_outer, z.other}, {6 * s.case_outer, 0}}, z.growth, z.far));
  return lines;
}

std::vector<double> levels(const SolenoidShape& s, const CoreMeshSizes& z, double gap, double far) {
  const double bottom = -s.stop_length - s.plate, flange_top = flange_bottom(s) + s.flange,
               end = gap + s.plunger_length;
  auto lines = graded_lines({{-far, 0}, {bottom, z.other}}, z.growth, z.far);
  std::vector<GridStop> low{{bottom, z.other}, {-s.stop_length, z.other}};
  const double winding = s.coil_clearance, magnet = s.magnet_length;
  for (const double from : {std::min(winding, magnet), std::max(winding, magnet)})
    if (from > 0 && from - s.stop_length > low.back().at + 0.5 * least)
      low.push_back({from - s.stop_length, z.other});
  low.push_back({s.face == PlungerFace::stepped ? -s.step_depth : 0, z.corner});
  append(lines, graded_lines(low, z.growth, z.iron));
  const auto layer = [&](double from, double to, double height) {
    std::vector<double> layers;
    for (const double share : strip_layers(z, height)) layers.push_back(from + share * (to - from));
    append(lines, layers);
  };
  if (s.face == PlungerFace::stepped) {
    const double seam = upper_seam(s, gap);
    layer(-s.step_depth, 0, std::max(s.step_depth, gap));
    layer(0, seam, gap);
    layer(seam, gap, std::max(s.step_depth, gap));
  } else
    layer(0, gap, gap);
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
  if (s.face == PlungerFace::stepped && r < s.plunger_radius && z > -s.step_depth && z < gap) {
    if (r < s.step_radius) return z > upper_seam(s, gap) ? SolenoidRegion::plunger : SolenoidRegion::air;
    if (r < s.step_radius + s.step_clearance) return SolenoidRegion::air;
  }
  if (r < s.plunger_radius && z > gap && z < gap + s.plunger_length) return SolenoidRegion::plunger;
  const double top = flange_bottom(s);
  if (r > s.case_outer || z > top + s.flange || z < -s.stop_length - s.plate) return SolenoidRegion::air;
  if (z < -s.stop_length || r > s.case_inner) return SolenoidRegion::fixed_iron;
  if (r < s.plunger_radius && z < 0)
    return z < s.magnet_length - s.stop_length ? SolenoidRegion::magnet : SolenoidRegion::fixed_iron;
  if (z > top) return r > s.bore_radius ? SolenoidRegion::fixed_iron : SolenoidRegion::air;
  const bool coil = r > s.coil_inner && r < s.coil_outer && z > s.coil_clearance - s.stop_length &&
                    z < top - s.coil_clearance;
  return coil ? SolenoidRegion::coil : SolenoidRegion::air;
}

/// The numbers of the face, each where it belongs.
void check_face(const SolenoidShape& s) {
  const bool cone = s.face == PlungerFace::conical, step = s.face == PlungerFace::stepped;
  if (cone ? !(s.cone_angle >= 5 * radian - 1e-9 && s.cone_angle <= 75 * radian + 1e-9) : s.cone_angle != 0) {
    char text[160];
    std::snprintf(text, sizeof text, "solenoid.cone_angle_deg = %g, allowed %s", s.cone_angle / radian,
                  cone ? "5 .. 75" : "0 unless the face is conical");
    throw std::invalid_argument(text);
  }
  const std::string to_conical = "0 unless the face is conical", to_stepped = "0 unless the face is stepped";
  need(cone ? s.tip_radius == 0 || (s.tip_radius >= least && s.tip_radius <= s.plunger_radius - least)
            : s.tip_radius == 0,
       "tip_radius", s.tip_radius,
       cone ? "0, or 0.05 .. " + millimetres(s.plunger_radius - least) : to_conical);
  need(step ? s.step_clearance >= least : s.step_clearance == 0, "step_clearance", s.step_clearance,
       step ? std::string("0.05 and above") : to_stepped);
  need(step ? s.step_radius >= least && s.step_radius + s.step_clearance <= s.plunger_radius - least
            : s.step_radius == 0,
       "step_radius", s.step_radius,
       step ? "0.05 .. " + millimetres(s.plunger_radius - least - s.step_clearance) : to_stepped);
  need(step ? s.step_depth >= least : s.step_depth == 0, "step_depth", s.step_depth,
       step ? std::string("0.05 and above") : to_stepped);
  const double magnet = s.magnet_length, apart = std::fabs(magnet - s.coil_clearance);
  need(magnet == 0 || (magnet >= least && (apart == 0 || apart >= least) &&
                       magnet <= s.stop_length - s.face_depth() - face_clearance),
       "magnet_length", magnet,
       "0, or 0.05 up to 1 below the stop's face, and equal to coil_clearance_mm or 0.05 apart");
  const double room = s.stop_length - s.coil_clearance - face_clearance;
  need(s.face_depth() <= room, cone ? "cone_depth" : "step_depth", s.face_depth(),
       "up to " + millimetres(room));
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
    need(value >= before + least && value <= longest, key, value, millimetres(before + least) + " .. 500");
    before = value;
  }
  for (const auto& [key, value] :
       {Length{"plunger_length", s.plunger_length}, Length{"plate", s.plate}, Length{"flange", s.flange},
        Length{"coil_clearance", s.coil_clearance}, Length{"window", s.window}})
    need(value >= least && value <= longest, key, value, "0.05 .. 500");
  need(s.stop_length > s.coil_clearance + least && s.stop_length < s.window, "stop_length", s.stop_length,
       millimetres(s.coil_clearance + least) + " .. " + millimetres(s.window));
  need(largest_gap >= 0.1e-3 && largest_gap <= coil_top(s) - gap_clearance, "gap", largest_gap,
       "0.1 .. " + millimetres(coil_top(s) - gap_clearance));
  need(s.plunger_length >= flange_bottom(s) + s.flange + gap_clearance - 1e-12, "plunger_length",
       s.plunger_length, millimetres(flange_bottom(s) + s.flange + gap_clearance) + " and above");
  check_face(s);
}

double SolenoidShape::face_depth() const {
  if (face == PlungerFace::conical) return (plunger_radius - tip_radius) * std::tan(cone_angle);
  return face == PlungerFace::stepped ? step_depth : 0;
}

SolenoidGrid::SolenoidGrid(const SolenoidShape& shape, const CoreMeshSizes& sizes, double largest_gap)
    : shape_(shape), reference_(largest_gap) {
  check_solenoid(shape, largest_gap);
  far_ = 4 * (shape.plunger_length + largest_gap);
  mesh_ = tensor_mesh(radii(shape, sizes), levels(shape, sizes, reference_, far_),
                      [&](double r, double z) { return region_of(shape, r, z, reference_); }, {});
  meshed_ = mesh_.y;
  mesh_.y = heights(reference_);
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

SolenoidGrid::Levels SolenoidGrid::levels_at(double r, double gap) const {
  const double depth = shape_.step_depth, low = lower_seam(shape_, gap), high = upper_seam(shape_, gap),
               s = std::clamp((r - shape_.step_radius) / shape_.step_clearance, 0., 1.);
  Levels l;
  l.meshed = {-depth, 0, upper_seam(shape_, reference_), reference_};
  const std::array<double, 4> pin{-depth, low, gap - depth, gap}, rim{-depth, 0, high, gap},
      pin_weight{0, (low + depth) / gap, 1, 1}, rim_weight{0, 0, high / gap, 1};
  for (std::size_t k = 0; k < 4; ++k) {
    l.at[k] = pin[k] + s * (rim[k] - pin[k]);
    l.weight[k] = pin_weight[k] + s * (rim_weight[k] - pin_weight[k]);
  }
  return l;
}

double SolenoidGrid::height(double r, double z, double gap) const {
  const double top = coil_top(shape_);
  double at = moved(z, gap);
  // what stands still beside the plunger keeps its vertices
  if (z > 0 && z < top)
    at = z + (at - z) * std::clamp((shape_.coil_outer - r) / (shape_.coil_outer - shape_.coil_inner), 0., 1.);
  if (r >= shape_.plunger_radius) return at;
  if (shape_.face == PlungerFace::stepped && z > -shape_.step_depth && z < reference_) {
    const Levels l = levels_at(r, gap);
    const std::size_t k = z < l.meshed[1] ? 0 : z < l.meshed[2] ? 1 : 2;
    return l.at[k] + (z - l.meshed[k]) / (l.meshed[k + 1] - l.meshed[k]) * (l.at[k + 1] - l.at[k]);
  }
  if (shape_.face != PlungerFace::conical) return at;
  // the face and the gap go down along the cone; iron above and below takes it up, each linearly
  const double down = (shape_.plunger_radius - std::max(r, shape_.tip_radius)) * std::tan(shape_.cone_angle);
  const double floor = std::max(shape_.coil_clearance, shape_.magnet_length) - shape_.stop_length;
  const double share = at <= 0     ? std::clamp(1 - at / floor, 0., 1.)
                       : at <= gap ? 1.
                                   : std::clamp((top - at) / (top - gap), 0., 1.);
  return at - down * share;
}

std::vector<double> SolenoidGrid::heights(double gap) const {
  std::vector<double> z(meshed_);
  for (std::size_t k = 0; k < z.size(); ++k) z[k] = height(mesh_.x[k], z[k], gap);
  return z;
}

std::vector<double> SolenoidGrid::motion(double gap) const {
  std::vector<double> weight;
  const double end = gap + shape_.plunger_length;
  for (std::size_t k = 0; k < meshed_.size(); ++k) {
    const double r = mesh_.x[k], meshed = meshed_[k], z = moved(meshed, gap);
    const double across =
        std::clamp((shape_.bore_radius - r) / (shape_.bore_radius - shape_.plunger_radius), 0., 1.);
    double below = std::clamp(z / gap, 0., 1.);
    if (shape_.face == PlungerFace::stepped && r < shape_.plunger_radius && meshed < reference_) {
      const Levels l = levels_at(r, gap);
      const std::size_t i = meshed < l.meshed[1] ? 0 : meshed < l.meshed[2] ? 1 : 2;
      const double share = std::clamp((meshed - l.meshed[i]) / (l.meshed[i + 1] - l.meshed[i]), 0., 1.);
      below = l.weight[i] + share * (l.weight[i + 1] - l.weight[i]);
    }
    const double above = std::clamp(1 - (z - end) / reference_, 0., 1.);
    weight.push_back(across * below * above);
  }
  return weight;
}

}  // namespace powbench::sim
