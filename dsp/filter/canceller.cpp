#include "dsp/filter/canceller.h"

#include <Eigen/Dense>

#include <algorithm>
#include <cmath>
#include <stdexcept>

#include "dsp/filter/sos.h"

namespace powbench::dsp {

namespace {

using Eigen::Index;

void check(const Signal& force, const Signal& reference, const CancelOptions& o) {
  if (o.taps < 1 || o.taps > 1024)
    throw std::invalid_argument("taps = " + std::to_string(o.taps) + ": allowed 1 .. 1024");
  if (force.empty() || force.size() != reference.size() || force.dt != reference.dt)
    throw std::invalid_argument("reference: allowed the force's rate and length");
  if (!(std::abs(force.t0 - reference.t0) <= 0.5 * force.dt))
    throw std::invalid_argument("reference: allowed the force's time axis to half a sample");
  if (!(o.from < o.to) || !(o.from >= force.t0) || !(o.to <= force.end()))
    throw std::invalid_argument("from = " + std::to_string(o.from) + ", to = " + std::to_string(o.to) +
                                ": allowed a window inside the record");
}

/// High-passed copy; shorter records than the filter's memory stay as they are, less their mean.
std::vector<double> above(const Signal& s, double hertz) {
  Signal copy = s;
  bridge_gaps(copy);
  if (hertz <= 0 || hertz >= s.rate() / 2) return copy.value;
  return filter_zero_phase(to_sections({FilterKind::high, 2, hertz, 0, s.rate(), true}), copy).signal.value;
}

struct Window {
  std::size_t first = 0, last = 0;  ///< samples n with the whole FIR inside the record
};

/// Normal equations over the window's good samples; R(i, j) = sum r[n + h - i] r[n + h - j].
struct Normal {
  Eigen::MatrixXd R;
  Eigen::VectorXd b;
  double power = 0;
  std::size_t used = 0;
};

Normal normal_equations(const std::vector<double>& f, const std::vector<double>& r, const Signal& force,
                        const Signal& reference, Window w, std::size_t taps) {
  const auto m = static_cast<Index>(taps);
  Normal out{Eigen::MatrixXd::Zero(m, m), Eigen::VectorXd::Zero(m), 0, 0};
  Eigen::VectorXd row(m);
  constexpr std::uint8_t bad = mask_clipped | mask_gap;
  for (std::size_t n = w.first; n < w.last; ++n) {
    if ((force.masked[n] | reference.masked[n]) & bad) continue;
    for (Index k = 0; k < m; ++k) row[k] = r[n + taps / 2 - static_cast<std::size_t>(k)];
    out.b += f[n] * row;
    out.power += f[n] * f[n];
    out.R.selfadjointView<Eigen::Lower>().rankUpdate(row);
    ++out.used;
  }
  return out;
}

Cancelled refuse(const Signal& force, std::string reason) {
  Cancelled out;
  out.force = force;
  out.refused = true;
  out.reason = std::move(reason);
  return out;
}

}  // namespace

Cancelled cancel_reference(const Signal& force, const Signal& reference, const CancelOptions& o) {
  check(force, reference, o);
  const std::size_t ahead = o.taps / 2, behind = o.taps - 1 - ahead;
  Window w{std::max(force.index_at(o.from), behind),
           std::min(force.index_at(o.to), force.size() - std::min(force.size(), ahead))};
  const auto f = above(force, o.low_hertz), r = above(reference, o.low_hertz);
  if (w.last <= w.first || w.last - w.first < 4 * o.taps)
    return refuse(force, "the window has fewer than four samples a tap");
  Normal eq = normal_equations(f, r, force, reference, w, o.taps);
  if (eq.used < 4 * o.taps) return refuse(force, "too few samples of the window are valid");
  const double scale = eq.R.trace() / static_cast<double>(o.taps);
  if (!(scale > 0) || !(eq.power > 0)) return refuse(force, "the reference or the force is silent");
  // A band-limited reference leaves directions without signal; they get no weight.
  eq.R.diagonal().array() += 1e-9 * scale;
  const Eigen::VectorXd h = eq.R.selfadjointView<Eigen::Lower>().ldlt().solve(eq.b);
  const double raw = std::clamp(h.dot(eq.b) / eq.power, 0.0, 1.0);
  const double chance = static_cast<double>(o.taps) / static_cast<double>(eq.used);
  Cancelled out;
  out.explained = std::clamp((raw - chance) / (1 - chance), 0.0, 1.0);
  if (out.explained < o.least_explained) {
    const double explained = out.explained;
    out =
        refuse(force, "the reference explains " + std::to_string(explained) + " of the force's power above " +
                          std::to_string(o.low_hertz) + " Hz, needed " + std::to_string(o.least_explained));
    out.explained = explained;
    return out;
  }
  out.taps.assign(h.data(), h.data() + h.size());
  out.force = force;
  for (std::size_t n = w.first; n < w.last; ++n) {
    double sum = 0;
    for (std::size_t k = 0; k < o.taps; ++k) sum += out.taps[k] * r[n + ahead - k];
    out.force.value[n] -= sum;
  }
  return out;
}

}  // namespace powbench::dsp
