#include "sim/magnetics/steel.h"

#include <algorithm>
#include <cmath>
#include <cstdio>
#include <stdexcept>

#include "sim/magnetics/circuit/magnetic_circuit.h"

namespace powbench::sim {
namespace {

constexpr double vacuum = 1 / mu0;

std::string text(double value) {
  char buffer[32];
  std::snprintf(buffer, sizeof buffer, "%.6g", value);
  return buffer;
}

[[noreturn]] void reject(const std::string& name, std::size_t row, const BhRow& r, const std::string& why) {
  throw std::invalid_argument("steel '" + name + "', row " + std::to_string(row + 1) + " (B = " + text(r.b) +
                              " T, H = " + text(r.h) + " A/m): " + why);
}

void check_rows(const std::string& name, const std::vector<BhRow>& rows) {
  for (std::size_t k = 0; k < rows.size(); ++k) {
    const bool first = k == 0;
    if (!std::isfinite(rows[k].b) || !std::isfinite(rows[k].h)) reject(name, k, rows[k], "not a number");
    if (first && (rows[k].b < 0 || rows[k].h < 0 || (rows[k].b == 0) != (rows[k].h == 0)))
      reject(name, k, rows[k], "B and H must be positive, or both zero in the first row");
    if (!first && rows[k].b <= rows[k - 1].b) reject(name, k, rows[k], "B must increase from row to row");
    if (!first && rows[k].h <= rows[k - 1].h) reject(name, k, rows[k], "H must increase from row to row");
  }
}

/// Chords, and the check that they rise at most as in vacuum and fall only on the way to the steepest permeability.
std::vector<double> chords(const std::string& name, const std::vector<BhRow>& rows, std::size_t added) {
  constexpr double kept = 0.6;  // share of a slope that rounding of published tables may leave
  constexpr double round_off = 1e-4;
  std::vector<double> slope;
  for (std::size_t k = 1; k < rows.size(); ++k) {
    slope.push_back((rows[k].h - rows[k - 1].h) / (rows[k].b - rows[k - 1].b));
    if (slope.back() > vacuum * (1 + round_off))
      reject(name, k - added, rows[k], "dH/dB is " + text(slope.back()) + ", above 1/mu0 = " + text(vacuum));
    slope.back() = std::min(slope.back(), vacuum);
  }
  const auto least = std::min_element(slope.begin(), slope.end());
  double steepest = *least;
  for (auto s = least; s != slope.end(); ++s) {
    const auto k = static_cast<std::size_t>(s - slope.begin()) + 1;
    if (*s < kept * steepest)
      reject(name, k - added, rows[k], "dH/dB falls after it has risen: noise in the data");
    steepest = std::max(steepest, *s);
  }
  double flattest = slope.front();
  for (auto s = slope.begin(); s != least; ++s) {
    const auto k = static_cast<std::size_t>(s - slope.begin()) + 1;
    if (*s > flattest / kept)
      reject(name, k - added, rows[k], "dH/dB rises and falls again: noise in the data");
    flattest = std::min(flattest, *s);
  }
  return slope;
}

/// Slopes at the rows: parabolas through three rows, kept where both H and B/mu0 - H stay monotone (Fritsch and
/// Carlson's square for both).
std::vector<double> knot_slopes(const std::vector<BhRow>& rows, const std::vector<double>& chord) {
  constexpr double limit = 2.9;
  const std::size_t n = rows.size();
  std::vector<double> slope(n);
  for (std::size_t k = 1; k + 1 < n; ++k) {
    const double left = rows[k].b - rows[k - 1].b;
    const double right = rows[k + 1].b - rows[k].b;
    slope[k] = (chord[k - 1] * right + chord[k] * left) / (left + right);
  }
  slope[n - 1] = 1.5 * chord[n - 2] - 0.5 * slope[n - 2];
  slope[0] = 1.5 * chord[0] - 0.5 * slope[1];  // H is odd: no curvature at the origin
  for (std::size_t k = 0; k < n; ++k) {
    const double a = chord[k == 0 ? 0 : k - 1];
    const double b = chord[k + 1 == n ? n - 2 : k];
    const double low = std::max({limit * std::max(a, b) - (limit - 1) * vacuum, 0.05 * std::min(a, b)});
    const double high = std::min(limit * std::min(a, b), vacuum);
    slope[k] = std::min(std::max(slope[k], low), high);
  }
  return slope;
}

/// Above the table, with x = H - H_e and the susceptibility k of the table's end: the law of Froehlich and Kennelly,
///   B = B_e + mu0 x + k x / (1 + x / h0),   dB/dH = mu0 + k / (1 + x / h0)^2,
/// whose magnetisation nears saturation as 1/H. h0 is such that the law meets the susceptibility of an earlier row,
/// too.
void append_tail(std::vector<Steel::Knot>& knots) {
  constexpr int pieces = 60;
  constexpr double reach = 60;    // in h0: 3e-4 of the susceptibility is left
  constexpr double far = 0.5;     // of H_e: so far below is the earlier row
  constexpr double fallen = 1.2;  // by this factor k falls from there, at least
  const auto e = knots.back();
  const double susceptibility = 1 / e.slope - mu0;
  if (susceptibility <= 1e-6 * mu0) {
    knots.back().slope = vacuum;
    return;
  }
  double h0 = e.h;
  for (auto k = knots.rbegin(); k != knots.rend(); ++k) {
    const double before = 1 / k->slope - mu0;
    if (e.h - k->h < far * e.h || before <= fallen * susceptibility) continue;
    const double root = std::sqrt(before / susceptibility);
    h0 = (e.h - k->h) * root / (root - 1);
    break;
  }
  h0 = std::clamp(h0, 0.5 * e.h, 4 * e.h);
  for (int k = 1; k <= pieces; ++k) {
    const double x = std::pow(reach + 1, static_cast<double>(k) / pieces) - 1;
    const double fade = k == pieces ? 0 : 1 / ((1 + x) * (1 + x));
    knots.push_back({e.b + mu0 * x * h0 + susceptibility * h0 * x / (1 + x), e.h + x * h0,
                     1 / (mu0 + susceptibility * fade), 0});
  }
}

}  // namespace

Steel::Steel(std::string name, std::vector<Knot> knots, double data_end, double last_slope)
    : name_(std::move(name)), knots_(std::move(knots)), data_end_(data_end), last_slope_(last_slope) {
  knots_.front().energy = 0;
  for (std::size_t k = 1; k < knots_.size(); ++k) {
    const auto& a = knots_[k - 1];
    auto& b = knots_[k];
    const double width = b.b - a.b;
    b.energy = a.energy + width * (0.5 * (a.h + b.h) + width * (a.slope - b.slope) / 12);
    const double inverse = 1 / width, chord = (b.h - a.h) * inverse;
    const double c2 = (3 * chord - 2 * a.slope - b.slope) * inverse;
    const double c3 = (a.slope + b.slope - 2 * chord) * inverse * inverse;
    pieces_.push_back({a.b, b.b, a.h, a.slope, c2, c3, a.energy, c2 / 3, c3 / 4});
  }
  constexpr double least_bins = 512;
  const double end = knots_.back().b;
  bins_per_tesla_ = least_bins / end;
  bin_.resize(static_cast<std::size_t>(least_bins) + 2);
  std::size_t k = 0;
  for (std::size_t bin = 0; bin < bin_.size(); ++bin) {
    while (k + 2 < knots_.size() && knots_[k + 1].b <= static_cast<double>(bin) / bins_per_tesla_) ++k;
    bin_[bin] = static_cast<int>(k);
  }
}

Steel Steel::table(std::string name, std::vector<BhRow> rows) {
  if (rows.size() < 3)
    throw std::invalid_argument("steel '" + name + "': " + std::to_string(rows.size()) +
                                " rows, at least 3 are needed");
  check_rows(name, rows);
  const bool add_origin = rows.front().b > 0;
  if (add_origin) rows.insert(rows.begin(), BhRow{});
  const auto chord = chords(name, rows, add_origin ? 1 : 0);
  const auto slope = knot_slopes(rows, chord);
  std::vector<Knot> knots;
  for (std::size_t k = 0; k < rows.size(); ++k) knots.push_back({rows[k].b, rows[k].h, slope[k], 0});
  append_tail(knots);
  return Steel(std::move(name), std::move(knots), rows.back().b, vacuum);
}

Steel Steel::law(std::string name, const std::function<double(double)>& h,
                 const std::function<double(double)>& dh_db) {
  constexpr double highest = 8;  // T
  constexpr int pieces = 512;
  double low = 0, high = highest;
  for (int k = 0; k < 200; ++k) (dh_db(0.5 * (low + high)) < vacuum ? low : high) = 0.5 * (low + high);
  const double end = 0.5 * (low + high);
  std::vector<Knot> knots;
  for (int k = 0; k <= pieces; ++k) {
    const double b = end * k / pieces;
    const double slope = dh_db(b);
    if (!(slope > 0) || !std::isfinite(h(b)))
      throw std::invalid_argument("steel '" + name + "': dH/dB = " + text(slope) + " at B = " + text(b) +
                                  " T, must be above 0");
    knots.push_back({b, h(b), std::min(slope, vacuum), 0});
  }
  const double last = knots.back().slope;
  return Steel(std::move(name), std::move(knots), end, last);
}

Steel Steel::power_law(double linear_part, double power, double exponent) {
  if (!(linear_part > 0) || !(power >= 0) || !(exponent > 1))
    throw std::invalid_argument("steel 'power': H = " + text(linear_part) + " B + " + text(power) + " B^" +
                                text(exponent) +
                                ": the linear part must be above 0, the power part not below 0, the "
                                "exponent above 1");
  return law(
      "power", [=](double b) { return linear_part * b + power * std::pow(b, exponent); },
      [=](double b) { return linear_part + power * exponent * std::pow(b, exponent - 1); });
}

Steel Steel::linear(double relative_permeability) {
  if (!(relative_permeability >= 1))
    throw std::invalid_argument("steel 'linear': relative permeability " + text(relative_permeability) +
                                ", must be at least 1");
  const double slope = vacuum / relative_permeability;
  return Steel("linear", {{0, 0, slope, 0}, {8, 8 * slope, slope, 0}}, 8, slope);
}

Steel Steel::stacked(double share) const {
  if (!(share > 0 && share <= 1))
    throw std::invalid_argument("stack_factor = " + text(share) + ", allowed above 0 up to 1");
  auto knots = knots_;
  for (auto& k : knots) {
    k.b = share * k.b + (1 - share) * mu0 * k.h;
    k.slope = 1 / (share / k.slope + (1 - share) * mu0);
  }
  const double end = share * data_end_ + (1 - share) * mu0 * h(data_end_);
  return Steel(name_, std::move(knots), end, 1 / (share / last_slope_ + (1 - share) * mu0));
}

SteelPoint Steel::at(double b) const {
  const auto& end = knots_.back();
  if (!(b < end.b)) {
    const double over = b - end.b;
    return {end.h + last_slope_ * over, last_slope_, end.energy + over * (end.h + 0.5 * last_slope_ * over)};
  }
  const Piece* p = pieces_.data() + bin_[static_cast<std::size_t>(b * bins_per_tesla_)];
  while (p->end <= b) ++p;
  const double t = b - p->b;
  return {p->h + t * (p->slope + t * (p->c2 + t * p->c3)), p->slope + t * (2 * p->c2 + 3 * t * p->c3),
          p->energy + t * (p->h + t * (p->slope / 2 + t * (p->third_c2 + t * p->quarter_c3)))};
}

double Steel::h(double b) const {
  return b < 0 ? -at(-b).h : at(b).h;
}

double Steel::dh_db(double b) const {
  return at(std::fabs(b)).dh_db;
}

double Steel::energy(double b) const {
  return at(std::fabs(b)).energy;
}

double Steel::peak_permeability() const {
  double peak = 1 / knots_.front().slope;
  for (std::size_t k = 1; k < knots_.size(); ++k) peak = std::max(peak, knots_[k].b / knots_[k].h);
  return peak / mu0;
}

}  // namespace powbench::sim
