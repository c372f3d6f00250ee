#include "host/config/unit.h"

#include <array>
#include <charconv>
#include <cmath>
#include <cstdio>
#include <cstdlib>

#include "core/units.h"

namespace powbench::host {
namespace {

constexpr Unit plain{"", ""};

constexpr std::array units{
    // length, area, time, angle
    Unit{"m", "m"},
    Unit{"mm", "mm", -3},
    Unit{"um", "um", -6},
    Unit{"mm2", "mm2", -6},
    Unit{"s", "s"},
    Unit{"ms", "ms", -3},
    Unit{"us", "us", -6},
    Unit{"hertz", "Hz"},
    Unit{"Hz", "Hz"},
    Unit{"khz", "kHz", 3},
    Unit{"deg", "deg", 0, pi / 180.0},
    Unit{"m_per_s", "m/s"},
    Unit{"m_per_s2", "m/s2"},
    Unit{"um_per_count", "um per count", -6},
    // mechanics
    Unit{"g", "g", -3},
    Unit{"kg", "kg"},
    Unit{"N", "N"},
    Unit{"mN", "mN", -3},
    Unit{"N_per_m", "N/m"},
    Unit{"N_per_N", "N/N"},
    Unit{"g_mm2", "g mm2", -9},
    // electricity and magnetism
    Unit{"V", "V"},
    Unit{"mV", "mV", -3},
    Unit{"volts", "V"},
    Unit{"A", "A"},
    Unit{"mA", "mA", -3},
    Unit{"ohm", "ohm"},
    Unit{"uohm", "uohm", -6},
    Unit{"H", "H"},
    Unit{"mH", "mH", -3},
    Unit{"uH", "uH", -6},
    Unit{"uF", "uF", -6},
    Unit{"A_per_m", "A/m"},
    Unit{"S_per_m", "S/m"},
    Unit{"T", "T"},
    Unit{"A_per_m_per_T", "A/(m T)"},
    Unit{"pC_per_N", "pC/N", -12},
    Unit{"N_per_V", "N/V"},
    Unit{"mm_per_V", "mm/V", -3},
    Unit{"A_per_V", "A/V"},
    Unit{"V_per_V", "V/V"},
    // temperature and ratios
    Unit{"degC", "degC", 0, 1.0, zero_celsius},
    Unit{"K", "K"},
    Unit{"per_K", "1/K"},
    Unit{"percent", "%", -2},
};

/// value * 10^shift, correctly rounded: the shift is done in the decimal text.
double shift_decimal(double value, int shift) {
  if (shift == 0 || value == 0.0 || !std::isfinite(value)) return value;
  std::array<char, 64> text{};
  char* end = std::to_chars(text.data(), text.data() + 40, value, std::chars_format::scientific).ptr;
  char* exponent = end;
  while (*exponent != 'e') --exponent;
  const int shifted = std::atoi(exponent + 1) + shift;
  end = std::to_chars(exponent + 1, text.data() + text.size(), shifted).ptr;
  double result = 0.0;
  std::from_chars(text.data(), end, result);
  return result;
}

}  // namespace

const Unit& unit_of_key(std::string_view key) {
  const Unit* best = &plain;
  for (const Unit& u : units) {
    const bool whole = key == u.suffix;
    const bool suffix = key.size() > u.suffix.size() + 1 && key.ends_with(u.suffix) &&
                        key[key.size() - u.suffix.size() - 1] == '_';
    if ((whole || suffix) && u.suffix.size() > best->suffix.size()) best = &u;
  }
  return *best;
}

double to_si(double value, const Unit& unit) {
  return shift_decimal(value * unit.factor, unit.decimal) + unit.offset;
}

std::string number_text(double value) {
  if (std::isnan(value)) return "nan";
  if (std::isinf(value)) return value < 0 ? "-inf" : "inf";
  std::array<char, 40> text{};
  const double size = std::fabs(value);
  const bool plain_digits = size == 0.0 || (size >= 1e-5 && size < 1e15);
  char* const end = std::to_chars(text.data(), text.data() + text.size(), value,
                                  plain_digits ? std::chars_format::fixed : std::chars_format::scientific)
                        .ptr;
  return std::string(text.data(), end);
}

std::string from_si(double si, const Unit& unit) {
  const double value = shift_decimal(si - unit.offset, -unit.decimal) / unit.factor;
  for (int digits = 1; digits <= 17; ++digits) {
    std::array<char, 40> text{};
    std::snprintf(text.data(), text.size(), "%.*g", digits, value);
    const double candidate = std::strtod(text.data(), nullptr);
    if (to_si(candidate, unit) == si) return number_text(candidate);
  }
  double low = value, high = value;
  for (int step = 0; step < 8; ++step) {
    low = std::nextafter(low, -HUGE_VAL);
    high = std::nextafter(high, HUGE_VAL);
    if (to_si(low, unit) == si) return number_text(low);
    if (to_si(high, unit) == si) return number_text(high);
  }
  return number_text(value);
}

}  // namespace powbench::host
