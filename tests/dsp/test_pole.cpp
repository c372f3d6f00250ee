#include <catch2/catch.hpp>
#include <cmath>

#include "dsp/contacts/contact_train.h"
#include "dsp/contacts/pole.h"

using namespace powbench;
using namespace powbench::dsp;

namespace {

Contact contact(double touch, double release = std::nan("")) {
  Contact c;
  c.touch = {touch, 1e-6};
  c.release = {release, 1e-6};
  return c;
}

ContactTrain train(std::vector<Contact> contacts) {
  ContactTrain t;
  t.present = true;
  t.contacts = std::move(contacts);
  summarise(t, 0.0);
  return t;
}

}  // namespace

TEST_CASE(
    "a double-break pole conducts only while both breaks are closed: its openings are those of either") {
  const ContactTrain a = train({contact(0.010, 0.011), contact(0.012)});
  const ContactTrain b = train({contact(0.0101, 0.0115), contact(0.0118, 0.013), contact(0.0131)});
  const ContactTrain pole = pole_by_force(a, b, 0.0);
  REQUIRE(pole.present);
  REQUIRE(pole.contacts.size() == 3);
  CHECK(pole.contacts[0].touch.value == 0.0101);
  CHECK(pole.contacts[0].release.value == 0.011);
  CHECK(pole.contacts[1].touch.value == 0.012);
  CHECK(pole.contacts[1].release.value == 0.013);
  CHECK(pole.contacts[2].touch.value == 0.0131);
  CHECK_FALSE(pole.contacts[2].release.known());
  CHECK(pole.bounce_count == 2);
  CHECK(pole.settled.value == 0.0131);
  CHECK(pole.bounce_time.value == Approx(0.003));
  CHECK_FALSE(pole_by_force(a, {}, 0.0).present);
}

TEST_CASE("disagreement of force and voltage: total, longest, and its uncertainty") {
  const ContactTrain force = train({contact(0.010, 0.011), contact(0.012)});
  const ContactTrain same = force;
  const Disagreement none = disagreement(force, same, 0.06);
  CHECK(none.total.value == 0.0);
  CHECK(none.longest.value == 0.0);
  const ContactTrain voltage = train({contact(0.01002, 0.0111), contact(0.012, 0.0125), contact(0.0127)});
  const Disagreement some = disagreement(force, voltage, 0.06);
  CHECK(some.total.value == Approx(20e-6 + 100e-6 + 200e-6));
  CHECK(some.longest.value == Approx(200e-6));
  CHECK(some.total.u > 0);
  CHECK_FALSE(disagreement(force, {}, 0.06).total.known());
}

TEST_CASE("two trains: bounces before the core lands and those that its impact causes") {
  ContactTrain t =
      train({contact(0.0117, 0.0118), contact(0.0120, 0.01475), contact(0.0167, 0.0168), contact(0.0179)});
  split_trains(t, {0.01474, 2e-6});
  CHECK(t.first_train.openings == 1);
  CHECK(t.first_train.from.value == 0.0117);
  CHECK(t.first_train.to.value == 0.0120);
  CHECK(t.second_train.openings == 2);
  CHECK(t.second_train.from.value == 0.01475);
  CHECK(t.second_train.to.value == 0.0179);
  CHECK(t.first_train.openings + t.second_train.openings == t.bounce_count);
  // No seat known: one train.
  split_trains(t, {});
  CHECK(t.first_train.openings == 3);
  CHECK(t.first_train.to.value == 0.0179);
  CHECK(t.second_train.openings == 0);
  CHECK_FALSE(t.second_train.from.known());
  // Bounces only after the impact, and a train that ends open.
  ContactTrain late = train({contact(0.013, 0.0152), contact(0.0155, 0.016)});
  split_trains(late, {0.0150, 2e-6});
  CHECK(late.first_train.openings == 0);
  CHECK(late.second_train.openings == 1);
  CHECK_FALSE(late.second_train.to.known());
  ContactTrain nothing;
  split_trains(nothing, {0.015, 1e-6});
  CHECK(nothing.first_train.openings == 0);
}
