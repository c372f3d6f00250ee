#include <catch2/catch.hpp>
#include <filesystem>
#include <map>
#include <string>
#include <vector>

#include "core/random.h"
#include "host/config/plan_file.h"
#include "host/config/rig_file.h"
#include "host/config/specimen_file.h"
#include "sim/specimen/specimen_fields.h"
#include "tests/places.h"

using namespace powbench;
using namespace powbench::host;

namespace {

std::vector<std::string> plan_errors(const std::string& text) {
  try {
    parse_plan(text, "p.toml");
  } catch (const BadInput& e) {
    return e.errors();
  }
  return {};
}

std::vector<std::string> specimen_errors(const std::string& text) {
  try {
    parse_specimen(text, "s.toml");
  } catch (const BadInput& e) {
    return e.errors();
  }
  return {};
}

std::vector<std::string> rig_errors(const std::string& text) {
  try {
    parse_rig(text, "r.toml");
  } catch (const BadInput& e) {
    return e.errors();
  }
  return {};
}

using Errors = std::vector<std::string>;
const std::string good = "angles_deg = [0, 90]\nrepeats = 2\n";

}  // namespace

TEST_CASE("a plan needs angles and repeats; all the rest has defaults", "[config]") {
  const Plan p = parse_plan(good, "p.toml");
  CHECK(p.angles == std::vector<double>{0.0, radians(90)});
  CHECK(p.repeats == 2);
  CHECK(p.order == Order::random);
  CHECK(p.supply_volts == 230.0);
  CHECK(p.ambient == 293.15);
  CHECK(p.specimen.empty());
  CHECK(std::isnan(p.limits[0].low));

  CHECK(plan_errors("") == Errors{"p.toml:1: angles_deg: is missing; allowed 0..360 deg",
                                  "p.toml:1: repeats: is missing; allowed 1..10000"});
}

TEST_CASE("all mistakes of a plan are told at once, by line", "[config]") {
  const Errors errors = plan_errors(
      "name = 7\n"
      "angle_deg = [0, 90]\n"
      "angles_deg = [0, 400]\n"
      "repeats = 0\n"
      "order = \"randm\"\n"
      "supply_volts = \"230 V\"\n"
      "mains_hertz = nan\n"
      "[limits.t_ct1]\n"
      "min_ms = 20\n"
      "max_ms = 10\n"
      "[limits.t_ct3]\n"
      "max_ms = 2\n"
      "[limits.F_peak]\n"
      "max_ms = 2\n");
  CHECK(errors == Errors{
                      "p.toml:1: name = 7: is a whole number, must be text in quotes",
                      "p.toml:2: angle_deg = [0, 90]: unknown key; did you mean 'angles_deg'?",
                      "p.toml:3: angles_deg = [0, 400]: item 2 out of range; allowed 0..360 deg",
                      "p.toml:4: repeats = 0: out of range; allowed 1..10000",
                      "p.toml:5: order = \"randm\": no such word; did you mean 'random'?; allowed "
                      "\"random\", \"sequential\", \"by_hand\"",
                      "p.toml:6: supply_volts = \"230 V\": is text, must be a number in V; allowed 1..1000 V",
                      "p.toml:7: mains_hertz = nan: not finite; allowed 10..1000 Hz",
                      "p.toml:9: [limits.t_ct1] min_ms = 20: is above max_ms",
                      "p.toml:11: [limits.t_ct3]: unknown section; did you mean 'limits.t_ct1'?",
                      "p.toml:14: [limits.F_peak] max_ms = 2: unknown key; did you mean 'max_N'?",
                  });
}

TEST_CASE("wanted channels are named one by one, and a wrong name is told with the right ones", "[config]") {
  const Plan plan = parse_plan(good + "[wanted]\nchannels = \"contact_a laser\"\n", "p.toml");
  const ChannelSet set = wanted_channels(plan);
  CHECK(contains(set, Channel::contact_a));
  CHECK(contains(set, Channel::laser));
  CHECK_FALSE(contains(set, Channel::pvdf_a));
  CHECK(wanted_channels(parse_plan(good, "p.toml")) == all_channels);
  CHECK(
      plan_errors(good + "[wanted]\nchannels = \"contact_a lasr\"\n") ==
      Errors{"p.toml:4: [wanted] channels = \"contact_a lasr\": names 'lasr'; allowed pvdf_a, pvdf_b, laser, "
             "coil_current, coil_voltage, mains_voltage, contact_a, aux"});
}

TEST_CASE(
    "a plan's filter is read with units, refused with what is allowed, and absent from the text of a plan "
    "without one",
    "[config]") {
  using Kind = dsp::EventFilter::Kind;
  const Plan plan =
      parse_plan(good + "[events]\nfilter = \"bandstop:3.1..3.6 kHz\"\nphase = \"causal\"\n", "p.toml");
  dsp::ExtractOptions o;
  CHECK(set_filter(o, plan.events).key.empty());
  CHECK(o.filter.kind == Kind::stop);
  CHECK(o.filter.low_hertz == 3100);
  CHECK(o.filter.high_hertz == 3600);
  CHECK(o.filter.phase == dsp::FilterPhase::causal);
  CHECK(text_of(o.filter) == "bandstop:3.1kHz..3.6kHz");
  CHECK(resolved_text(parse_plan(resolved_text(plan), "x")) == resolved_text(plan));
  CHECK(resolved_text(parse_plan(good, "p.toml")).find("events") == std::string::npos);
  CHECK(plan_errors(good + "[events]\nfilter = \"highpass:2kHz\"\n") ==
        Errors{"p.toml:4: [events] filter = \"highpass:2kHz\": 'highpass:2kHz' is no filter; allowed " +
               std::string(filter_forms)});
  CHECK(plan_errors(good + "[events]\nband = \"18kHz..800Hz\"\n") ==
        Errors{"p.toml:4: [events] band = \"18kHz..800Hz\": '18kHz..800Hz' ends below its start; allowed " +
               std::string(band_forms)});
  for (const char* text : {"none", "plain", "lowpass:750Hz", "bandstop:900Hz..1.25kHz"}) {
    CHECK(read_filter(text, o.filter).empty());
    CHECK(text_of(o.filter) == text);
  }
}

TEST_CASE("wrong types and odd values each have their sentence", "[config]") {
  CHECK(plan_errors(good + "seed = 1.5\n") ==
        Errors{"p.toml:3: seed = 1.5: is a number, must be a whole number; allowed 0..2^53"});
  CHECK(plan_errors(good + "seed = -1\n") == Errors{"p.toml:3: seed = -1: out of range; allowed 0..2^53"});
  CHECK(plan_errors("repeats = 2\nangles_deg = 30\n") ==
        Errors{"p.toml:2: angles_deg = 30: is a whole number, must be a list of numbers or { start, stop, "
               "step }; allowed 0..360 deg"});
  CHECK(plan_errors("repeats = 2\nangles_deg = []\n") ==
        Errors{"p.toml:2: angles_deg = []: is an empty list; allowed 0..360 deg"});
  CHECK(
      plan_errors("repeats = 2\nangles_deg = [0, 'x']\n") ==
      Errors{"p.toml:2: angles_deg = [0, 'x']: item 2 is text, must be a number in deg; allowed 0..360 deg"});
  CHECK(plan_errors("repeats = 2\nangles_deg = [0, 90, 360]\n") ==
        Errors{"p.toml:2: angles_deg = [0, 90, 360]: 0 deg is listed twice (360 deg is 0 deg; steps of 0.01 "
               "deg); use repeats"});
  CHECK(plan_errors("repeats = 9000\nangles_deg = {start = 0, stop = 179, step = 1}\n") ==
        Errors{"p.toml:1: repeats = 9000: gives 1620000 shots with 180 angles; allowed 1..100000 shots"});
  CHECK(plan_errors(good + "limits = 3\n") ==
        Errors{"p.toml:3: limits: is a section: write [limits] and its keys below"});
  CHECK(plan_errors(good + "[[limits]]\n") ==
        Errors{"p.toml:3: limits: is a section: write [limits] and its keys below"});
  CHECK(plan_errors(good + "[extra]\nx = 1\n")
            .at(0)
            .starts_with("p.toml:3: [extra]: unknown section; known: limits.t_ct1, "));
  CHECK(plan_errors(good + "name = \"\"\n") == Errors{"p.toml:3: name = \"\": is empty"});
}

TEST_CASE("what is no TOML is told with its line, and the rest is still checked", "[config]") {
  const Errors errors = plan_errors("angles_deg = [0]\nrepeats = = 3\nsupply_volts = 5000\n");
  REQUIRE(errors.size() == 2);
  CHECK(errors[0].starts_with("p.toml:2: not TOML: "));
  CHECK(errors[1] == "p.toml:3: supply_volts = 5000: out of range; allowed 1..1000 V");

  CHECK(plan_errors(good + "seed = 1\nseed = 2\nrepaets = 3\n") ==
        Errors{"p.toml:4: seed: given twice; keep one of the two lines",
               "p.toml:5: repaets = 3: unknown key; did you mean 'repeats'?"});

  const Errors open_list = plan_errors("repeats = 3\nangles_deg = [0, 30\n");
  REQUIRE(open_list.size() == 1);
  CHECK(open_list[0].find("not TOML") != std::string::npos);

  CHECK(plan_errors(std::string("repeats = \"\xFF\xFE\"\n")).size() == 1);
}

TEST_CASE("an even list of angles is a table", "[config]") {
  const auto even = [](const std::string& table) {
    return parse_plan("repeats = 1\nangles_deg = " + table + "\n", "p.toml").angles;
  };
  CHECK(even("{start = 0, stop = 90, step = 30}") ==
        std::vector<double>{0, radians(30), radians(60), radians(90)});
  CHECK(even("{start = 0, stop = 100, step = 30}").size() == 4);
  CHECK(even("{start = 90, stop = 0, step = -45}") == std::vector<double>{radians(90), radians(45), 0});
  CHECK(even("{start = 0, stop = 0.9, step = 0.1}").at(3) == radians(0.3));
  CHECK(even("{start = 5, stop = 5, step = 1}").size() == 1);

  CHECK(plan_errors("repeats = 1\nangles_deg = {start = 0, stop = 90, stepp = 3}\n") ==
        Errors{"p.toml:2: angles_deg = {start = 0, stop = 90, stepp = 3}: unknown key 'stepp'; did you mean "
               "'step'?; allowed 0..360 deg"});
  CHECK(plan_errors("repeats = 1\nangles_deg = {start = 0, stop = 90, step = 0}\n")
            .at(0)
            .find("does not lead") != std::string::npos);
  CHECK(plan_errors("repeats = 1\nangles_deg = {start = 0, stop = 90, step = -1}\n")
            .at(0)
            .find("does not lead") != std::string::npos);
  CHECK(plan_errors("repeats = 1\nangles_deg = {start = 0, stop = 90, step = 1e-6}\n")
            .at(0)
            .find("more than 10000") != std::string::npos);
  CHECK(plan_errors("repeats = 1\nangles_deg = {start = 0, step = 1}\n").at(0).find("'stop' is missing") !=
        std::string::npos);
}

TEST_CASE("the resolved plan reads back as the same plan, and equal plans give equal bytes", "[config]") {
  const std::string text =
      "name = \"quotes \\\" and \\\\ and \\n\"\nspecimen = \"x.toml\"\nrepeats = 4\nseed = 9007199254740991\n"
      "angles_deg = [0, 33.33, 270]\norder = \"sequential\"\nambient_degC = -12.3\npause_s = 0.1\n"
      "polarity = \"alternate\"\nangle_tolerance_deg = 0.7\nlimits_vs_simulation_percent = 12.5\n"
      "hold_time_ms = 83.7\n[limits.t_ct1]\nmin_ms = 9.1\n[limits.v_core]\nmax_m_per_s = 1.7\n";
  const Plan p = parse_plan(text, "a.toml");
  const std::string resolved = resolved_text(p);
  const Plan q = parse_plan(resolved, "b.toml");
  CHECK(resolved_text(q) == resolved);
  CHECK(q.name == "quotes \" and \\ and \n");
  CHECK(q.seed == 9007199254740991ULL);
  CHECK(q.angles == p.angles);
  CHECK(q.ambient == p.ambient);
  CHECK(q.hold_time == 83.7e-3);
  CHECK(q.limits[0].low == 9.1e-3);
  CHECK(std::isnan(q.limits[0].high));
  CHECK(q.limits_vs_simulation == 0.125);
  CHECK(resolved.find("\n[limits.t_ct1]\nmin_ms = 9.1\n") != std::string::npos);
  CHECK(resolved_text(parse_plan("# other words\nrepeats=2\nangles_deg=[ 0.0, 9e1 ]", "x")) ==
        resolved_text(parse_plan(good, "p.toml")));
}

TEST_CASE("templates are valid files that hold the defaults", "[config]") {
  const Plan p = parse_plan(plan_template(), "template");
  CHECK(p.angles.size() == 7);
  CHECK(p.specimen.empty());
  CHECK(resolved_text(parse_rig(rig_template(), "template")) == resolved_text(RigFile{}));
  sim::Specimen plain;
  plain.shaped = false;  // a template sets nothing, so nobody drew a core
  CHECK(resolved_text(parse_specimen(specimen_template(), "template")) == resolved_text(plain));
  CHECK(specimen_template().find("# x_c, travel to first touch; allowed 0.05..50 mm\n#gap_mm = ") !=
        std::string::npos);
  CHECK(plan_template().find("required\nrepeats = 3\n") != std::string::npos);
}

TEST_CASE("the scenes of the repository are read without a mistake", "[config]") {
  const std::filesystem::path scenes = std::filesystem::path(powbench::test::source_dir()) / "scenes";
  const Plan plan = read_plan(scenes / "demo.plan.toml");
  CHECK(plan.angles.size() == 7);
  CHECK(plan.repeats == 3);
  const RigFile rig = read_rig(scenes / "demo.rig.toml");
  CHECK(rig.config.sample_rate == 100e3);
  CHECK(resolved_text(load_specimen(plan)) == resolved_text(sim::Specimen{}));
  CHECK(resolved_text(load_specimen(rig)) == resolved_text(load_specimen(plan)));
}

TEST_CASE("a specimen file reaches every field of the simulator's table", "[config]") {
  Random random(1);
  std::string section, text = "name = \"other\"\n";
  for (const auto& f : sim::specimen_fields()) {
    if (f.section != section) text.append("[").append(section = f.section).append("]\n");
    const double share = random.uniform();
    const double value = f.whole ? f.high : f.low + share * 1e-3 * (f.high - f.low);
    // what has to fit together: gaps within the travel, a closed leg of two without a ring; exponents are 1, 1.5 or 2
    const std::map<std::string_view, const char*> given{
        {"travel_mm", "49"}, {"tilt_gap_mm", "0.01"}, {"gap_spread_mm", "0.01"}, {"ring_share", "0"},
        {"legs", "2"},       {"closed_leg", "1"},     {"stop_exponent", "1.5"},  {"contact_exponent", "1.5"}};
    const auto fitting = given.find(f.key);
    text +=
        std::string(f.key) + " = " +
        (fitting != given.end() ? fitting->second
                                : std::to_string(f.whole ? int(value) : value).substr(0, f.whole ? 1 : 30)) +
        "\n";
  }
  const sim::Specimen s = parse_specimen(text, "s.toml");
  for (const auto& f : sim::specimen_fields()) {
    CAPTURE(f.key);
    CHECK(f.get(s) != f.get(sim::Specimen{}));
  }
  CHECK(s.name == "other");
  CHECK(resolved_text(parse_specimen(resolved_text(s), "again")) == resolved_text(s));
}

TEST_CASE("an exponent between the contact laws is refused", "[config]") {
  CHECK(specimen_errors("[core]\nstop_exponent = 1.2\n") ==
        Errors{"s.toml:2: [core] stop_exponent = 1.2: no contact law has this exponent: 1.2; allowed 1, 1.5 "
               "and 2"});
}

TEST_CASE("specimen mistakes name the key, the range and the section it belongs to", "[config]") {
  CHECK(specimen_errors("[coil]\nturns = 2366\ngap_mm = 2.5\nresistance = 300\n[bridges]\ngap_mm = "
                        "251\npoles = 2.5\n[brigdes]\n") ==
        Errors{
            "s.toml:3: [coil] gap_mm = 2.5: unknown key here; did you mean 'bridges.gap_mm'?",
            "s.toml:4: [coil] resistance = 300: unknown key; did you mean 'resistance_ohm'?",
            "s.toml:6: [bridges] gap_mm = 251: out of range; allowed 0.05..50 mm",
            "s.toml:7: [bridges] poles = 2.5: is a number, must be a whole number; allowed 1..8",
            "s.toml:8: [brigdes]: unknown section; did you mean 'bridges'?",
        });
  const Errors crossed = specimen_errors("[core]\ntravel_mm = 2\n");
  REQUIRE(crossed.size() == 1);
  CHECK(crossed[0].starts_with("s.toml:1: [bridges] gap_mm: does not fit the other lengths: "));
  const Errors wide = specimen_errors("[core]\ntravel_mm = 2\n[bridges]\n\ngap_mm = 2.25\n");
  REQUIRE(wide.size() == 1);
  CHECK(
      wide[0].starts_with("s.toml:5: [bridges] gap_mm = 2.25: does not fit the other lengths: 2.25; allowed "
                          "above 0, below 2 (core.travel_mm)"));
}

TEST_CASE("rig files set the simulated rig, and their mistakes are told", "[config]") {
  const RigFile r = parse_rig(
      "listen = \"127.0.0.9\"\nsample_rate_hertz = 200_000\n[ring]\nmode_hertz = [1, 2, 3]\n"
      "[faults]\ncoil_open = true\nmains_dip_percent = 60\n[device]\ngap_mm = -0.1\n",
      "r.toml");
  CHECK(r.listen == "127.0.0.9");
  CHECK(r.config.sample_rate == 200e3);
  CHECK(r.config.sensors.ring[2].hertz == 3.0);
  CHECK(r.config.sensors.ring[2].damping == 0.020);
  CHECK(r.config.faults.coil_open);
  CHECK(r.config.faults.mains_dip == 0.6);
  CHECK(r.config.device.gap == -0.1e-3);

  CHECK(
      rig_errors("listen = \"bench7\"\nrecord_length_ms = 60\npretrigger_ms = 100\n[ring]\nmode_hertz = [1, "
                 "2]\n[faults]\ncoil_open = 1\n[force]\ncorner_hertz = 2000\n") ==
      Errors{
          "r.toml:1: listen = \"bench7\": is no IPv4 address; for example 127.0.0.7",
          "r.toml:3: pretrigger_ms = 100: leaves nothing of the record after switch-on; allowed less than "
          "record_length_ms",
          "r.toml:5: [ring] mode_hertz = [1, 2]: has 2 items, must be a list of 3 numbers; allowed "
          "1..1000000 Hz",
          "r.toml:7: [faults] coil_open = 1: is a whole number, must be true or false; allowed true, false",
          "r.toml:9: [force] corner_hertz = 2000: out of range; allowed 0.0001..1000 Hz",
      });
}

TEST_CASE("a file that cannot be read is bad input", "[config]") {
  CHECK_THROWS_WITH(read_plan("/nonexistent/p.toml"),
                    "/nonexistent/p.toml: cannot be read: No such file or directory");
  CHECK_THROWS_WITH(read_plan("/"), "/: is a directory, not a file");
}

TEST_CASE("a letter beyond ASCII where a key begins is one clear error, whatever its code", "[config]") {
  for (const char* letter :
       {"\xC2\xA1", "\xC3\xA9", "\xD1\x8F", "\xE3\x81\x82", "\xEF\xBF\xBD", "\xF0\x9F\x98\x80"}) {
    CAPTURE(letter);
    CHECK_THROWS_WITH(parse_plan(std::string("schema = 1\n") + letter + " = 3\n", "p.toml"),
                      Catch::Matchers::Contains("p.toml:2"));
  }
}

TEST_CASE("random bytes and cut files never do worse than BadInput", "[config]") {
  const std::string whole = plan_template() + "\n[limits.t_ct2]\nmax_ms = 3\n";
  Random random(99);
  for (int i = 0; i < 400; ++i) {
    std::string text = whole.substr(0, random.below(whole.size() + 1));
    for (std::uint64_t k = random.below(6); k > 0 && !text.empty(); --k)
      text[random.below(text.size())] = static_cast<char>(random.below(256));
    try {
      parse_plan(text, "p.toml");
    } catch (const BadInput& e) {
      REQUIRE_FALSE(e.errors().empty());
    }
  }
}
