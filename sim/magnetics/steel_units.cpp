#include <algorithm>
#include <array>
#include <cmath>
#include <cstdio>

#include "sim/magnetics/circuit/magnetic_circuit.h"
#include "sim/magnetics/steel_rows.h"

namespace powbench::sim {
namespace {

constexpr double least_saturation = 0.2, most_saturation = 2.5;  // T: ferrite .. cobalt iron
constexpr double least_permeability = 50;                        // cast iron has about 300
constexpr double most_permeability = 1.5e5;                      // grain-oriented sheet has 0.4e5 .. 1e5
constexpr double most_nickel = 1e6;                              // nickel iron, which saturates below 1.3 T
constexpr double nickel_saturation = 1.3;                        // T
constexpr double high_field = 1.95, least_high_h = 100;          // T, A/m
constexpr double risen = 0.9;       // T: there the permeability has begun to fall
constexpr double blur = 0.02;       // of the largest B: below it is noise
constexpr double most_fall = 0.05;  // of the saturation

std::string unit_text(double value) {
  char buffer[32];
  std::snprintf(buffer, sizeof buffer, "%.4g", value);
  return buffer;
}

/// What is wrong with the rows, B times `b`, H times `h`; empty: nothing.
std::string wrong_with(const std::vector<BhRow>& rows, double b, double h) {
  double largest_j = -1e300, last_j = 0, last_h = -1, last = 0, peak = 0, first = 0, first_h = 1e300;
  double high_h = 1e300, peak_b = 0, at_h = 0;
  double largest_b = 0;
  for (const auto& r : rows) largest_b = std::max(largest_b, r.b);
  for (const auto& r : rows) {
    const double rb = r.b * b, rh = r.h * h;
    if (rh <= 0) continue;
    const double j = rb - mu0 * rh, permeability = rb / (mu0 * rh);
    if (j > largest_j) {
      largest_j = j;
      at_h = rh;
    }
    if (rh > last_h) {
      last_h = rh;
      last = permeability;
      last_j = j;
    }
    if (rh < first_h && r.b > blur * largest_b) {
      first_h = rh;
      first = permeability;
    }
    if (permeability > peak) {
      peak = permeability;
      peak_b = rb;
    }
    if (rb >= high_field) high_h = std::min(high_h, rh);
  }
  if (last_h < 0) return "";  // no row that says anything
  if (largest_j > most_saturation)
    return "B - mu0 H reaches " + unit_text(largest_j) + " T; iron saturates at 2.2 T, allowed up to " +
           unit_text(most_saturation) + " T";
  if (largest_j < least_saturation)
    return "B - mu0 H stays below " + unit_text(std::max(largest_j, 0.0)) + " T; allowed from " +
           unit_text(least_saturation) + " T on";
  if (peak < least_permeability)
    return "the largest B / (mu0 H) is " + unit_text(peak) + "; allowed from " +
           unit_text(least_permeability) + " on";
  const double most = largest_j > nickel_saturation ? most_permeability : most_nickel;
  if (peak > most)
    return "B / (mu0 H) reaches " + unit_text(peak) + " at " + unit_text(peak_b) + " T; allowed up to " +
           unit_text(most) + (most < most_nickel ? " for a material that saturates above 1.3 T" : "");
  if (high_h < least_high_h)
    return "H is only " + unit_text(high_h) + " A/m at " + unit_text(high_field) + " T; allowed from " +
           unit_text(least_high_h) + " A/m on";
  if (first < 1) return "the first B / (mu0 H) is " + unit_text(first) + ", below that of vacuum";
  if (last >= peak && last_j > risen)
    return "B / (mu0 H) still rises at the last row, " + unit_text(last_j) + " T; it falls from about 1 T on";
  if (largest_j - last_j > most_fall * largest_j)
    return "B - mu0 H falls from " + unit_text(largest_j) + " T at " + unit_text(at_h) + " A/m to " +
           unit_text(last_j) + " T at " + unit_text(last_h) + " A/m, and saturation does not fall";
  return "";
}

struct UnitFactor {
  const char* name;
  double factor;
};

}  // namespace

std::string doubt_units(const std::vector<BhRow>& rows, double b_unit, double h_unit) {
  const std::string wrong = wrong_with(rows, 1, 1);
  if (wrong.empty()) return "";
  constexpr std::array b_units{UnitFactor{"T", 1}, UnitFactor{"G", 1e-4}, UnitFactor{"mT", 1e-3},
                               UnitFactor{"kG", 0.1}};
  constexpr std::array h_units{UnitFactor{"A/m", 1}, UnitFactor{"kA/m", 1e3},
                               UnitFactor{"Oe", 1e3 / (4 * pi)}, UnitFactor{"A/cm", 100}};
  std::string fits;
  const auto look = [&](const std::vector<BhRow>& r, double b, double h, const std::string& words) {
    if (wrong_with(r, b, h).empty()) fits += (fits.empty() ? "" : ", or ") + words;
  };
  for (const auto& u : b_units)
    if (u.factor != b_unit) look(rows, u.factor / b_unit, 1, std::string("B in ") + u.name);
  for (const auto& u : h_units)
    if (u.factor != h_unit) look(rows, 1, u.factor / h_unit, std::string("H in ") + u.name);
  auto swapped = rows, polarised = rows;
  for (auto& r : swapped) std::swap(r.b, r.h);
  for (auto& r : polarised) r.b += mu0 * r.h;
  look(swapped, 1, 1, "the columns swapped");
  if (fits.empty()) look(polarised, 1, 1, "the polarisation, a column J (T)");
  if (fits.empty())
    for (const auto& b : b_units)
      for (const auto& h : h_units)
        look(rows, b.factor / b_unit, h.factor / h_unit,
             std::string("B in ") + b.name + " with H in " + h.name);
  return wrong + (fits.empty() ? "" : "; the numbers would fit " + fits);
}

std::string weak_rows(const std::vector<BhRow>& rows, const Steel& curve) {
  constexpr double little = 1000, strong = 3e5, below_knee = 0.5;  // -, A/m, of the largest permeability
  double last_h = 0, last_b = 0;
  for (const auto& r : rows)
    if (r.h > last_h) {
      last_h = r.h;
      last_b = r.b;
    }
  const double peak = curve.peak_permeability();
  if (last_b / (mu0 * last_h) > below_knee * peak)
    return "the rows end at " + unit_text(last_b) + " T, below the knee: saturation is a guess";
  if (last_h > strong)
    return "H goes up to " + unit_text(last_h) +
           " A/m; few sheets are measured beyond 300 000: is the unit right?";
  if (peak < little)
    return "the largest B / (mu0 H) is " + unit_text(peak) +
           "; sheet and soft iron have some thousands: is the unit right?";
  return "";
}

}  // namespace powbench::sim
