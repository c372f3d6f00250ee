#include "host/import/waveform.h"

#include <fmt/format.h>

#include <algorithm>
#include <catch2/catch.hpp>
#include <cmath>
#include <functional>
#include <nlohmann/json.hpp>

#include "bench/dsp_synth.h"
#include "core/random.h"
#include "dsp/events/extract.h"
#include "host/config/bad_input.h"
#include "host/export/csv.h"
#include "host/export/events_json.h"
#include "rigs/simulated_record.h"

using namespace powbench;
using namespace powbench::host;
using Catch::Contains;

namespace {

constexpr double us = 1e-6;
constexpr const char* today = "2030-06-01";

Imported import_text(const std::string& csv, const std::string& toml = "") {
  return import_waveform(csv, "shot.csv", toml.empty() ? Calibration{} : parse_calibration(toml, "shot.toml"),
                         "shot.toml", today);
}

Events events_of(const std::string& csv, const std::string& toml = "") {
  const Imported in = import_text(csv, toml);
  return dsp::extract_events(in.record, in.options);
}

std::string complaint(const std::string& csv, const std::string& toml = "") {
  try {
    import_text(csv, toml);
    return "";
  } catch (const BadInput& e) {
    return e.what();
  }
}

/// Two bounces (12 ms .. 13.1 ms of 10 N, 14.2 ms .. 14.7 ms of 5 N) and a contact that stays at 4 N from 15.5 ms.
double force(double t) {
  const auto pulse = [t](double a, double b, double peak) {
    return t > a && t < b ? peak * std::sin(pi * (t - a) / (b - a)) : 0.0;
  };
  return pulse(12e-3, 13.1e-3, 10) + pulse(14.2e-3, 14.7e-3, 5) +
         (t > 15.5e-3 ? 4 * (1 - std::exp(-(t - 15.5e-3) / 0.3e-3)) : 0.0);
}

struct Shape {
  double rate = 200e3, from = -0.045, to = 0.05, noise = 0.03;
  std::string title = "time [s],pvdf_a [N]";
  std::function<double(double)> value = force;
};

std::string csv_of(const Shape& s) {
  Random random(9);
  std::string text = s.title + "\n";
  const auto n = static_cast<int>(std::lround((s.to - s.from) * s.rate));
  for (int i = 0; i < n; ++i) {
    const double t = s.from + i / s.rate;
    text += fmt::format("{:.9g},{:.5g}\n", t, s.value(t) + s.noise * random.normal());
  }
  return text;
}

void check_contacts(const ContactTrain& t, double tolerance, double shift = 0) {
  REQUIRE(t.contacts.size() == 3);
  CHECK(std::abs(t.contacts[0].touch.value - 12.0e-3 - shift) < tolerance);
  CHECK(std::abs(t.contacts[0].release.value - 13.1e-3 - shift) < tolerance);
  CHECK(std::abs(t.contacts[1].touch.value - 14.2e-3 - shift) < tolerance);
  CHECK(std::abs(t.contacts[1].release.value - 14.7e-3 - shift) < tolerance);
  CHECK(std::abs(t.contacts[2].touch.value - 15.5e-3 - shift) < tolerance);
  CHECK_FALSE(t.contacts[2].release.known());
  for (const Contact& c : t.contacts) CHECK(c.touch.u > 0);
}

void check_same_train(const ContactTrain& a, const ContactTrain& b) {
  REQUIRE(a.contacts.size() == b.contacts.size());
  for (std::size_t i = 0; i < a.contacts.size(); ++i) {
    CHECK(std::abs(a.contacts[i].touch.value - b.contacts[i].touch.value) < 0.1 * us);
    if (a.contacts[i].release.known())
      CHECK(std::abs(a.contacts[i].release.value - b.contacts[i].release.value) < 0.1 * us);
    CHECK(a.contacts[i].flags == b.contacts[i].flags);
  }
}

}  // namespace

TEST_CASE("a record of the simulated rig comes back from its export with the same events") {
  for (const double angle : {0.0, 60.0, 90.0}) {
    Conditions conditions;
    conditions.closing_angle = radians(angle);
    Record r = rigs::simulate_record(sim::Specimen{}, conditions, rigs::SimRigConfig{}).record;
    r.gaps.push_back({100, 3});
    const Imported in = import_text(to_csv(r), calibration_of(r, ""));
    const Events before = dsp::extract_events(r), after = dsp::extract_events(in.record, in.options);
    INFO(angle);
    CHECK(in.record.sample_rate == r.sample_rate);
    REQUIRE(before.pvdf_a.contacts.size() >= 1);
    check_same_train(before.pvdf_a, after.pvdf_a);
    check_same_train(before.pvdf_b, after.pvdf_b);
    check_same_train(before.contact_voltage, after.contact_voltage);
    CHECK(std::abs(before.core.seat.value - after.core.seat.value) < 0.1 * us);
    CHECK(after.coil.closing_angle.value == Approx(before.coil.closing_angle.value).margin(1e-6));
    CHECK(after.flags == before.flags);
  }
}

TEST_CASE("a noisy record with ringing comes back from its export with the same events") {
  bench::SynthSettings s;
  s.force_case = bench::ForceCase::ring_in_band;
  const Record r = bench::synthesise(s, 5).record;
  const Imported in = import_text(to_csv(r), calibration_of(r, ""));
  check_same_train(dsp::extract_events(r).pvdf_a, dsp::extract_events(in.record, in.options).pvdf_a);
}

TEST_CASE("one film alone is enough, at 1 MS/s, 200 kS/s and 20 kS/s") {
  check_contacts(events_of(csv_of({.rate = 1e6})).pvdf_a, 5 * us);
  check_contacts(events_of(csv_of({})).pvdf_a, 8 * us);
  const Events slow = events_of(csv_of({.rate = 20e3, .title = "time [s],pvdf_b [N]"}));
  CHECK_FALSE(slow.pvdf_a.present);
  check_contacts(slow.pvdf_b, 60 * us);
  CHECK(slow.pvdf_b.resolution >= 150 * us);  // three samples
  CHECK((slow.flags & flag_no_calibration) != 0);
  CHECK_FALSE(slow.coil.closing_angle.known());
  CHECK_FALSE(slow.core.seat.known());
}

TEST_CASE("inverted, without pre-trigger, and triggered by the contact itself") {
  const Events turned = events_of(csv_of({.value = [](double t) { return -force(t); }}));
  check_contacts(turned.pvdf_a, 8 * us);
  CHECK((turned.pvdf_a.flags & flag_polarity) != 0);
  const Events bare = events_of(csv_of({.from = 0}));
  check_contacts(bare.pvdf_a, 8 * us);
  CHECK((bare.pvdf_a.flags & flag_no_hum_fit) != 0);
  for (const double trigger : {12e-3, 13.5e-3, 14.4e-3, 40e-3})  // the stamps count from there
    check_contacts(events_of(csv_of({.from = -0.045 - trigger,
                                     .to = 0.05 - trigger,
                                     .value = [&](double t) { return force(t + trigger); }}))
                       .pvdf_a,
                   8 * us, -trigger);
  check_contacts(
      events_of(csv_of({.from = 6.955, .to = 7.05, .value = [](double t) { return force(t - 7); }}),
                "switch_on_s = 7\n")
          .pvdf_a,
      8 * us);
}

TEST_CASE("volts need a gain, newtons must not have one") {
  const std::string volts = csv_of(
      {.noise = 0.003, .title = "time [s],pvdf_a [V]", .value = [](double t) { return force(t) / 10; }});
  CHECK_THAT(complaint(volts), Contains("shot.csv:1") && Contains("pvdf_a [V]") &&
                                   Contains("[pvdf_a] gain_N_per_V") && Contains("shot.toml"));
  const Events e = events_of(volts, "calibration = \"c\"\n[pvdf_a]\ngain_N_per_V = 10\n");
  check_contacts(e.pvdf_a, 8 * us);
  CHECK(e.pvdf_a.contacts[0].peak.value == Approx(10).margin(0.1));
  CHECK((e.flags & flag_no_calibration) == 0);
  const Events old =
      events_of(volts, "calibration = \"c\"\nvalid_until = \"2030-05-31\"\n[pvdf_a]\ngain_N_per_V = 10\n");
  CHECK((old.flags & flag_no_calibration) != 0);
  CHECK_THAT(complaint(csv_of({}), "[pvdf_a]\ngain_N_per_V = 10\n"), Contains("is N already"));
}

TEST_CASE("lost cells are masked where they are, in their channel alone") {
  std::string text = "time [s],pvdf_a [N],pvdf_b [N],laser [mm]\n";
  for (int i = 0; i < 4000; ++i) {
    const double t = (i - 1000) * 1e-5;
    const bool lost =
        (i >= 2200 && i < 2215) || i == 500;  // inside the first pulse, and one in the pre-trigger
    text += fmt::format("{:.6f},{},{:.4f},{}\n", t,
                        lost ? std::string("nan") : fmt::format("{:.4f}", force(t) + 0.001 * (i % 3)),
                        force(t) + 0.001 * (i % 3),
                        i % 50 ? std::string() : fmt::format("{:.3f}", 0.1 * i / 4000));
  }
  const Imported in = import_text(text);
  const Record& r = in.record;
  REQUIRE(r.channels.size() == 3);
  REQUIRE(r.channels[0].gaps.size() == 2);
  CHECK(r.channels[0].gaps[1].first == 2200);
  CHECK(r.channels[0].gaps[1].count == 15);
  CHECK(r.channels[1].gaps.empty());
  REQUIRE(r.channels[2].gaps.size() == 1);  // a slower channel is whole between its first and last number
  CHECK(r.channels[2].gaps[0].first == 3951);
  CHECK(r.channels[2].value(2025) == Approx(0.1e-3 * 2025 / 4000).margin(1e-6));
  const Events e = dsp::extract_events(r, in.options);
  check_contacts(e.pvdf_a, 20 * us);
  CHECK((e.pvdf_a.contacts[0].flags & flag_gap) != 0);
  CHECK((e.pvdf_a.contacts[1].flags & flag_gap) == 0);
  CHECK((e.pvdf_b.contacts[0].flags & flag_gap) == 0);
}

TEST_CASE("uneven stamps are resampled, dropped samples become gaps") {
  Random random(3);
  std::string uneven = "time [us],pvdf_a [mN]\n", dropped = "time [s],pvdf_a [N]\n";
  for (int i = -9000; i < 10000; ++i) {
    const double t = 5 * us * (i + 0.6 * random.uniform());
    uneven += fmt::format("{:.4f},{:.1f}\n", t * 1e6, 1e3 * (force(t) + 0.03 * random.normal()));
    if (i < 4000 || i > 4200)
      dropped += fmt::format("{:.6f},{:.4f}\n", 5 * us * i, force(5 * us * i) + 0.03 * random.normal());
  }
  check_contacts(events_of(uneven).pvdf_a, 8 * us);
  const Imported in = import_text(dropped);
  REQUIRE(in.record.channels[0].gaps.size() == 1);
  CHECK(in.record.channels[0].gaps[0].count == 201);
  check_contacts(dsp::extract_events(in.record, in.options).pvdf_a, 8 * us);
}

TEST_CASE("stamps without enough digits: named, and replaced by a stated rate") {
  std::string text = "time [s],pvdf_a [N]\n";
  Random random(2);
  for (int i = -9000; i < 10000; ++i)
    text += fmt::format("{:.4f},{:.4f}\n", 5 * us * i, force(5 * us * i) + 0.03 * random.normal());
  CHECK_THAT(complaint(text), Contains("shot.csv:3") && Contains("twice") && Contains("sample_rate_hertz"));
  check_contacts(events_of(text, "sample_rate_hertz = 200000\n").pvdf_a, 8 * us);
  std::string bare = "pvdf_a [N]\n";
  for (int i = 0; i < 4000; ++i) bare += fmt::format("{:.4f}\n", force(5 * us * i) + 0.03 * random.normal());
  check_contacts(events_of(bare, "sample_rate_hertz = 200000\n").pvdf_a, 8 * us);
}

TEST_CASE("fast records are averaged down; eight bits are enough for a few microseconds") {
  const Imported fast = import_text(csv_of({.rate = 10e6, .from = 0.005, .to = 0.03, .noise = 0.1}));
  CHECK(fast.record.sample_rate == 1e6);
  check_contacts(dsp::extract_events(fast.record, fast.options).pvdf_a, 5 * us);
  const auto scope = [](double t) { return std::round(force(t) / 0.08) * 0.08; };
  check_contacts(events_of(csv_of({.noise = 0, .value = scope})).pvdf_a, 20 * us);
}

TEST_CASE("saturation is recognised and the peak fitted") {
  const Events e =
      events_of(csv_of({.rate = 1e6, .noise = 0, .value = [](double t) { return std::min(force(t), 5.0); }}));
  check_contacts(e.pvdf_a, 5 * us);
  CHECK((e.pvdf_a.contacts[0].flags & flag_clipped) != 0);
  CHECK(e.pvdf_a.contacts[0].peak.value == Approx(10).epsilon(0.01));
}

TEST_CASE("what cannot be meant is refused with a sentence") {
  CHECK_THAT(complaint(""), Contains("empty"));
  CHECK_THAT(complaint("time [s],pvdf_a [N]\n"), Contains("0 samples; allowed 8"));
  CHECK_THAT(complaint("time [s],pvdf_a [N]\n0,1\n"), Contains("1 sample; allowed 8"));
  CHECK_THAT(complaint("time [s],pvdf_a [N]\n0,0\n1,0\n2,1\n3,1\n4,0\n5,1\n6,0\n7,1\n"),
             Contains("1 s apart") && Contains("is the unit right?"));
  CHECK_THAT(complaint(csv_of({.title = "time [s],laser [m]"})), Contains("laser [m]") && Contains("0.2 m"));
  CHECK_THAT(complaint(csv_of({.value = [](double t) { return 1e6 * force(t); }})),
             Contains("allowed a swing of 100000 N"));
  CHECK_THAT(complaint("time [s],pvdf_a [N]\n0,nan\n1e-5,nan\n2e-5,\n3e-5,\n4e-5,\n5e-5,\n6e-5,\n7e-5,\n"),
             Contains("no channel has a number"));
  CHECK_THAT(complaint("time [s],pvdf_a [N]\n0,1\n1e-5,2\n,3\n3e-5,1\n4e-5,1\n5e-5,1\n6e-5,1\n7e-5,1\n"),
             Contains("shot.csv:4") && Contains("has no number"));
  CHECK_THAT(complaint("time [s],pvdf_a [N]\n0,1\n2e-5,2\n1e-5,3\n3e-5,1\n4e-5,1\n5e-5,1\n6e-5,1\n7e-5,1\n"),
             Contains("shot.csv:4") && Contains("earlier"));
}

TEST_CASE("a dead channel gives no number") {
  const Imported in = import_text(csv_of({.noise = 0, .value = [](double) { return 2.5; }}));
  const Events e = dsp::extract_events(in.record, in.options);
  CHECK_FALSE(e.pvdf_a.present);
  CHECK(e.pvdf_a.contacts.empty());
  CHECK_THAT(fmt::format("{}", fmt::join(in.notes, "\n")), Contains("dead channel"));
  const auto j = nlohmann::json::parse(to_events_json(e, in.record));
  CHECK(j["channels"]["pvdf_a"]["contacts"].empty());
  CHECK(j["channels"]["pvdf_a"]["settled_s"].is_null());
  CHECK(j["channels"]["pvdf_a"]["resolution_s"].is_null());
}

TEST_CASE("the events in the form for other programs") {
  const Imported in = import_text(csv_of({}));
  const auto j = nlohmann::json::parse(to_events_json(dsp::extract_events(in.record, in.options), in.record));
  CHECK(j.size() == 5);
  CHECK(j["closing_angle_deg"].is_null());
  CHECK(j["no_closing_angle"] == "no mains-voltage channel");
  CHECK(j["u_closing_angle_deg"].is_null());
  CHECK(j["core"]["seat_s"].is_null());
  REQUIRE(j["channels"].size() == 1);
  const auto& a = j["channels"]["pvdf_a"];
  CHECK(a.size() == 7);
  CHECK(a["shows"] == "contact");
  CHECK(a["reason"].is_null());
  for (const char* key : {"settled_s", "u_settled_s", "bounce_time_s", "resolution_s"})
    CHECK(a[key].is_number());
  REQUIRE(a["contacts"].size() == 3);
  for (const auto& c : a["contacts"]) {
    CHECK(c.size() == 8);
    CHECK((c["probability"].is_number() && c["probability"] >= 0 && c["probability"] <= 1));
    for (const char* key : {"touch_s", "u_touch_s", "peak"}) CHECK(c[key].is_number());
    CHECK(c["flags"].is_array());
    CHECK(c["flags"].dump().find("no_calibration") != std::string::npos);
  }
  CHECK(a["contacts"][0]["release_s"].is_number());
  CHECK(a["contacts"][2]["release_s"].is_null());
  CHECK(a["contacts"][2]["u_release_s"].is_null());
}

TEST_CASE("a million rows", "[.slow]") {
  const Imported in = import_text(csv_of({.rate = 10e6, .from = -0.05, .to = 0.05, .noise = 0.1}));
  CHECK(in.record.samples() == 100'000);
  check_contacts(dsp::extract_events(in.record, in.options).pvdf_a, 5 * us);
}

TEST_CASE("columns of a foreign file are found by the names it has for them") {
  std::string csv = "TIME [s],CH1 [mV],CH2,Memory [V]\n";
  for (int i = 0; i < 4000; ++i) {
    const double t = -0.02 + 1e-5 * i;
    csv += fmt::format("{:.5f},{:.3f},{:.3f},{}\n", t, 100 * force(t), force(t), i % 7);
  }
  const std::string columns =
      "[columns]\ntime = \"TIME\"\npvdf_a = \"CH1\"\npvdf_b = \"CH2 [N]\"\n[pvdf_a]\ngain_N_per_V = 10\n";
  const Imported in = import_text(csv, columns);
  REQUIRE(in.record.channels.size() == 2);  // what nothing asks for is passed over, and told
  CHECK(std::any_of(in.notes.begin(), in.notes.end(),
                    [](const std::string& n) { return n.find("'Memory [V]'") != std::string::npos; }));
  const auto largest = [&](Channel c) {
    const ChannelRecord& r = *in.record.find(c);
    double top = 0;
    for (std::size_t i = 0; i < r.raw.size(); ++i) top = std::max(top, (r.raw[i] + r.offset) * r.scale);
    return top;
  };
  // CH1: 1000 mV at 10 N per V; CH2: newtons, although its header has no unit.
  CHECK(largest(Channel::pvdf_a) == Approx(10).epsilon(0.01));
  CHECK(largest(Channel::pvdf_b) == Approx(10).epsilon(0.01));
  check_contacts(dsp::extract_events(in.record, in.options).pvdf_b, 25 * us);
}

TEST_CASE("foreign columns: mistakes are named") {
  const std::string rows = "0,1,2\n1e-5,1,2\n2e-5,1,2\n";
  CHECK_THAT(complaint("time [s],CH1 [V],CH2\n" + rows, "[columns]\npvdf_a = \"CH3 [N]\"\n"),
             Contains("[columns] pvdf_a = \"CH3 [N]\"") && Contains("'CH1 [V]'"));
  CHECK_THAT(complaint("time [s],CH1,CH1\n" + rows, "[columns]\npvdf_a = \"CH1 [N]\"\n"), Contains("twice"));
  CHECK_THAT(complaint("time [s],CH1,CH2\n" + rows, "[columns]\npvdf_a = \"CH1\"\n"),
             Contains("'CH1', named in [columns]") && Contains("has no unit"));
  CHECK_THAT(complaint("time [s],CH1,CH2\n" + rows, "[columns]\npvdf_a = \"CH1 [A]\"\n"),
             Contains("unit 'A' does not fit"));
  CHECK_THAT(complaint("time [s],CH1,CH2\n" + rows, "[columns]\nfilm = \"CH1 [N]\"\n"), Contains("film"));
  // without the table a foreign name is still a mistake
  CHECK_THAT(complaint("time [s],CH1,CH2\n" + rows), Contains("'CH1': is not known"));
}
