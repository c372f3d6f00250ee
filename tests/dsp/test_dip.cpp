#include <catch2/catch.hpp>
#include <cmath>

#include "bench/dsp_synth.h"
#include "dsp/dip.h"

/// Whether a contact opened in a dip, on indentations whose least value is drawn, with the friction of a guide.

using namespace powbench;
using namespace powbench::dsp;

namespace {

constexpr double middle = 2e-3, noise = 0.03;  // s, N

/// Least indentation `least`, um; the force of `law` is 10 N at 80 um. 200 kS/s.
Signal dip_of(double least, double law, double friction, double zero, bench::Random& r) {
  Signal s;
  s.dt = 5e-6;
  s.value.resize(800);
  s.masked.assign(800, mask_none);
  for (std::size_t i = 0; i < s.size(); ++i) {
    const double t = s.time(i) - middle, side = t < 0 ? -1 : 1;
    const double um = least + 0.5e6 * 800 * (1 + side * friction) * t * t;  // 4 N on 5 g
    s.value[i] = zero + (um > 0 ? 10 * std::pow(um / 80, law) : 0.0) + noise * r.normal();
  }
  return s;
}

}  // namespace

TEST_CASE("dip: an opening and a force that stays are told apart where the noise allows", "[dip]") {
  bench::Random r(4711);
  for (const double law : {1.0, 1.5}) {
    const Dip open =
        look_at_dip(dip_of(-8, law, 0.1, 0.01, r), middle - 140e-6, middle + 140e-6, 1e-3, noise);
    CHECK(open.known);
    CHECK(open.opened > 0.997);
    const Dip closed = look_at_dip(dip_of(8, law, 0.1, 0.01, r), middle - 30e-6, middle + 30e-6, 1e-3, noise);
    CHECK(closed.known);
    CHECK(closed.opened < 0.003);
  }
}

TEST_CASE("dip: of those called open with a probability, that share is open", "[dip]") {
  bench::Random r(4712);
  int known = 0;
  double expected = 0, opened = 0, variance = 0, doubtful = 0;
  constexpr int trials = 240;
  for (int k = 0; k < trials; ++k) {
    const double least = r.uniform(-4, 4), law = r.uniform() < 0.5 ? 1.0 : 1.5;
    const Signal s = dip_of(least, law, r.uniform(-0.12, 0.12), r.uniform(-0.02, 0.02), r);
    const Dip d = look_at_dip(s, middle - 60e-6, middle + 60e-6, 1e-3, noise);
    known += d.known;
    if (!d.known) continue;
    expected += d.opened, opened += least < 0, variance += d.opened * (1 - d.opened);
    doubtful += d.opened > 0.003 && d.opened < 0.997;
  }
  CAPTURE(expected, opened, doubtful);
  CHECK(known > 0.9 * trials);
  CHECK(std::abs(opened - expected) < 3 * std::sqrt(variance) + 1);
  CHECK(doubtful > 0.2 * trials);  // else the noise would decide nothing here
}
