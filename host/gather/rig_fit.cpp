#include <fmt/format.h>

#include <cmath>
#include <optional>
#include <string>

#include "host/config/bad_input.h"
#include "host/config/unit.h"
#include "host/gather/scene.h"
#include "rigs/sim_world.h"

/// What a rig file may say and the rig's program would still not take: its key, with the range that fits all the rest.

namespace powbench::host {
namespace {

/// A number of the rig file on which a complaint of the rig's program depends.
struct Suspect {
  std::string_view word;  ///< in the complaint
  std::string_view key;
  double rigs::SensorConfig::*value;
  double per_si;     ///< of the file's unit
  double low, high;  ///< that the file takes, in its unit
};
constexpr Suspect suspects[] = {
    {"current", "[electrical] current_full_scale_A", &rigs::SensorConfig::current_full_scale, 1, 1e-3, 1000},
    {"mains_lost", "[electrical] voltage_full_scale_V", &rigs::SensorConfig::voltage_full_scale, 1, 1,
     10'000},
    {"amplitude", "[electrical] voltage_full_scale_V", &rigs::SensorConfig::voltage_full_scale, 1, 1, 10'000},
    {"contact_open_counts", "[electrical] contact_full_scale_V", &rigs::SensorConfig::contact_full_scale, 1,
     0.1, 1000},
    {"laser", "[laser] scale_um_per_count", &rigs::SensorConfig::laser_scale, 1e6, 1e-4, 100},
};

/// The values that the program takes, all else as it is: "a .. b" in the file's unit, to four digits inwards; empty
/// where there are none.
std::string range_of(rigs::SimRigConfig config, const Suspect& s) {
  const auto fits = [&](double value) {
    config.sensors.*s.value = value / s.per_si;
    return rigs::rig_config_error(config).empty();
  };
  constexpr int steps = 400;
  const double ratio = std::pow(s.high / s.low, 1.0 / steps);
  std::optional<double> first, last;
  for (int k = 0; k <= steps; ++k) {
    const double value = k == steps ? s.high : s.low * std::pow(ratio, k);
    if (!fits(value)) continue;
    if (!first) first = value;
    last = value;
  }
  if (!first) return {};
  const auto edge = [&](double good, double bad) {
    for (int k = 0; k < 50; ++k) (fits(std::sqrt(good * bad)) ? good : bad) = std::sqrt(good * bad);
    return good;
  };
  const auto digits = [](double value, bool up) {
    const double unit = std::pow(10.0, std::floor(std::log10(value)) - 3);
    return number_text((up ? std::ceil(value / unit * (1 - 1e-12)) : std::floor(value / unit * (1 + 1e-12))) *
                       unit);
  };
  const double from = *first > s.low ? edge(*first, *first / ratio) : *first;
  const double to = *last < s.high ? edge(*last, *last * ratio) : *last;
  return digits(from, true) + " .. " + digits(to, false);
}

}  // namespace

void refuse_unfit(const RigFile& rig, const std::string& file) {
  const std::string why(rigs::rig_config_error(rig.config));
  if (why.empty()) return;
  std::string see;
  if (why.find("sample") != std::string::npos) see = "sample_rate_hertz, allowed whole numbers";
  for (const Suspect& s : suspects) {
    if (!see.empty() || why.find(s.word) == std::string::npos) continue;
    const std::string range = range_of(rig.config, s);
    see = fmt::format("{} = {}{}", s.key, number_text(rig.config.sensors.*s.value * s.per_si),
                      range.empty() ? "" : ", allowed " + range);
  }
  throw BadInput({fmt::format("{}: the rig's program would refuse this configuration: {}{}{}", file, why,
                              see.empty() ? "" : "; see ", see)});
}

}  // namespace powbench::host
