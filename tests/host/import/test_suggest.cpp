#include <fmt/format.h>

#include <catch2/catch.hpp>

#include "host/import/calibration.h"
#include "host/import/suggest.h"
#include "tests/host/import/unnamed_columns.h"

using namespace powbench;
using namespace powbench::host;
using namespace powbench::test;
using Catch::Matchers::Contains;

TEST_CASE("what a shape says is true, on closings in volts without names", "[import][suggest]") {
  int by_shape = 0, wrong = 0, of_five = 0;
  for (std::uint64_t seed = 1; seed <= 40; ++seed) {
    const Shown s = shown(seed);
    for (const Suggestion& x : suggest_columns(s.table).columns) {
      if (x.ground != Ground::shape || !x.channel) continue;
      ++by_shape;
      wrong += *x.channel != s.truth[x.column] ? 1 : 0;
    }
    of_five += 5;
  }
  WARN("by shape: " << by_shape << " of " << of_five << " named, " << wrong << " of them wrong");
  CHECK(by_shape > of_five * 3 / 4);
  CHECK(wrong <= by_shape / 50);
}

TEST_CASE("travels and coil currents of many shapes are told apart, and how surely", "[import][suggest]") {
  const std::vector<Invented> traces{
      {"travel", Channel::laser, [](double t) { return moves(t, 2); }},
      {"travel, late and sudden", Channel::laser, [](double t) { return moves(t - 60e-3, 3); }},
      {"travel that rebounds by a quarter", Channel::laser,
       [](double t) { return moves(t, 2) - rebounds(t, 0.25); }},
      {"late travel that rebounds by a quarter", Channel::laser,
       [](double t) { return moves(t - 70e-3, 2) - rebounds(t - 70e-3, 0.25); }},
      {"travel with overshoot into the pole faces", Channel::laser,
       [](double t) { return moves(t, 2) + 0.1 * rebounds(t, 1); }},
      {"AC current, 50 Hz", Channel::coil_current, [](double t) { return ac_current(t, 50, 8, 5e-3); }},
      {"AC current, 60 Hz", Channel::coil_current, [](double t) { return ac_current(t, 60, 5, 10e-3); }},
      {"AC current, little inrush", Channel::coil_current,
       [](double t) { return ac_current(t, 50, 2.2, 10e-3); }},
      {"DC current with a dip", Channel::coil_current, [](double t) { return dc_current(t, 0.3); }},
      {"DC current with a small dip", Channel::coil_current, [](double t) { return dc_current(t, 0.05); }},
      {"DC current without a dip", Channel::coil_current,
       [](double t) { return t < 0 ? 0.0 : 1 - std::exp(-t / 8e-3); }},
      {"contact voltage", Channel::contact_a,
       [](double t) { return t < 10e-3 || (t > 11e-3 && t < 12.5e-3) ? 1.0 : 0.0; }},
  };
  std::uint64_t seed = 1;
  for (const Invented& trace : traces) {
    const bool to_zero = trace.channel == Channel::contact_a;  // what it is depends on its zero
    for (const double gain : {1.0, -1.0, 4.0, 30.0, -30.0})
      for (const double offset : {0.0, 2.5, -6.0})
        for (const double drift : {0.0, 0.04, -0.04}) {
          if (to_zero && (offset != 0 || drift != 0 || gain < 0)) continue;
          if (trace.channel == Channel::coil_current && drift != 0)
            continue;  // clamps have an offset, lasers drift
          INFO(trace.name << ", gain " << gain << ", offset " << offset << ", drift " << drift);
          const Suggestion found = suggested(trace, gain, offset, drift, 0.005, seed++);
          REQUIRE(found.channel);
          CHECK(info(*found.channel).name == info(trace.channel).name);
          CHECK(found.ground == Ground::shape);
          CHECK(found.sure != Sureness::unsure);
        }
  }
  // between both: a straight way up is the travel of a constant speed or a current that is limited
  const Invented straight{"straight", Channel::laser,
                          [](double t) { return std::clamp(t / 20e-3, 0.0, 1.0); }};
  CHECK(suggested(straight, 1, 0, 0, 0.005, 7).sure != Sureness::sure);
  // noise alone says nothing
  const Invented nothing{"nothing", Channel::aux, [](double) { return 0.0; }};
  CHECK(suggested(nothing, 1, 0, 0, 0.005, 8).sure == Sureness::unsure);
}

TEST_CASE("names and units decide before shapes, and the file that is written is read back",
          "[import][suggest]") {
  const Shown s = shown(3);
  CsvTable t = s.table;
  for (std::size_t c = 1; c < t.header.size(); ++c) {
    if (s.truth[c] == Channel::coil_voltage) t.header[c] = "U_coil [V]";
    if (s.truth[c] == Channel::coil_current) t.header[c] = "probe [A]";
    if (s.truth[c] == Channel::pvdf_a) t.header[c] = "Force A [V]";
    if (s.truth[c] == Channel::pvdf_b) t.header[c] = "sensor \"2\" [N]";
  }
  const Suggested found = suggest_columns(t);
  for (const Suggestion& x : found.columns) {
    if (s.truth[x.column] == Channel::coil_voltage) CHECK(x.ground == Ground::name);
    if (s.truth[x.column] == Channel::coil_current) CHECK(x.ground == Ground::unit);
    if (s.truth[x.column] == Channel::pvdf_b) CHECK(x.ground == Ground::unit);
    if (s.truth[x.column] == Channel::coil_voltage || s.truth[x.column] == Channel::pvdf_a ||
        s.truth[x.column] == Channel::pvdf_b) {
      REQUIRE(x.channel);
      CHECK(*x.channel == s.truth[x.column]);
    }
  }
  REQUIRE(found.switch_on);
  CHECK(*found.switch_on == Approx(0.0).margin(5e-3));
  const std::string text = suggested_file(t, found, "scope.csv");
  CHECK_THAT(text, Contains("pvdf_b = \"sensor \\\"2\\\" [N]\"") && Contains("# gain_N_per_V = ?"));
  const Calibration k = parse_calibration(text, "scope.toml");
  CHECK(k.columns[1 + index(Channel::pvdf_a)] == "Force A [V]");
}

TEST_CASE("a time in milliseconds, under another name, changes no suggestion", "[import][suggest]") {
  for (const std::uint64_t seed : {41U, 42U, 43U}) {
    const Shown s = shown(seed);
    const Suggested seconds = suggest_columns(s.table);
    for (const char* title : {"time [ms]", "Zeit [ms]"}) {
      CsvTable t = s.table;
      t.header[0] = title;
      for (double& v : t.columns[0]) v *= 1e3;
      const Suggested found = suggest_columns(t);
      REQUIRE(found.columns.size() == seconds.columns.size());
      for (std::size_t i = 0; i < found.columns.size(); ++i) {
        CHECK(found.columns[i].channel == seconds.columns[i].channel);
        CHECK(found.columns[i].ground == seconds.columns[i].ground);
      }
      REQUIRE(found.switch_on.has_value() == seconds.switch_on.has_value());
      if (found.switch_on) CHECK(*found.switch_on == Approx(*seconds.switch_on).margin(1e-9));
      const Calibration k = parse_calibration(suggested_file(t, found, "x.csv"), "x.toml");
      CHECK(k.columns[0] == (title[0] == 'Z' ? "Zeit [ms]" : ""));
    }
  }
}

TEST_CASE("columns without units are suggested as volts, and the file asks for their gains",
          "[import][suggest]") {
  Shown s = shown(44);
  for (std::size_t c = 1; c < s.table.header.size(); ++c) s.table.header[c] = fmt::format("K{}", c);
  const Suggested found = suggest_columns(s.table);
  const std::string text = suggested_file(s.table, found, "x.csv");
  const Calibration k = parse_calibration(text, "x.toml");
  for (const Suggestion& x : found.columns)
    if (x.channel) CHECK(k.columns[1 + index(*x.channel)] == s.table.header[x.column] + " [V]");
  CHECK_THAT(text, Contains("# gain_N_per_V = ?"));
  // a probe of 1:100 that the instrument does not know of: the line works when its # is taken away
  const std::string probe = "[coil_voltage]\n# gain_V_per_V = 100";
  REQUIRE_THAT(text, Contains(probe) && Contains("[contact_a]\n# gain_V_per_V = 100"));
  std::string with = text;
  with.erase(with.find(probe) + probe.find('#'), 2);
  CHECK(parse_calibration(with, "x.toml").of(Channel::coil_voltage).gain == 100);
}

TEST_CASE("a column that no channel fits stays without one", "[import][suggest]") {
  CsvTable t;
  t.header = {"time [s]", "T [degC]", "mains [V]", "mains 2 [V]"};
  t.columns.assign(4, std::vector<double>(100, 1.0));
  t.line.assign(100, 1);
  const Suggested s = suggest_columns(t);
  REQUIRE(s.columns.size() == 3);
  CHECK_FALSE(s.columns[0].channel);
  CHECK(*s.columns[1].channel == Channel::mains_voltage);
  CHECK(*s.columns[2].channel != Channel::mains_voltage);
  CHECK(s.columns[2].ground == Ground::guess);
  CHECK_THAT(suggested_file(t, s, "x.csv"), Contains("# \"T [degC]\" :"));
}
