#include "host/serve/touch.h"

#include <cmath>

#include "core/phase.h"
#include "core/quantities.h"
#include "rigs/simulated_record.h"

namespace powbench::host {
namespace {

constexpr int steps = 24;
constexpr double step = 2 * pi / steps;

/// To -pi .. pi.
double signed_angle(double a) {
  return std::remainder(a, 2 * pi);
}

}  // namespace

TouchAim::TouchAim(const Scene& scene, const rigs::SimRigConfig& rig)
    : specimen_(scene.specimen),
      rig_(rig),
      options_(run_options(scene.plan)),
      plan_hash_(scene.plan_hash),
      specimen_hash_(scene.specimen_hash) {
  if (!scene.shots.empty()) conditions_ = scene.shots.front().conditions;
  conditions_.polarity = +1;
  for (int i = 0; i < steps; ++i) times_.push_back(touch_time(i * step));
}

bool TouchAim::fits(const Scene& scene) const {
  return scene.plan_hash == plan_hash_ && scene.specimen_hash == specimen_hash_;
}

double TouchAim::touch_time(double angle) const {
  Conditions c = conditions_;
  c.closing_angle = wrap_turn(angle);
  const Events e = extract_checked(rigs::simulate_record(specimen_, c, rig_).record, options_);
  return find_quantity("t_ct1")->of(e).value;
}

std::optional<TouchAim::Aim> TouchAim::at(double wanted) const {
  const double omega = 2 * pi * conditions_.mains_hertz;
  const auto error = [&](double a, double t) { return signed_angle(a + omega * t - wanted); };
  std::optional<Aim> best;
  for (int i = 0; i < steps; ++i) {
    double a = i * step, b = a + step;
    double ea = error(a, times_[static_cast<std::size_t>(i)]),
           eb = error(b, times_[static_cast<std::size_t>((i + 1) % steps)]);
    // a zero, not the seam of the turn; NaN fails too
    if (!(ea * eb <= 0 && std::fabs(ea - eb) < pi)) continue;
    const double gain = (eb - ea) / step;
    if (best && std::fabs(best->gain) <= std::fabs(gain)) continue;
    double t = 0, middle = a;
    for (int k = 0; k < 4; ++k) {
      middle = ea == eb ? a : a - ea * (b - a) / (eb - ea);
      t = touch_time(middle);
      const double e = error(middle, t);
      if (!std::isfinite(e)) break;
      if (std::fabs(e) < radians(0.05)) break;
      if (e * ea > 0)
        a = middle, ea = e;
      else
        b = middle, eb = e;
    }
    if (std::isfinite(t)) best = Aim{wrap_turn(wanted), wrap_turn(middle), t, gain};
  }
  return best;
}

}  // namespace powbench::host
