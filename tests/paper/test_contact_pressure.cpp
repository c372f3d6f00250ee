// The statements on contact pressure: trains of pulses, pulsation, and what the extraction makes of them.

#include <algorithm>
#include <catch2/catch.hpp>
#include <cmath>
#include <nlohmann/json.hpp>

#include "core/quantities.h"
#include "core/units.h"
#include "dsp/events/extract.h"
#include "host/config/specimen_file.h"
#include "host/paper/contact_pressure.h"
#include "rigs/simulated_record.h"
#include "tests/places.h"

using namespace powbench;
using namespace powbench::host;

namespace {

std::string scene(const std::string& name) {
  return test::source_dir() + "/scenes/" + name;
}
sim::Specimen level() {
  return read_specimen(scene("contact-pressure.specimen.toml"));
}
sim::Specimen tilted() {
  return read_specimen(scene("contact-pressure-tilted.specimen.toml"));
}

}  // namespace

TEST_CASE("pulses of a made-up force: begins, peaks, and a pulsation that is no bounce", "[paper]") {
  std::vector<sim::PlantSample> samples;
  for (int k = 0; k <= 100'000; ++k) {
    sim::PlantSample s;
    s.time = k * 1e-6;
    const double ms = s.time * 1e3;
    const auto pulse = [&](double from, double to, double peak) {
      return ms > from && ms < to ? peak * std::sin(pi * (ms - from) / (to - from)) : 0.0;
    };
    s.force_a =
        pulse(10, 11, 10) + pulse(11.5, 12.5, 5) + (ms > 13 ? 3 + 0.5 * std::cos(4 * pi * 50 * s.time) : 0);
    samples.push_back(s);
  }
  const auto t = pressure_train(samples, false, 50);
  REQUIRE(t.bounces() == 2);
  CHECK(t.peak(0) == Approx(10).epsilon(1e-4));
  CHECK(t.peak(1) == Approx(5).epsilon(1e-4));
  CHECK(t.interval(0) == Approx(1.5e-3).epsilon(1e-3));
  CHECK(std::isnan(t.interval(2)));
  CHECK(t.settled == Approx(13e-3).epsilon(1e-3));
  CHECK(t.mean == Approx(3).epsilon(1e-3));
  CHECK(t.swing == Approx(1).epsilon(1e-3));
  CHECK(t.second == Approx(0.5).epsilon(1e-3));
  CHECK(pressure_train(samples, true, 50).pulses.empty());
}

TEST_CASE("printed simulation: two bounces, 1.5 ms apart, 10 N then 5 N, from soft pads", "[paper]") {
  const auto t = pressure_train(pressure_closing(level(), 112).samples, false, 50);
  REQUIRE(t.bounces() == 2);
  CHECK(t.peak(0) == Approx(10).epsilon(0.05));
  CHECK(t.peak(1) == Approx(5).epsilon(0.05));
  CHECK(t.pulses[1].peak_time - t.pulses[0].peak_time == Approx(1.5e-3).epsilon(0.05));
  // metal on metal is a hundred times as stiff, and strikes much harder
  auto hard = level();
  hard.bridges.contact_stiffness *= 100;
  CHECK(pressure_train(pressure_closing(hard, 112).samples, false, 50).peak(0) > 50);
}

TEST_CASE(
    "printed measurement: three bounces of F2, 1.0 then 0.5 ms apart, F1 above F2, from a tilting bridge",
    "[paper]") {
  const auto r = pressure_closing(tilted(), 180);
  const auto a = pressure_train(r.samples, false, 50), b = pressure_train(r.samples, true, 50);
  REQUIRE(b.bounces() == 3);
  CHECK(b.interval(0) == Approx(1.0e-3).epsilon(0.05));
  CHECK(b.interval(1) == Approx(0.5e-3).epsilon(0.05));
  CHECK(a.largest() > b.largest());
  // without the tilt both breaks are one
  auto straight = tilted();
  straight.bridges.tilt_gap = 0;
  const auto s = pressure_closing(straight, 180);
  CHECK(pressure_train(s.samples, false, 50).peak(0) == Approx(pressure_train(s.samples, true, 50).peak(0)));
}

TEST_CASE("through sensors and extraction the pulsation is no bounce either", "[paper]") {
  for (const double angle : {0.0, 70.0}) {
    Conditions c;
    c.supply_volts = 220;
    c.ambient = zero_celsius + 17;
    c.closing_angle = radians(angle);
    const auto closing = rigs::simulate_record(tilted(), c, {});
    const Events e = dsp::extract_events(closing.record, {});
    CAPTURE(angle);
    REQUIRE(closing.truth.settled);
    REQUIRE(e.contact_voltage.settled.known());
    CHECK(e.contact_voltage.settled.value == Approx(*closing.truth.settled).margin(0.1e-3));
    CHECK(e.pvdf_a.settled.value < *closing.truth.settled + 2e-3);
  }
}

TEST_CASE("the largest force that is extracted is one that the contacts press with", "[paper]") {
  for (const double angle : {0.0, 30.0, 70.0, 90.0, 220.0, 270.0}) {
    double largest = 0;
    for (const auto& p : pressure_closing(tilted(), angle).samples)
      largest = std::max({largest, p.force_a, p.force_b});
    Conditions c;
    c.supply_volts = 220;
    c.ambient = zero_celsius + 17;
    c.closing_angle = radians(angle);
    const auto closing = rigs::simulate_record(tilted(), c, {});
    const Measured peak = find_quantity("F_peak")->of(dsp::extract_events(closing.record, {}));
    CAPTURE(angle);
    REQUIRE(peak.known());
    // crosstalk and core vibration are on the film, hence not less than it: 10 %
    CHECK(peak.value == Approx(largest).epsilon(0.1));
  }
}

TEST_CASE("no contact on soft pads is taken for vibration, whatever the angle", "[paper]") {
  for (const double angle : {-0.02, 0.0, 0.01, 0.05, 1.0}) {
    Conditions c;
    c.supply_volts = 220;
    c.ambient = zero_celsius + 17;
    c.closing_angle = radians(angle);
    const auto e = dsp::extract_events(rigs::simulate_record(tilted(), c, {}).record, {});
    const auto truth = pressure_closing(tilted(), angle).samples;
    for (const bool a : {true, false}) {
      const auto& contacts = (a ? e.pvdf_a : e.pvdf_b).contacts;
      for (std::size_t i = 0; i < truth.size();) {
        const auto force = [&](std::size_t k) { return a ? truth[k].force_a : truth[k].force_b; };
        std::size_t end = i;
        while (end < truth.size() && force(end) > 0) ++end;
        if (end == i) {
          ++i;
          continue;
        }
        const double touch = truth[i].time, release = truth[end - 1].time;
        CAPTURE(angle, a, touch, release);
        if (release - touch > 0.2e-3)
          CHECK(std::any_of(contacts.begin(), contacts.end(), [&](const Contact& k) {
            return k.touch.value < release && !(k.release.value < touch);
          }));
        i = end;
      }
    }
  }
}

TEST_CASE("the page of the contact pressure holds what the statements name", "[paper]") {
  const PressurePage page{level(), tilted(), 112, 180};
  const std::string text = pressure_text(page);
  for (const char* word : {"bounces of F2", "at 100 Hz", "impulse", "112 deg"})
    CHECK(text.find(word) != std::string::npos);
  CHECK(text.find("nan") == std::string::npos);
  const auto j = nlohmann::json::parse(pressure_json(page));
  CHECK(j["simulation"].size() == 4);
  CHECK(j["measurement"][0]["published"] == 3);
  CHECK(j["angles"].size() == 10);
  // seated, the pull's pulsation is inside the magnet: what reaches a break is its share of the overtravel spring's,
  // and the softer the pole faces the more of it
  const auto& held = j["held"];
  REQUIRE(held.size() == 5);
  CHECK(held[0]["core_lifts"] == 0);
  for (int k = 0; k < 3; ++k)
    CHECK(held[k]["at_100_Hz_N"].get<double>() ==
          Approx(held[k]["by_overtravel_spring_N"].get<double>()).epsilon(0.15));
  CHECK(held[2]["at_100_Hz_N"].get<double>() > 2 * held[0]["at_100_Hz_N"].get<double>());
  CHECK(held[4]["core_lifts"].get<int>() > 10);  // a weak ring does not hold: that is chatter, no pulsation
}
