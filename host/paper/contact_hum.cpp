#include "host/paper/contact_hum.h"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <complex>

#include "core/units.h"
#include "host/paper/contact_pressure.h"
#include "sim/models/closing.h"

namespace powbench::host {
namespace {

HumLine hum_line(const std::string& what, const sim::Specimen& s) {
  constexpr double hold = 0.4, hertz = 50;  // s, Hz: four times the usual hold, the offset flux has died out
  Conditions c = pressure_conditions(0);
  c.hold_time = hold;
  const auto r = sim::simulate(s, c, hold, pressure_sample_dt);
  double low = 1e300, high = 0, shortest = 1e300, longest = 0, count = 0;
  std::complex<double> sway = 0;
  for (const auto& p : r.samples) {
    if (p.time <= hold - 1 / hertz) continue;
    const double over = p.travel - p.base;
    low = std::min(low, p.pull), high = std::max(high, p.pull);
    shortest = std::min(shortest, over), longest = std::max(longest, over);
    sway += std::polar(over, 4 * pi * hertz * p.time);
    ++count;
  }
  std::size_t lifts = 0;
  for (const auto& e : r.events)
    lifts += e.kind == sim::PlantEvent::Kind::core_release && e.time > hold - 0.1;
  const auto train = pressure_train(r.samples, false, hertz);
  return {what,         low,
          high,         1e6 * (longest - shortest),
          train.second, 0.5 * s.bridges.rate * 2 * std::abs(sway) / count,
          lifts};
}

}  // namespace

std::vector<HumLine> hum_lines(const sim::Specimen& s) {
  std::vector<HumLine> lines{hum_line("as it is", s)};
  for (const double stiffness : {1e7, 3e6, 1e6}) {
    auto soft = s;
    soft.core.stop_stiffness = stiffness;
    lines.push_back(hum_line(fmt::format("faces of {:.0e} N/m", stiffness), soft));
  }
  auto weak = s;
  weak.magnet.ring_resistance *= 2;
  lines.push_back(hum_line("ring of twice the resistance", weak));
  return lines;
}

}  // namespace powbench::host
