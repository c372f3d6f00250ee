#include <algorithm>
#include <catch2/catch.hpp>
#include <cmath>

#include "bench/dsp_methods.h"
#include "bench/dsp_metrics.h"
#include "bench/dsp_synth.h"
#include "core/units.h"
#include "dsp/extract.h"
#include "dsp/force.h"
#include "dsp/joint_columns.h"
#include "dsp/joint_fit.h"

using namespace powbench;
using namespace powbench::dsp;

namespace {

/// Half sine from 1.0 to 2.0 ms, ring from 1.4 ms, settled from 2.6 ms; 200 kS/s.
Signal scene(double noise) {
  bench::Random random(5);
  Signal s;
  s.dt = 5e-6;
  for (int i = 0; i < 3000; ++i) {
    const double t = i * s.dt, u = t - 1.4e-3, v = t - 2.6e-3;
    double x = noise * random.normal();
    if (t > 1e-3 && t < 2e-3) x += 10 * std::sin(pi * (t - 1e-3) / 1e-3);
    if (u >= 0) x += 2 * std::exp(-280 * u) * std::cos(2 * pi * 3000 * u + 0.4);
    if (v > 0) x += 4 * (1 - std::exp(-v / 2e-4));
    s.value.push_back(x);
  }
  s.masked.assign(s.value.size(), mask_none);
  return s;
}

JointModel rough_start() {
  JointModel m;
  JointPulse p;
  p.shape = {1.03e-3, 1.96e-3, 9.0, 1.2, 1.0};
  m.pulses.push_back(p);
  m.rise = JointRise{.touch = 2.63e-3, .rise = 1e-4, .modelled = true, .linear = {4.0}};
  m.ring.onset = m.ring.reference = 1.7e-3;
  m.ring.modes.push_back({{3010.0, 250.0}, 1.2, -0.5});
  return m;
}

}  // namespace

TEST_CASE(
    "joint fit: contacts, ring and its onset from a rough start, uncertainties as large as the errors") {
  const Signal s = scene(0.05);
  const ExtractOptions o;
  const JointInput in{s, 0.05, 0.015, 0.5e-3, 2.8e-3, o};
  const JointModel m = fit_joint(in, rough_start(), 20);
  REQUIRE(m.pulses.size() == 1);
  CHECK(m.reduced() == Approx(1.0).margin(0.2));
  CHECK(m.ring.onset == Approx(1.4e-3).margin(6e-6));
  CHECK(m.ring.modes[0].pole.hertz == Approx(3000).margin(3));
  CHECK(m.ring.modes[0].pole.decay == Approx(280).epsilon(0.05));
  CHECK(std::abs(m.pulses[0].shape.touch - 1e-3) < 4 * m.pulses[0].u_touch);
  CHECK(std::abs(m.pulses[0].shape.release - 2e-3) < 4 * m.pulses[0].u_release);
  CHECK(std::abs(m.rise->touch - 2.6e-3) < 4 * m.rise->u_touch);
  CHECK(m.pulses[0].u_touch < 3e-6);
}

TEST_CASE("joint fit: derivatives are those of the model") {
  const Signal s = scene(0.05);
  const ExtractOptions o;
  const JointInput in{s, 0.05, 0.015, 0.5e-3, 2.8e-3, o};
  JointModel m = rough_start();
  m.rise->linear.assign(settled_terms(true), 0.0);
  m.rise->linear.front() = 4.0;
  JointRows r = joint_rows(in, m);
  weigh_rows(in, m, r);
  JointSystem at, up;
  evaluate(in, m, r, at, true);
  // Away from the kinks, where the model has a derivative in every parameter.
  const std::vector<double> sizes{1e-8, 1e-8, 1e-5, 1e-4, 1e-8, 1e-5};
  for (std::size_t c = 0; c < at.columns; ++c) {
    std::vector<double> step(at.columns, 0.0);
    step[c] = c < sizes.size() ? sizes[c] : 1e-4;
    evaluate(in, moved(m, at, step.data(), o), r, up, false);
    double worst = 0, largest = 1e-12;
    for (std::size_t i = 0; i < r.size(); ++i) {
      const double t = r.t[i];
      if (std::abs(t - 1.03e-3) < 1e-4 || std::abs(t - 1.96e-3) < 1e-4 || std::abs(t - 2.63e-3) < 2e-5)
        continue;
      const double exact = at.jacobian[c * r.size() + i];
      worst = std::max(worst, std::abs((up.residual[i] - at.residual[i]) / step[c] - exact));
      largest = std::max(largest, std::abs(exact));
    }
    INFO("column " << c);
    CHECK(worst < 0.02 * largest);
  }
}

TEST_CASE("a spurious oscillation is not taken for vibration on clean records of little noise") {
  bench::SynthSettings s;
  s.snr_db = 60;
  int rings = 0;
  for (std::uint64_t k = 300; k < 308; ++k) {
    const auto r = bench::synthesise(s, k);
    const auto found = bench::methods().back().contacts(r.record);
    CHECK(found.size() == r.contacts.size());
    for (std::size_t i = 0; i + 1 < std::min(found.size(), r.contacts.size()); ++i)
      rings += std::abs(found[i].touch.value - r.contacts[i].touch) > 1e-6;
  }
  CHECK(rings == 0);
}

TEST_CASE("score: ringing from before the first touch, records nobody tuned for") {
  bench::SynthSettings s;
  s.force_case = bench::ForceCase::ring_overlap;
  bench::Scorer scorer;
  for (std::uint64_t k = 50000; k < 50012; ++k) {
    const auto r = bench::synthesise(s, k);
    scorer.add(r.contacts, bench::methods().back().contacts(r.record));
  }
  const bench::Score score = scorer.score();
  CHECK(score.exact >= 0.9);
  CHECK(score.touch_rmse < 10e-6);
}
