#include "bench/mechanics/reference_closing.h"

#include <cmath>

namespace powbench::bench {

sim::RigidParts without_losses(sim::RigidParts p) {
  p.core_damping = p.core_friction = p.tilt_damping = p.buffer_damping = 0;
  for (auto& b : p.bridges) b.damping = 0;
  for (auto& m : p.modes) m.damping = 0;
  for (sim::ContactLaw* law : {&p.pad, &p.seat, &p.pole, &p.stop}) law->form = sim::DampingForm::none;
  return p;
}

sim::RigidParts reference_closing(double stiffness, double damping) {
  sim::RigidParts p;
  p.core_mass = 0.1;
  p.core_inertia = 3e-5;
  p.tilt_rate = p.core_inertia * 3.553e6;
  p.tilt_damping = 2 * 0.05 * p.core_inertia * 1885;
  const auto hertz = [&](double k, double lambda) {
    return sim::ContactLaw{k * stiffness, 1.5, sim::DampingForm::hunt_crossley, lambda * damping, 0};
  };
  p.pad = hertz(1e8, 0.6);
  p.seat = hertz(1e8, 0.6);
  p.pole = hertz(1e9, 1.2);
  p.stop = hertz(1e8, 1.2);
  p.pull = {160, 3e-3, 0.55, 50, 2e-3};
  const double at[5] = {-14e-3, 0, 14e-3, -24e-3, 24e-3};
  const double gap[5] = {3.00e-3, 3.02e-3, 2.98e-3, 2.2e-3, 2.25e-3};
  const double uneven[5] = {30e-6, -22e-6, 14e-6, 40e-6, -18e-6};
  for (int j = 0; j < 5; ++j) {
    const bool main = j < 3;
    sim::RigidBridge b;
    b.mass = main ? 5e-3 : 1.2e-3;
    const double length = main ? 26e-3 : 16e-3;
    b.inertia = b.mass * length * length / 12;
    b.position = at[j];
    b.pad_arm = main ? 10e-3 : 6e-3;
    b.seat_arm = main ? 4e-3 : 3e-3;
    b.preload = main ? 4 : 0.8;
    b.rate = main ? 1200 : 400;
    b.damping = 0.05;
    b.turning_rate = b.rate * 1e-5;
    b.gap[0] = gap[j] - uneven[j];
    b.gap[1] = gap[j] + uneven[j];
    p.bridges.push_back(b);
  }
  const double frequency[4] = {820, 1530, 2900, 4800};
  for (int i = 0; i < 4; ++i) {
    sim::BaseMode m;
    m.hertz = frequency[i];
    for (int pad = 0; pad < 10; ++pad) m.shape[pad / 2][pad % 2] = 0.5 * std::cos(0.7 * (i + 1) * (pad + 1));
    p.modes.push_back(m);
  }
  return p;
}

}  // namespace powbench::bench
