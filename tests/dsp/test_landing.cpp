#include "dsp/contacts/landing.h"

#include <catch2/catch.hpp>
#include <cmath>
#include <limits>

#include "dsp/contacts/contact_train.h"

using namespace powbench;
using namespace powbench::dsp;

namespace {

constexpr double never = std::numeric_limits<double>::infinity();
constexpr Measured seat{10e-3, 2e-6};

Contact contact(double touch, double release, double peak) {
  Contact c;
  c.touch = {touch, 1e-6};
  c.release = {release, 1e-6};
  c.peak = {peak, 0.1};
  return c;
}

}  // namespace

TEST_CASE("landing: a contact no larger than the ring goes, a larger one stays and is doubted") {
  std::vector<Contact> c{contact(8e-3, 9e-3, 0.5), contact(10.1e-3, 10.2e-3, 0.9),
                         contact(10.22e-3, 11e-3, 5)};
  const std::vector<Interval> unaided{{8e-3, 9e-3}, {10.1e-3, 11e-3}};
  CHECK(doubt_landing(c, unaided, seat, 1.3));
  REQUIRE(c.size() == 2);
  CHECK(c[0].flags == flag_none);  // before the landing a small contact is a contact
  CHECK(c[0].touch.u == 1e-6);
  CHECK((c[1].flags & flag_ring_overlap) != 0);
  CHECK(c[1].touch.value == 10.22e-3);
  // between 10.10 and 10.22 ms: the standard deviation of a uniform density
  CHECK(c[1].touch.u == Approx(std::hypot(1e-6, 0.12e-3 / std::sqrt(12.0))));
  CHECK(c[1].release.u == 1e-6);
}

TEST_CASE("landing: an edge that only the stripped force shows may lie anywhere in the landing") {
  std::vector<Contact> c{contact(8e-3, 10.05e-3, 4)};
  CHECK(doubt_landing(c, {{3e-3, 4e-3}}, seat, 1.0));
  CHECK(c[0].release.u == Approx(std::hypot(1e-6, landing_time / std::sqrt(12.0))));
}

TEST_CASE("landing: a vibration that can hide little of an edge moves it by no more") {
  // seen 120 us apart, but the force rises above the vibration within 15 us; the release is seen once only
  std::vector<Contact> c{contact(8e-3, 10.02e-3, 4), contact(10.22e-3, 11e-3, 5)};
  const auto hidden = [](double, int side) { return side > 0 ? 15e-6 : 10e-6; };
  CHECK(doubt_landing(c, {{10.1e-3, 11e-3}}, seat, 1.3, hidden));
  CHECK(c[1].touch.u == Approx(std::hypot(1e-6, 15e-6 / std::sqrt(12.0))));
  CHECK((c[1].flags & flag_ring_overlap) == 0);
  CHECK(c[0].release.u == Approx(std::hypot(1e-6, landing_time / std::sqrt(12.0))));
}

TEST_CASE("landing: nothing is doubted without a seat, without a ring, or away from the seat") {
  std::vector<Contact> c{contact(8e-3, 9e-3, 4), contact(10.5e-3, never, 4)};
  CHECK_FALSE(doubt_landing(c, {}, {}, 1.0));
  CHECK_FALSE(doubt_landing(c, {}, seat, 0.0));
  CHECK_FALSE(doubt_landing(c, {}, seat, 1.0));
  CHECK(c[0].flags == flag_none);
}

TEST_CASE("a sudden force behind an amplifier of known delay is dated to a tenth of that delay") {
  // A step of 5 N at 200 kS/s through a maximally flat low-pass of second order, delay D = 7.5 us taken out of the
  // axis: with s = (t - t0) / D + 1 it shows as 1 - exp(-s) (cos s + sin s), from D before the step on.
  constexpr double delay = 7.5e-6, at = 10.002e-3;
  Force f;
  f.present = true;
  f.noise = 0.02;
  f.settled = 5;
  f.delay = delay;
  f.signal.dt = 5e-6;
  f.signal.t0 = -20e-3;
  f.signal.value.resize(8000);
  f.signal.masked.assign(8000, mask_none);
  for (std::size_t i = 0; i < 8000; ++i) {
    const double s = (f.signal.time(i) - at) / delay + 1;
    f.signal.value[i] =
        (s > 0 ? 5 * (1 - std::exp(-s) * (std::cos(s) + std::sin(s))) : 0.0) + (i % 2 ? 0.02 : -0.02);
  }
  const auto train = analyse_force(f, 20e-3, {}, {}).train;
  REQUIRE(train.contacts.size() == 1);
  const Measured touch = train.contacts[0].touch;
  CHECK(std::abs(touch.value - at) < 2 * touch.u);
  CHECK(touch.u >= 0.1 * delay);
  CHECK(touch.u < 0.2 * delay);
}
