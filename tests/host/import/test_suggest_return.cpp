#include <fmt/format.h>

#include <catch2/catch.hpp>

#include "host/import/calibration.h"
#include "host/import/suggest.h"
#include "tests/host/import/unnamed_columns.h"

using namespace powbench;
using namespace powbench::host;
using namespace powbench::test;
using Catch::Matchers::Contains;

TEST_CASE("what a shape says is true, also where the record goes on behind switch-off", "[import][suggest]") {
  int by_shape = 0, wrong = 0, of_five = 0;
  for (std::uint64_t seed = 1; seed <= 40; ++seed) {
    const Shown s = shown(seed, true);
    const Suggested found = suggest_columns(s.table);
    for (const Suggestion& x : found.columns) {
      const Channel truth = s.truth[x.column];
      INFO("seed " << seed << ", " << s.table.header[x.column] << " is " << info(truth).name);
      const bool film = x.channel == Channel::pvdf_a || x.channel == Channel::pvdf_b;
      if (truth == Channel::coil_voltage || truth == Channel::mains_voltage || truth == Channel::contact_a)
        CHECK_FALSE(film);
      if (truth == Channel::coil_voltage) CHECK(x.channel == Channel::coil_voltage);
      if (truth == Channel::contact_a) CHECK(x.channel == Channel::contact_a);
      if (x.ground != Ground::shape || !x.channel) continue;
      ++by_shape;
      CHECK(info(*x.channel).name == info(truth).name);
      wrong += *x.channel != truth ? 1 : 0;
    }
    of_five += 5;
  }
  WARN("with switch-off, by shape: " << by_shape << " of " << of_five << " named, " << wrong << " wrong");
  CHECK(by_shape > of_five * 3 / 4);
  CHECK(wrong == 0);
}

TEST_CASE("a column that comes back to its rest is what it was before, also alone in its file",
          "[import][suggest]") {
  const auto on = [](double t, double from = 0) { return t >= from && t < 0.1; };
  const std::vector<Invented> traces{
      {"contact voltage that falls and comes back", Channel::contact_a,
       [](double t) { return t < 10e-3 || (t > 11e-3 && t < 12.5e-3) || t > 0.12 ? 6.0 : 0.0; }},
      {"travel there and back", Channel::laser,
       [](double t) { return t < 0.11 ? moves(t, 2) : 1 - moves(t - 0.106, 2); }},
      {"AC current", Channel::coil_current,
       [&](double t) { return on(t) ? ac_current(t, 50, 4, 5e-3) : 0.0; }},
      {"coil voltage, 325 V", Channel::coil_voltage,
       [&](double t) { return on(t) ? 325 * std::sin(2 * pi * 50 * t + 1) : 0.0; }},
      {"coil voltage, 24 V of 60 Hz", Channel::coil_voltage,
       [&](double t) { return on(t, 3e-3) ? 34 * std::sin(2 * pi * 60 * t) : 0.0; }},
      {"coil voltage with what the coil induces", Channel::coil_voltage, [&](double t) {
         return on(t) ? 325 * std::sin(2 * pi * 50 * t + 1) : t > 0 ? -80 * std::exp(-(t - 0.1) / 6e-3) : 0.0;
       }}};
  std::uint64_t seed = 1;
  for (const Invented& trace : traces)
    for (const double noise : {0.0, 0.003}) {
      INFO(trace.name << ", noise " << noise);
      const Suggestion found = suggested(trace, 1, 0, 0, noise, seed++);
      REQUIRE(found.channel);
      CHECK(info(*found.channel).name == info(trace.channel).name);
      CHECK(found.ground == Ground::shape);
    }
}

TEST_CASE("a sine of mains frequency is no force, also where the channels of the mains are taken",
          "[import][suggest]") {
  CsvTable t;
  t.header = {"time [s]", "Netz [V]", "U_coil [V]", "CH3 [V]", "CH4 [V]"};
  t.columns.resize(5);
  for (int i = 0; i < 4000; ++i) {
    const double s = -0.05 + i * 50e-6, v = 325 * std::sin(2 * pi * 50 * s);
    t.line.push_back(1);
    t.columns[0].push_back(s);
    for (int c = 1; c < 4; ++c) t.columns[static_cast<std::size_t>(c)].push_back(c == 2 && s < 0 ? 0 : v);
    t.columns[4].push_back(s < 0 || s > 0.12 ? 0.0 : v);
  }
  const Suggested found = suggest_columns(t);
  for (const std::size_t c : {2U, 3U}) {
    CHECK_FALSE(found.columns[c].channel);
    CHECK_THAT(found.columns[c].why, Contains("a sine of mains frequency: no force"));
  }
}

TEST_CASE("the time that the coil is on is suggested, from its voltage or its current", "[import][suggest]") {
  for (const Channel left : {Channel::coil_voltage, Channel::coil_current}) {
    Shown s = shown(4, true);
    for (std::size_t c = 1; c < s.truth.size(); ++c)
      if (s.truth[c] == Channel::coil_voltage && left != Channel::coil_voltage) {
        s.table.header.erase(s.table.header.begin() + static_cast<std::ptrdiff_t>(c));
        s.table.columns.erase(s.table.columns.begin() + static_cast<std::ptrdiff_t>(c));
      }
    const Suggested found = suggest_columns(s.table);
    REQUIRE(found.hold);
    // commanded 120 ms; a solid-state switch conducts on to the zero of the current, at most half a period
    CHECK(*found.hold > 0.117);
    CHECK(*found.hold < 0.131);
    const std::string text = suggested_file(s.table, found, "x.csv");
    CHECK_THAT(text, Contains(left == Channel::coil_voltage ? "# the coil voltage ends at "
                                                            : "# the coil current ends at "));
    CHECK(parse_calibration(text, "x.toml").hold_time == Approx(*found.hold).epsilon(1e-5));
  }
  const Shown closing = shown(4);
  const Suggested found = suggest_columns(closing.table);
  CHECK_FALSE(found.hold);
  CHECK_THAT(suggested_file(closing.table, found, "x.csv"), Contains("# hold_ms = "));
}

// `in s` was offered as a force, and the import of what was suggested found no time.
TEST_CASE("a time column of another name is found, and what rises is no channel", "[import][suggest]") {
  const Shown s = shown(45);
  const Suggested plain = suggest_columns(s.table);
  for (const char* title : {"in s", "Zeitachse [s]", "Abtastung [V]"}) {
    CsvTable t = s.table;
    t.header[0] = title;
    t.header.emplace_back("index [V]");
    t.columns.emplace_back();
    for (std::size_t i = 0; i < t.rows(); ++i) t.columns.back().push_back(static_cast<double>(i));
    const Suggested found = suggest_columns(t);
    INFO(title);
    CHECK(found.time == title);
    REQUIRE(found.columns.size() == plain.columns.size() + 1);
    for (std::size_t i = 0; i < plain.columns.size(); ++i)
      CHECK(found.columns[i].channel == plain.columns[i].channel);
    CHECK_FALSE(found.columns.back().channel);
    CHECK_THAT(found.columns.back().why, Contains("a time or a count, no channel"));
    const Calibration k = parse_calibration(suggested_file(t, found, "x.csv"), "x.toml");
    CHECK(k.columns[0] == (title[0] == 'A' ? "Abtastung [s]" : title));
    const auto columns = read_header(t.header, "x.csv", 1, true, k.columns);
    CHECK_FALSE(columns[0].channel);
    CHECK_FALSE(columns[0].passed_over);
  }
}

TEST_CASE("common names in German and English say which channel", "[import][suggest]") {
  const std::vector<std::pair<const char*, std::optional<Channel>>> names{
      {"Kraft [V]", Channel::pvdf_a},
      {"Kontaktkraft 2 [N]", Channel::pvdf_b},
      {"Spule [V]", Channel::coil_voltage},
      {"Spulenstrom [V]", Channel::coil_current},
      {"Kontakt [V]", Channel::contact_a},
      {"Hub [V]", Channel::laser},
      {"Netzspannung [V]", Channel::mains_voltage},
      {"accel [g]", std::nullopt}};
  const std::vector<std::pair<const char*, std::optional<Channel>>> english{
      {"contact force [V]", Channel::pvdf_a}, {"force right [V]", Channel::pvdf_b},
      {"coil [A]", Channel::coil_current},    {"coil [V]", Channel::coil_voltage},
      {"contact [V]", Channel::contact_a},    {"contact 2 [A]", std::nullopt}};
  for (const auto& list : {names, english}) {
    CsvTable t;
    t.header = {"in s"};
    t.columns.assign(list.size() + 1, std::vector<double>(100, 1.0));
    for (std::size_t i = 0; i < 100; ++i) t.columns[0][i] = 1e-3 * static_cast<double>(i);
    t.line.assign(100, 1);
    for (const auto& [title, channel] : list) t.header.emplace_back(title);
    const Suggested found = suggest_columns(t);
    REQUIRE(found.columns.size() == list.size());
    for (std::size_t i = 0; i < list.size(); ++i) {
      INFO(list[i].first);
      CHECK(found.columns[i].channel == list[i].second);
      if (list[i].second) CHECK(found.columns[i].ground == Ground::name);
    }
  }
}
