#include "bench/events/impact.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <limits>

#include "core/units.h"

namespace powbench::bench {

namespace {

constexpr double step = 1e-7, mass = 5e-3;
constexpr double guide =
    0.12;  ///< friction of the guide over the settled force: ends trains of lossless pads

/// The pad with what it remembers of the contact in hand.
struct PadState {
  const Impact& impact;
  double stiffness = 0, damping = 0;
  double speed = 0;    ///< m/s at the last touch
  double deepest = 0;  ///< m, in this contact
  double surface = 0;  ///< m, where the next contact begins: dents stay

  explicit PadState(const Impact& i) : impact(i) {
    const double w = pi / i.width, v = i.peak / (mass * w);
    const bool curved = i.pad == Pad::hertz || i.pad == Pad::hunt_crossley;
    // a Hertz contact of the same speed and duration: T = 2.943 (depth / v), m v^2 / 2 = 0.4 k depth^2.5
    const double depth = i.width * v / 2.943;
    stiffness = curved ? 0.5 * mass * v * v / (0.4 * std::pow(depth, 2.5)) : mass * w * w;
    damping = 2 * i.loss * std::sqrt(stiffness * mass);
  }

  void begin(double v) { speed = v, deepest = 0; }
  void end() {
    if (impact.pad == Pad::yielding) surface += impact.loss * deepest;
  }

  double force(double d, double rate) const {
    if (d <= 0) return 0;
    switch (impact.pad) {
      case Pad::spring:
        return stiffness * d;
      case Pad::hertz:
        return stiffness * std::pow(d, 1.5);
      case Pad::hunt_crossley:
        return std::max(
            0.0, stiffness * std::pow(d, 1.5) * (1 + 1.5 * impact.loss * rate / std::max(speed, 1e-3)));
      case Pad::damped:
        return std::max(-0.03 * impact.peak, stiffness * d + damping * rate);
      case Pad::yielding:
        break;
    }
    if (d >= deepest) return stiffness * d;
    const double left = impact.loss * deepest;  // back along a steeper line to the dent
    return std::max(0.0, stiffness * deepest * (d - left) / (deepest - left));
  }
};

}  // namespace

std::string_view name(Pad p) {
  constexpr std::array<std::string_view, 5> names{"spring", "Hertz", "Hunt-Crossley", "damped, sticking",
                                                  "yielding"};
  return names[static_cast<std::size_t>(p)];
}

Closing closing_of(const Impact& impact, double seconds, double rate) {
  Closing out;
  PadState pad(impact);
  const double v0 = impact.peak / (mass * pi / impact.width);
  double x = -v0 * impact.first_touch, v = v0;  // m; the pad's surface is at 0, beyond it lies the pad
  bool pressed = false;  // by the spring: from the first touch on, before it comes at constant speed
  bool closed = false;
  const auto acceleration = [&](double at, double speed) {
    if (!pressed) return 0.0;
    const double friction = guide * impact.settled * std::tanh(speed / 5e-3);
    return (impact.settled - friction - (closed ? pad.force(at - pad.surface, speed) : 0.0)) / mass;
  };
  const auto n = static_cast<std::size_t>(std::llround(seconds * rate));
  out.force.assign(n, 0.0);
  double time = 0;
  for (std::size_t sample = 0; sample < n; time += step) {
    const double before = closed ? pad.force(x - pad.surface, v) : 0.0, was = x - pad.surface;
    const double a1 = acceleration(x, v), v1 = v + step * a1;
    const double a2 = acceleration(x + step * v, v1), x1 = x + 0.5 * step * (v + v1);
    v += 0.5 * step * (a1 + a2);
    x = x1;
    const double d = x - pad.surface;
    if (!closed && was <= 0 && d > 0) {
      closed = pressed = true;
      pad.begin(v);
      out.contacts.push_back({time - was / (d - was) * step, std::numeric_limits<double>::infinity(), 0});
    }
    pad.deepest = std::max(pad.deepest, d);
    const double after = closed ? pad.force(d, v) : 0.0;
    if (closed) out.contacts.back().peak = std::max(out.contacts.back().peak, after);
    if (closed && v < 0 && after == 0) {
      closed = false;
      out.contacts.back().release = time + step;
      pad.end();
    }
    for (; sample < n && static_cast<double>(sample) / rate <= time + step; ++sample)
      out.force[sample] = before + (static_cast<double>(sample) / rate - time) / step * (after - before);
  }
  return out;
}

}  // namespace powbench::bench
