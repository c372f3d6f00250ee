#include "bench/study/synthetic_device.h"

#include <algorithm>
#include <cmath>
#include <limits>
#include <stdexcept>

#include "core/units.h"
#include "sim/models/closing.h"
#include "sim/models/rigid_closing.h"
#include "sim/specimen/validate.h"
#include "sim/study/misfit.h"
#include "sim/study/parameter.h"

namespace powbench::bench {
namespace {

constexpr double nan = std::numeric_limits<double>::quiet_NaN();
constexpr double rated_volts = 230;
constexpr double window = 60e-3;  // s that a measured closing is watched
constexpr double sampling = 30e-6;
constexpr double tolerance = 1e-6;

/// Numbers that a specimen file can ask for and the fit does not know, in the unit of their keys.
std::vector<sim::Parameter> unknown_to_the_fit() {
  using sim::parameter;
  return {parameter("bridges.contact_depth_um", 4, 20, true),
          parameter("bridges.contact_speed_m_per_s", 0.3, 1),
          parameter("core.stop_depth_um", 4, 20, true),
          parameter("core.stop_speed_m_per_s", 0.5, 2),
          parameter("core.tilt_inertia_g_mm2", 1e4, 1e5, true),
          parameter("core.tilt_mode_Hz", 150, 600, true),
          parameter("bridges.pitch_mm", 0, 15),
          parameter("base.core_mass_g", 80, 320),
          parameter("base.core_mode_Hz", 60, 800, true),
          parameter("base.core_damping", 0.02, 0.6),
          parameter("base.flex_mode_Hz", 500, 1500, true),
          parameter("base.flex_mass_g", 80, 300),
          parameter("bridges.tilt_gap_mm", -0.1, 0.1),
          parameter("bridges.gap_spread_mm", -0.05, 0.05),
          parameter("magnet.bh_exponent", 8, 14),
          parameter("magnet.coercive_field_A_per_m", 10, 100)};
}

std::vector<double> place_in(Random& random, std::size_t dimension) {
  std::vector<double> place(dimension);
  for (double& x : place) x = random.uniform();
  return place;
}

bool within(double value, const sim::PlausibleRange& r) {
  return value >= r.low && value <= r.high;
}

bool of_its_kind(const sim::Specimen& s) {
  const auto p = sim::catalogue_ranges();
  const auto d = sim::derived(s, rated_volts);
  return within(d.inrush, *p.inrush) && within(d.holding, *p.holding) &&
         within(d.overtravel, *p.overtravel) && within(d.contact_force, *p.contact_force) &&
         within(d.base_travel, *p.base_travel);
}

bool works(const Device& device) {
  constexpr double latest = 26e-3, shortest = 2e-3, longest = 12e-3;
  for (const double degrees : {0.0, 60.0, 120.0})
    if (!closing(device, radians(degrees), 0.85 * rated_volts, window, tolerance, false).closed) return false;
  std::vector<double> bounces;
  for (int k = 0; k < 12; ++k) {
    const Shot s = closing(device, radians(15.0 * k), rated_volts, window, tolerance, false);
    if (!s.closed || s.touch + s.bounce > latest) return false;
    bounces.push_back(s.bounce);
  }
  const double typical = median_of(bounces);
  return typical >= shortest && typical <= longest;
}

sim::Trajectory run(const Device& device, const Conditions& c, double duration, double tol, double dt) {
  if (device.model == Model::other) return sim::simulate_rigid(device.specimen, c, duration, dt, tol, false);
  return sim::simulate(device.specimen, c, duration, dt, tol);
}

}  // namespace

double median_of(std::vector<double> list) {
  if (list.empty()) return nan;
  std::sort(list.begin(), list.end());
  const std::size_t half = list.size() / 2;
  return list.size() % 2 ? list[half] : 0.5 * (list[half - 1] + list[half]);
}

Shot closing(const Device& device, double angle, double volts, double duration, double tol, bool force) {
  Shot shot{angle, nan, nan, nan, nan, nan, nan, nan, false};
  if (!sim::validate(device.specimen).empty()) return shot;
  Conditions c;
  c.closing_angle = angle;
  c.supply_volts = volts;
  try {
    const auto run_of = run(device, c, duration, tol, force ? sampling : 0);
    const auto& t = run_of.truth;
    if (!t.touch || !t.core_seat) return shot;
    shot.touch = *t.touch;
    shot.bounce = *t.settled - *t.touch;
    shot.seat = *t.core_seat;
    shot.core_settled = *t.core_settled;
    shot.touch_speed = t.touch_velocity;
    shot.seat_speed = t.seat_velocity;
    shot.closed = true;
    if (!force) return shot;
    constexpr double first = 0.5e-3;  // s
    shot.force_peak = 0;
    for (const auto& s : run_of.samples)
      if (s.time >= shot.touch - sampling && s.time <= shot.touch + first)
        shot.force_peak = std::max(shot.force_peak, s.force_a + s.force_b);
  } catch (const std::runtime_error&) {  // a step became too small: it does not close
    shot.closed = false;
  }
  return shot;
}

Device drawn_device(Random& random, Model model, long& tried) {
  const auto known = sim::catalogue_parameters();
  const auto unknown = unknown_to_the_fit();
  for (;;) {
    ++tried;
    Device device{sim::specimen_at({}, known, place_in(random, known.size())), model};
    const auto place = place_in(random, unknown.size());
    if (model == Model::other) {
      auto& s = device.specimen;
      s = sim::specimen_at(s, unknown, place);
      s.bridges.contact_exponent = s.core.stop_exponent = 1.5;
      s.base.flex_modes = 2;
    }
    if (!sim::validate(device.specimen).empty() || !of_its_kind(device.specimen)) continue;
    if (works(device)) return device;
  }
}

Shot measured(const Device& device, double angle, Random& random) {
  constexpr double of_mains = 0.01, of_speed = 0.02, of_force = 0.05, reading = 0.05e-3;
  const auto about = [&](double half) { return half * (2 * random.uniform() - 1); };
  const double at = angle + radians(about(1));
  const double volts = rated_volts * (1 + about(of_mains));
  Shot s = closing(device, at, volts, window, tolerance, true);
  s.angle = angle;
  for (double* time : {&s.touch, &s.seat, &s.core_settled}) *time += reading * random.normal();
  s.bounce = std::max(s.bounce + reading * random.normal(), 0.0);
  for (double* speed : {&s.touch_speed, &s.seat_speed}) *speed *= std::exp(of_speed * random.normal());
  s.force_peak *= std::exp(of_force * random.normal());
  return s;
}

Shot median_shot(const std::vector<Shot>& repeats) {
  Shot m = repeats.front();
  for (double Shot::*q : {&Shot::touch, &Shot::bounce, &Shot::seat, &Shot::core_settled, &Shot::touch_speed,
                          &Shot::seat_speed, &Shot::force_peak}) {
    std::vector<double> list;
    for (const auto& s : repeats) list.push_back(s.*q);
    m.*q = median_of(list);
  }
  return m;
}

}  // namespace powbench::bench
