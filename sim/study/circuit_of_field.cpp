#include "sim/study/circuit_of_field.h"

#include <algorithm>
#include <cmath>
#include <stdexcept>

#include "core/random.h"
#include "core/units.h"
#include "sim/specimen/specimen_potential.h"
#include "sim/study/least_squares.h"

namespace powbench::sim {
namespace {

constexpr int states_a_side = 12;
constexpr double least_share = 0.02;  ///< of the largest current or pull: what smaller ones are held against

struct FieldState {
  double psi = 0, gap = 0, current = 0, pull = 0;
};

/// The response without current in the ring, and the flux through it there.
std::pair<MagneticResponse, double> at_open_ring(const MagneticPotential& field, double psi, double gap,
                                                 double turns) {
  MagneticState s{psi, 0.5 * psi / turns, gap};
  MagneticResponse r = field.at(s);
  for (int pass = 0; field.has_ring() && pass < 60; ++pass) {
    const double step = r.ring_current / r.ring_ring;
    s.ring -= step;
    r = field.at(s);
    if (!(std::fabs(step) > 1e-12 * std::fabs(s.ring))) break;
  }
  return {r, s.ring};
}

/// One number that is sought, by its logarithm.
struct Sought {
  const char* key = "";
  double Magnet::*of_magnet = nullptr;  ///< nullptr: coil.leakage
  double low = 0, high = 0;
};

struct Problem {
  Specimen base;
  std::vector<Sought> numbers;
  std::vector<FieldState> states;
  double largest_current = 0, largest_pull = 0;

  Specimen at(std::span<const double> point) const {
    Specimen s = base;
    for (std::size_t k = 0; k < numbers.size(); ++k) {
      const double value = numbers[k].low * std::pow(numbers[k].high / numbers[k].low, point[k]);
      (numbers[k].of_magnet != nullptr ? s.magnet.*numbers[k].of_magnet : s.coil.leakage) = value;
    }
    return s;
  }

  /// Current and pull of each state in turn, as CircuitDeviation says.
  std::vector<double> residuals(const Specimen& s) const {
    const SpecimenPotential circuit(s);
    std::vector<double> out;
    for (const FieldState& f : states) {
      const MagneticResponse r = at_open_ring(circuit, f.psi, f.gap, s.coil.turns).first;
      out.push_back((r.current - f.current) / std::max(f.current, least_share * largest_current));
      out.push_back((r.pull - f.pull) / std::max(f.pull, least_share * largest_pull));
    }
    return out;
  }
};

double sum_of_squares(const std::vector<double>& r) {
  double sum = 0;
  for (const double x : r) sum += x * x;
  return std::isfinite(sum) ? sum : 1e300;
}

void take_states(Problem& p, const MagneticPotential& field, double largest_psi) {
  for (int g = 0; g < states_a_side; ++g) {
    const double share = static_cast<double>(g) / (states_a_side - 1);
    for (int k = 1; k <= states_a_side; ++k) {
      FieldState s{largest_psi * k / states_a_side, p.base.core.travel * share * share, 0, 0};
      const MagneticResponse r = at_open_ring(field, s.psi, s.gap, p.base.coil.turns).first;
      s.current = r.current, s.pull = r.pull;
      if (!(s.current > 0 && s.pull > 0))
        throw std::invalid_argument("the field has neither current nor pull at some of its states");
      p.largest_current = std::max(p.largest_current, s.current);
      p.largest_pull = std::max(p.largest_pull, s.pull);
      p.states.push_back(s);
    }
  }
}

/// Ring's part of the flux at the middle gap and half of the flux; what the leakage takes does not pass the poles.
double shaded_share(const Specimen& s, const MagneticPotential& field, double largest_psi) {
  if (!field.has_ring()) return 0;
  const double psi = 0.5 * largest_psi;
  const auto [r, ring] = at_open_ring(field, psi, 0.5 * s.core.travel, s.coil.turns);
  return std::clamp(ring * s.coil.turns / (psi - s.coil.leakage * r.current), 0.05, 0.95);
}

CircuitDeviation deviation(const std::vector<double>& r, std::size_t from, std::size_t to, double gap) {
  CircuitDeviation d{gap, 0, 0, 0, 0};
  for (std::size_t k = from; k < to; k += 2) {
    d.current_rms += r[k] * r[k], d.pull_rms += r[k + 1] * r[k + 1];
    d.current_worst = std::max(d.current_worst, std::fabs(r[k]));
    d.pull_worst = std::max(d.pull_worst, std::fabs(r[k + 1]));
  }
  const double n = static_cast<double>(to - from) / 2;
  d.current_rms = std::sqrt(d.current_rms / n), d.pull_rms = std::sqrt(d.pull_rms / n);
  return d;
}

}  // namespace

CircuitFit identify_circuit(const Specimen& s, const MagneticPotential& field, double largest_psi,
                            Team& team) {
  Problem p;
  p.base = s;
  p.base.lumped = true;
  p.base.magnet.shaded_share = 0;  // without current in the ring the poles are one
  take_states(p, field, largest_psi);
  const double area = largest_psi / s.coil.turns / 1.5;  // at 1.5 T
  const FieldState& open = p.states.back();
  p.numbers = {{"pole_area_mm2", &Magnet::pole_area, area / 10, area * 10},
               {"fringing", &Magnet::fringing, 1e-3, 10},
               {"leakage_H", nullptr, 1e-3 * open.psi / open.current, open.psi / open.current}};
  if (s.lumped && !s.magnet.steel.empty()) {
    p.numbers.push_back({"iron_length_mm", &Magnet::iron_length, 5e-3, 2});
  } else {
    p.base.magnet.steel.clear();
    p.numbers.insert(p.numbers.end(), {{"bh_linear_A_per_m_per_T", &Magnet::bh_linear, 1, 1e4},
                                       {"bh_power_A_per_m", &Magnet::bh_power, 1e-4, 1e4},
                                       {"bh_exponent", &Magnet::bh_exponent, 3, 30}});
  }
  const Residuals residuals = [&](std::span<const double> point) { return p.residuals(p.at(point)); };
  // the best of many points, refined from a few
  constexpr int tried = 2000, refined = 6;
  Random random(1);
  std::vector<std::pair<double, std::vector<double>>> starts;
  for (int k = 0; k < tried; ++k) {
    std::vector<double> point;
    for (std::size_t n = 0; n < p.numbers.size(); ++n) point.push_back(random.uniform());
    const double sum = sum_of_squares(residuals(point));
    starts.emplace_back(sum, std::move(point));
  }
  std::sort(starts.begin(), starts.end());
  RefineOptions o;
  o.iterations = 200;
  o.step = 1e-6;
  o.enough = 1e-9;
  Refined best;
  for (int k = 0; k < refined; ++k) {
    Refined r = refine(residuals, starts[static_cast<std::size_t>(k)].second, o, team);
    if (k == 0 || r.sum < best.sum) best = std::move(r);
  }
  CircuitFit out;
  out.specimen = p.at(best.point);
  const std::vector<double> r = p.residuals(out.specimen);
  out.specimen.magnet.shaded_share = shaded_share(out.specimen, field, largest_psi);
  constexpr double end = 1e-6;  // of the range
  for (std::size_t k = 0; k < p.numbers.size(); ++k)
    if (best.point[k] < end || best.point[k] > 1 - end) out.at_end.emplace_back(p.numbers[k].key);
  const std::size_t row = 2 * states_a_side;
  for (std::size_t g = 0; g < states_a_side; ++g)
    out.by_gap.push_back(deviation(r, g * row, (g + 1) * row, p.states[g * states_a_side].gap));
  out.all = deviation(r, 0, r.size(), 0);
  return out;
}

}  // namespace powbench::sim
