#include "sim/specimen/validate.h"

#include <algorithm>
#include <cmath>
#include <cstdio>
#include <stdexcept>

#include "sim/magnetics/plane/core_mesh.h"
#include "sim/specimen/specimen_fields.h"

namespace powbench::sim {
namespace {

std::string text(double value) {
  char buffer[32];
  std::snprintf(buffer, sizeof buffer, "%.6g", value);
  return buffer;
}

/// The overtravel of every break of every pole must be positive, and its gap too.
void check_gaps(const Specimen& s, std::vector<SpecimenError>& errors) {
  constexpr double milli = 1e-3;
  const auto& b = s.bridges;
  for (const double wider : {0.0, (std::max(b.poles, 1) - 1) * b.gap_spread})
    for (const double tilted : {0.0, b.tilt_gap}) {
      const double gap = b.gap + wider + tilted;
      if (gap > 0 && gap < s.core.travel) continue;
      errors.push_back({"bridges.gap_mm", text(gap / milli),
                        "above 0, below " + text(s.core.travel / milli) +
                            " (core.travel_mm) at every break, tilt_gap_mm and gap_spread_mm included"});
      return;
    }
}

/// Between 1, 1.5 and 2 there is no law.
void check_exponent(const char* key, double n, std::vector<SpecimenError>& errors) {
  if (n >= 1 && n <= 2 && n != 1 && n != 1.5 && n != 2) errors.push_back({key, text(n), "1, 1.5 and 2"});
}

}  // namespace

std::vector<SpecimenError> validate(const Specimen& s) {
  std::vector<SpecimenError> errors;
  for (const auto& f : specimen_fields()) {
    const double shown = f.get(s) / f.si_per_unit;
    constexpr double round_off = 1e-12;  // of the division by the unit
    if (shown >= f.low - round_off * std::fabs(f.low) && shown <= f.high + round_off * std::fabs(f.high))
      continue;
    errors.push_back({std::string(f.section) + '.' + std::string(f.key), text(shown),
                      text(f.low) + " .. " + text(f.high)});
  }
  check_gaps(s, errors);
  check_exponent("core.stop_exponent", s.core.stop_exponent, errors);
  check_exponent("bridges.contact_exponent", s.bridges.contact_exponent, errors);
  if (errors.empty())
    for (const auto& e : shape_errors(s.shape)) errors.push_back({e.key, e.value, e.range});
  return errors;
}

void require_valid(const Specimen& s) {
  const auto errors = validate(s);
  if (errors.empty()) return;
  std::string all = "specimen '" + s.name + "':";
  for (const auto& e : errors) all += "\n  " + e.key + " = " + e.value + ", allowed " + e.range;
  throw std::invalid_argument(all);
}

}  // namespace powbench::sim
