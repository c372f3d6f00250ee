#include "host/import/suggest.h"

#include <fmt/format.h>

#include <catch2/catch.hpp>
#include <functional>
#include <numeric>

#include "core/random.h"
#include "host/import/calibration.h"
#include "host/import/waveform.h"
#include "rigs/simulated_record.h"

using namespace powbench;
using namespace powbench::host;
using Catch::Matchers::Contains;

namespace {

/// A closing of the simulated rig as a scope would show it: names CH1.., everything in volts, in an order and with
/// gains, signs and noise of a seed. `truth[c]`: channel of column c.
struct Shown {
  CsvTable table;
  std::vector<Channel> truth;
};

Shown shown(std::uint64_t seed, bool switched_off = false) {
  Random random(seed);
  Conditions c;
  c.closing_angle = radians(360 * random.uniform());
  c.mains_hertz = seed % 3 == 0 ? 60.0 : 50.0;
  c.supply_volts = 200 + 60 * random.uniform();
  rigs::SimRigConfig rig;
  if (switched_off) {
    rig.pretrigger = 0.02 + 0.005 * static_cast<double>(seed % 5);
    rig.record_length = rig.pretrigger + 0.16 + 0.01 * static_cast<double>(seed % 7);
    c.hold_time = 0.1 + 0.005 * static_cast<double>(seed % 9);
  }
  const Record r = rigs::simulate_record({}, c, rig).record;
  std::vector<std::size_t> order(r.channels.size());
  std::iota(order.begin(), order.end(), std::size_t{0});
  for (std::size_t i = order.size(); i > 1; --i) std::swap(order[i - 1], order[random.below(i)]);
  Shown s;
  s.table.header = {"time [s]"};
  s.table.columns.emplace_back();
  s.truth.push_back(Channel::aux);
  for (std::size_t i = 0; i < r.samples(); ++i)
    s.table.columns[0].push_back(r.time(i)), s.table.line.push_back(1);
  for (const std::size_t k : order) {
    const ChannelRecord& from = r.channels[k];
    const std::string_view unit = info(from.channel).unit;
    const double gain = unit == "V" ? 1.0
                                    : (unit == "m" ? 1000.0 : 0.1) * (0.3 + random.uniform()) *
                                          (random.below(4) == 0 ? -1 : 1);
    double largest = 0;
    for (std::size_t i = 0; i < r.samples(); ++i) largest = std::max(largest, std::abs(from.value(i) * gain));
    const double noise = largest * 0.01 * random.uniform();
    s.table.header.push_back(fmt::format("CH{} [V]", s.table.header.size()));
    s.truth.push_back(from.channel);
    s.table.columns.emplace_back();
    for (std::size_t i = 0; i < r.samples(); ++i)
      s.table.columns.back().push_back(from.value(i) * gain + noise * random.normal());
  }
  return s;
}

}  // namespace

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

namespace {

/// What an invented trace is called, and its value `t` seconds after switch-on.
struct Invented {
  const char* name;
  Channel channel;
  std::function<double(double t)> at;
};

/// From rest at 4 ms to the stop at 12 ms as t^`power`, from 0 to 1.
double moves(double t, double power) {
  return t < 4e-3 ? 0.0 : std::min(1.0, std::pow((t - 4e-3) / 8e-3, power));
}

/// Rebounds from the stop: parabolas of half the height and time of the one before, the first `height`, 6 ms long.
double rebounds(double t, double height) {
  double from = 12e-3, length = 6e-3;
  for (int k = 0; k < 6; ++k) {
    if (t > from && t < from + length) {
      const double u = (t - from) / length;
      return 4 * height * u * (1 - u);
    }
    from += length, length /= 2, height /= 2;
  }
  return 0;
}

/// Current of an AC coil of amplitude 1: `ratio` as much until the core arrives, then less within `settles`.
double ac_current(double t, double hertz, double ratio, double settles) {
  if (t < 0) return 0;
  const double amplitude = t < 12e-3 ? ratio : 1 + (ratio - 1) * std::exp(-(t - 12e-3) / settles);
  const double phase = 2 * pi * hertz * t;
  return amplitude * (std::sin(phase) + 0.15 * std::sin(3 * phase));
}

/// Current of a DC coil, whose inductance doubles when the core arrives at 20 ms: it dips by `dip` and rises again.
double dc_current(double t, double dip) {
  if (t < 0) return 0;
  const double first = 1 - std::exp(-t / 10e-3);
  if (t < 20e-3) return first - dip * std::pow(t / 20e-3, 4);
  return 1 - (std::exp(-2.0) + dip) * std::exp(-(t - 20e-3) / 20e-3);
}

Suggestion suggested(const Invented& trace, double gain, double offset, double drift, double noise,
                     std::uint64_t seed) {
  Random random(seed);
  CsvTable t;
  t.header = {"time [s]", "CH1 [V]"};
  t.columns.resize(2);
  for (int i = 0; i < 4000; ++i) {
    const double s = -0.05 + i * 50e-6;
    t.columns[0].push_back(s), t.line.push_back(1);
    t.columns[1].push_back(gain * (trace.at(s) + drift * s / 0.2 + noise * random.normal()) + offset);
  }
  return suggest_columns(t).columns.at(0);
}

}  // namespace

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
