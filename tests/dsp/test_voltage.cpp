#include <catch2/catch.hpp>
#include <cmath>

#include "bench/dsp_synth.h"
#include "dsp/contacts/contact_voltage.h"
#include "dsp/events/extract.h"

using namespace powbench;
using namespace powbench::dsp;

namespace {

/// 6 V open, 0 V closed; `closed(t)`. 100 kS/s, 40 ms before and 60 ms after switch-on.
Record pole(auto&& closed, double noise = 5e-3) {
  bench::Random random(21);
  Record r;
  r.sample_rate = 1e5;
  r.fire_sample = 4000;
  ChannelRecord c;
  c.channel = Channel::contact_a;
  c.scale = 4e-4;
  for (std::size_t i = 0; i < 10000; ++i)
    c.raw.push_back(static_cast<std::int16_t>(
        std::lround(((closed(r.time(i)) ? 0.0 : 6.0) + noise * random.normal()) / c.scale)));
  r.channels.push_back(std::move(c));
  return r;
}

Contact contact(double touch, double release = std::nan("")) {
  Contact c;
  c.touch = {touch, 1e-6};
  c.release = {release, 1e-6};
  return c;
}

ContactTrain train(std::vector<Contact> contacts) {
  ContactTrain t;
  t.present = true;
  t.resolution = 10e-6;
  t.contacts = std::move(contacts);
  return t;
}

}  // namespace

TEST_CASE("contact-voltage: touches and openings down to 10 us") {
  const Record r = pole(
      [](double t) { return (t > 0.010003 && t < 0.0111) || (t > 0.01203 && t < 0.0125) || t > 0.012513; });
  const ContactTrain t = contact_voltage_train(r, {});
  REQUIRE(t.contacts.size() == 3);
  CHECK(t.contacts[0].touch.value == Approx(0.010003).margin(8e-6));
  CHECK(t.contacts[0].release.value == Approx(0.0111).margin(8e-6));
  CHECK(t.contacts[2].touch.value == Approx(0.012513).margin(8e-6));
  CHECK(t.contacts[0].touch.u == Approx(1e-5 / std::sqrt(12.0)).epsilon(0.1));
  CHECK(t.bounce_count == 2);
  CHECK(t.settled.value == t.contacts[2].touch.value);
  CHECK_FALSE(t.contacts[0].peak.known());
  CHECK_FALSE(t.contacts[2].release.known());
  CHECK(t.resolution == Approx(10e-6));
}

TEST_CASE("a pole that is closed from the start or never closes") {
  const ContactTrain closed = contact_voltage_train(pole([](double t) { return t < 0.02 || t > 0.03; }), {});
  REQUIRE(closed.contacts.size() == 2);
  CHECK_FALSE(closed.contacts[0].touch.known());
  CHECK(closed.contacts[0].release.value == Approx(0.02).margin(8e-6));
  CHECK_FALSE(closed.bounce_time.known());
  const ContactTrain never = contact_voltage_train(pole([](double) { return false; }), {});
  CHECK(never.present);
  CHECK(never.contacts.empty());
  CHECK_FALSE(never.settled.known());
  const ContactTrain dead = contact_voltage_train(pole([](double) { return true; }), {});
  CHECK_FALSE(dead.present);
}

TEST_CASE("force and contact-voltage agree or are flagged") {
  const double end = 0.06;
  const auto a = train({contact(0.010, 0.011), contact(0.012)});
  const auto b = train({contact(0.0101, 0.0115), contact(0.0118)});
  {
    ContactTrain v = train({contact(0.0101, 0.011), contact(0.012)}), x = a, y = b;
    CHECK_FALSE(cross_check(v, x, y, end));
    CHECK(v.flags == 0);
  }
  {  // the pole conducts while film A says open
    ContactTrain v = train({contact(0.0101)}), x = a, y = b;
    CHECK(cross_check(v, x, y, end));
    CHECK((x.flags & flag_contradiction) != 0);
    CHECK((v.flags & flag_contradiction) != 0);
  }
  {  // the pole opens while both films say closed
    ContactTrain v = train({contact(0.0101, 0.011), contact(0.012, 0.020), contact(0.021)}), x = a, y = b;
    CHECK(cross_check(v, x, y, end));
  }
  {  // nothing to compare with
    ContactTrain v = train({contact(0.0101)}), x, y;
    CHECK_FALSE(cross_check(v, x, y, end));
  }
}

TEST_CASE("films and pole of a whole synthetic record agree") {
  for (std::uint64_t seed = 0; seed < 5; ++seed) {
    const Events e = extract_events(bench::synthesise_full(1e5, 50, 1.0, seed));
    CHECK((e.flags & flag_contradiction) == 0);
    CHECK(e.pvdf_a.contacts.size() == e.contact_voltage.contacts.size());
  }
}
