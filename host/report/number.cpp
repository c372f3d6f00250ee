#include "host/report/number.h"

#include <fmt/format.h>

#include <algorithm>
#include <array>
#include <cmath>
#include <utility>

#include "core/units.h"

namespace powbench::host {
namespace {

constexpr std::string_view minus = "\xE2\x88\x92";
constexpr std::string_view plus_minus = " \xC2\xB1 ";
constexpr std::string_view degree = "\xC2\xB0";

}  // namespace

std::string fixed(double value, int decimals) {
  if (!std::isfinite(value)) return std::string(no_value);
  std::string text = fmt::format("{:.{}f}", std::fabs(value), decimals);
  const bool zero = text.find_first_not_of("0.") == std::string::npos;
  return value < 0 && !zero ? std::string(minus) + text : text;
}

std::string signed_fixed(double value, int decimals) {
  const std::string text = fixed(value, decimals);
  const bool positive =
      value > 0 && std::isfinite(value) && text.find_first_not_of("0.") != std::string::npos;
  return positive ? "+" + text : text;
}

int decimals_for(double u, int fallback) {
  if (!(u > 0) || !std::isfinite(u)) return fallback;
  return std::clamp(1 - static_cast<int>(std::floor(std::log10(u))), 0, 4);
}

std::string with_uncertainty(const Measured& m, double coverage, double scale, int fallback_decimals) {
  const double expanded = coverage * m.u * scale;
  const int decimals = decimals_for(expanded, fallback_decimals);
  std::string text = fixed(m.value * scale, decimals);
  if (!m.known() || !std::isfinite(expanded)) return text;
  const std::string width = fixed(expanded, decimals);
  if (width.find_first_of("123456789") != std::string::npos) return text + std::string(plus_minus) + width;
  // too small for the digits shown: a zero would claim that it is exact
  if (m.value == 0) return "0";
  if (expanded > 0) return text + std::string(plus_minus) + "<" + fixed(std::pow(10.0, -decimals), decimals);
  return text;
}

ReadableUnit readable_unit(std::string_view si_unit) {
  if (si_unit == "s") return {"ms", 1e3, 2};
  if (si_unit == "A") return {"mA", 1e3, 0};
  if (si_unit == "m") return {"mm", 1e3, 2};
  if (si_unit == "N") return {"N", 1, 1};
  return {si_unit, 1, 2};
}

std::string angle_text(double radians) {
  if (!std::isfinite(radians)) return std::string(no_value);
  std::string text = fixed(degrees(radians), 2);
  text.resize(text.find_last_not_of('0') + 1);
  if (text.ends_with('.')) text.pop_back();
  if (text == "360") text = "0";
  return text + std::string(degree);
}

std::string at_angle(double radians) {
  return "at " + (std::isfinite(radians) ? angle_text(radians) : std::string("an angle not known"));
}

std::string range_of(double low, double high, int decimals) {
  const std::string from = fixed(low, decimals), to = fixed(high, decimals);
  return from == to ? from : from + " to " + to;
}

std::string short_hash(const std::string& hash) {
  return hash.empty() ? std::string(no_value) : hash.substr(0, 12);
}

std::string flags_text(std::uint32_t flags) {
  static constexpr std::array<std::pair<std::uint32_t, std::string_view>, 16> words{
      {{flag_clipped, "clipped"},
       {flag_gap, "lost samples"},
       {flag_edge, "filter edge"},
       {flag_poor_fit, "poor fit"},
       {flag_no_hum_fit, "hum not removed"},
       {flag_polarity, "film inverted"},
       {flag_contradiction, "force and contact voltage disagree"},
       {flag_ring_overlap, "core vibration overlaps"},
       {flag_no_calibration, "no valid calibration"},
       {flag_angle_off, "angle off"},
       {flag_gain, "gain implausible"},
       {flag_grazing, "opening not certain"},
       {flag_resolution, "later landing not certain"},
       {flag_switch_on, "time 0 is not the switch-on"},
       {flag_chatter, "chatters: settled not known"},
       {flag_beyond_fields, "fields extrapolated"}}};
  std::string text;
  for (const auto& [flag, word] : words) {
    if ((flags & flag) == 0) continue;
    if (!text.empty()) text += ", ";
    text += word;
  }
  return text;
}

}  // namespace powbench::host
