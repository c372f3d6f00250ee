#include "dsp/contacts/joint_pulse.h"

#include <algorithm>
#include <cmath>

#include "core/units.h"

namespace powbench::dsp {

namespace {

/// The bends on top of the symmetric or skewed pulse at v = (t - touch) / width.
void bend(PulseValue& p, const JointPulse& f, double v) {
  const double width = f.shape.release - f.shape.touch;
  double factor = 1, slope = 0;
  for (std::size_t j = 0; j < joint_bends; ++j) {
    const double a = pi * static_cast<double>(j + 1);
    factor += f.bend[j] * std::cos(a * v);
    slope -= f.bend[j] * a * std::sin(a * v);
    p.bend[j] = p.force * std::cos(a * v);
  }
  const double by_v = p.force * slope;
  p.force *= factor, p.exponent *= factor, p.log_skew *= factor, p.unit *= factor;
  p.touch = p.touch * factor + by_v * (v - 1) / width;
  p.release = p.release * factor - by_v * v / width;
}

}  // namespace

void PulseValue::add(const PulseValue& o, double share) {
  force += share * o.force, touch += share * o.touch, release += share * o.release;
  exponent += share * o.exponent, log_skew += share * o.log_skew, unit += share * o.unit;
  for (std::size_t j = 0; j < joint_bends; ++j) bend[j] += share * o.bend[j];
}

double bend_sigma(std::size_t j) {
  return 0.1 / std::pow(static_cast<double>(j + 1), 1.5);
}

PulseValue pulse_value(const JointPulse& pulse, double t) {
  const PulseShape& f = pulse.shape;
  const bool skewed = pulse.skewed;
  const double width = f.release - f.touch, v = (t - f.touch) / width;
  if (!(v > 0) || !(v < 1)) return {};
  const double w = skewed ? std::pow(v, f.skew) : v;
  const double base = std::max(std::sin(pi * w), 1e-4), logarithm = std::log(base);
  const double power = std::exp(f.exponent * logarithm);
  const double slope = f.peak * f.exponent * power / std::max(base, 1e-3) * pi * std::cos(pi * w);
  const double by_v = skewed ? slope * f.skew * w / v : slope;
  PulseValue p;
  p.unit = power;
  p.force = f.peak * power;
  p.touch = by_v * (v - 1) / width;
  p.release = -by_v * v / width;
  p.exponent = p.force * logarithm;
  if (skewed) p.log_skew = slope * w * std::log(v) * f.skew;
  if (pulse.bent) bend(p, pulse, v);
  return p;
}

PulseValue pulse_row(const JointPulse& f, const JointRows& r, std::size_t i) {
  const double t = r.t[i];
  const bool kink = std::abs(t - f.shape.touch) < 1.5 * r.dt || std::abs(t - f.shape.release) < 1.5 * r.dt;
  if (!kink || r.block == 1) return pulse_value(f, t);
  PulseValue sum;
  const auto m = static_cast<double>(r.block);
  for (std::size_t k = 0; k < r.block; ++k)
    sum.add(pulse_value(f, t + (static_cast<double>(k) - 0.5 * (m - 1)) * r.sample), 1 / m);
  return sum;
}

std::size_t free_numbers(const JointPulse& p) {
  return 4 + (p.skewed ? 1U : 0U) + (p.bent ? joint_bends : 0U);
}

}  // namespace powbench::dsp
