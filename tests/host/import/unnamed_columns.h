#pragma once

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <functional>
#include <numeric>
#include <vector>

#include "core/phase.h"
#include "core/random.h"
#include "host/import/suggest.h"
#include "rigs/simulated_record.h"

/// Columns whose channel is known, for what suggests it.

namespace powbench::test {

using host::CsvTable;
using host::Suggestion;

/// A closing of the simulated rig as a scope would show it: names CH1.., everything in volts, in an order and with
/// gains, signs and noise of a seed. `truth[c]`: channel of column c.
struct Shown {
  CsvTable table;
  std::vector<Channel> truth;
};

inline Shown shown(std::uint64_t seed, bool switched_off = false) {
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

/// What an invented trace is called, and its value `t` seconds after switch-on.
struct Invented {
  const char* name;
  Channel channel;
  std::function<double(double t)> at;
};

/// From rest at 4 ms to the stop at 12 ms as t^`power`, from 0 to 1.
inline double moves(double t, double power) {
  return t < 4e-3 ? 0.0 : std::min(1.0, std::pow((t - 4e-3) / 8e-3, power));
}

/// Rebounds from the stop: parabolas of half the height and time of the one before, the first `height`, 6 ms long.
inline double rebounds(double t, double height) {
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
inline double ac_current(double t, double hertz, double ratio, double settles) {
  if (t < 0) return 0;
  const double amplitude = t < 12e-3 ? ratio : 1 + (ratio - 1) * std::exp(-(t - 12e-3) / settles);
  const double phase = 2 * pi * hertz * t;
  return amplitude * (std::sin(phase) + 0.15 * std::sin(3 * phase));
}

/// Current of a DC coil, whose inductance doubles when the core arrives at 20 ms: it dips by `dip` and rises again.
inline double dc_current(double t, double dip) {
  if (t < 0) return 0;
  const double first = 1 - std::exp(-t / 10e-3);
  if (t < 20e-3) return first - dip * std::pow(t / 20e-3, 4);
  return 1 - (std::exp(-2.0) + dip) * std::exp(-(t - 20e-3) / 20e-3);
}

inline Suggestion suggested(const Invented& trace, double gain, double offset, double drift, double noise,
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

}  // namespace powbench::test
