#include "sim/magnetics/plane/newton_four.h"

#include <algorithm>
#include <cmath>
#include <limits>

namespace powbench::sim {
namespace {

constexpr std::size_t four = 4;

/// Four vectors side by side.
template <class Source>
void interleave(std::vector<Four>& out, std::size_t size, const Source& source) {
  out.resize(size);
  for (std::size_t p = 0; p < four; ++p) {
    const double* const from = source(p);
    for (std::size_t k = 0; k < size; ++k) out[k].of[p] = from[k];
  }
}

std::vector<double> one_of(const std::vector<Four>& all, std::size_t problem) {
  std::vector<double> out(all.size());
  for (std::size_t k = 0; k < all.size(); ++k) out[k] = all[k].of[problem];
  return out;
}

}  // namespace

FourSteelPoint steel_points(const Steel& steel, const Four& b) {
  FourSteelPoint out;
  for (std::size_t p = 0; p < four; ++p) {
    const SteelPoint point = steel.at(b.of[p]);
    out.h.of[p] = point.h;
    out.dh_db.of[p] = point.dh_db;
    out.energy.of[p] = point.energy;
  }
  return out;
}

struct NewtonFour::Step {
  std::vector<Four> da;
  std::vector<Four> di;  ///< by winding; 0 where the current is given
  Four miss{};           ///< as Newton's
};

NewtonFour::NewtonFour(const std::array<const FieldProblem*, 4>& problems)
    : problems_(problems), cholesky_(problems[0]->space().pattern) {
  const FieldProblem& first = *problems[0];
  const auto quadrature = first.steel_quadrature();
  const auto nodes = static_cast<std::size_t>(first.space().nodes);
  for (const auto& e : quadrature.elements) {
    const int* const u = first.space().unknowns(e.triangle);
    unknowns_.insert(unknowns_.end(), u, u + nodes);
    const int* const to = element_positions(first.space(), e.triangle);
    positions_.insert(positions_.end(), to, to + nodes * (nodes + 1) / 2);
  }
  steel_.nodes = first.space().nodes;
  steel_.points = quadrature.points;
  steel_.elements = quadrature.elements.size();
  steel_.unknowns = unknowns_.data();
  steel_.positions = positions_.data();
  take_steels();
  gradient_.resize(static_cast<std::size_t>(first.size()) + 1);
  cholesky_.set_changing(first.steel_unknowns());
  take_places();
}

void NewtonFour::take_steels() {
  steels_.clear();
  for (const auto& e : problems_[0]->steel_quadrature().elements)
    steels_.push_back(&problems_[0]->setup().steels[static_cast<std::size_t>(e.steel)]);
  steel_.steels = steels_.data();
}

void NewtonFour::take_places() {
  const auto nodes = static_cast<std::size_t>(steel_.nodes);
  const auto lanes = static_cast<std::size_t>(problems_[0]->space().lanes);
  const std::size_t points = steel_.elements * static_cast<std::size_t>(steel_.points);
  curls_.resize(points * 2 * nodes);
  for (std::size_t p = 0; p < four; ++p) {
    const auto& from = problems_[p]->steel_quadrature().curls;
    for (std::size_t q = 0; q < 2 * points; ++q)
      for (std::size_t n = 0; n < nodes; ++n) curls_[q * nodes + n].of[p] = from[q * lanes + n];
  }
  interleave(weights_, points,
             [&](std::size_t p) { return problems_[p]->steel_quadrature().weights.data(); });
  interleave(linear_, problems_[0]->linear().size(),
             [&](std::size_t p) { return problems_[p]->linear().data(); });
  windings_.resize(problems_[0]->setup().windings.size());
  for (std::size_t w = 0; w < windings_.size(); ++w)
    interleave(windings_[w], gradient_.size(),
               [&](std::size_t p) { return problems_[p]->winding(w).data(); });
  air_factored_ = false;
  steel_.curls = curls_.data();
  steel_.weights = weights_.data();
}

Four NewtonFour::dot(const std::vector<Four>& a, const std::vector<Four>& b) const {
  Four sum{};
  for (std::size_t k = 0; k < a.size(); ++k)
    for (std::size_t p = 0; p < four; ++p) sum.of[p] += a[k].of[p] * b[k].of[p];
  return sum;
}

void NewtonFour::evaluate(bool hessian) {
  const FourKernel& kernel = best_four_kernel();
  const Pattern& pattern = problems_[0]->space().pattern;
  kernel.multiply(pattern.size, pattern.start.data(), pattern.row.data(), linear_.data(), a_.data(),
                  gradient_.data());
  gradient_.back() = {};
  quadratic_ = dot(a_, gradient_);
  if (hessian) values_ = linear_;
  kernel.add_steel(steel_, a_.data(), &energy_, gradient_.data(), hessian ? values_.data() : nullptr);
  gradient_.back() = {};
  for (std::size_t p = 0; p < four; ++p) energy_.of[p] += quadratic_.of[p] *= 0.5;
}

/// What the energy falls along: da = -(gradient - sum of i c).
void NewtonFour::downhill(const Vectors& current, Step& step) const {
  step.da.resize(a_.size());
  for (std::size_t k = 0; k < a_.size(); ++k)
    for (std::size_t p = 0; p < four; ++p) step.da[k].of[p] = -gradient_[k].of[p];
  for (std::size_t c = 0; c < windings_.size(); ++c) {
    const auto& w = windings_[c];
    for (std::size_t k = 0; k < a_.size(); ++k)
      for (std::size_t p = 0; p < four; ++p) step.da[k].of[p] += current[p][c] * w[k].of[p];
  }
}

bool NewtonFour::direction(const std::vector<Circuit>& circuits, const Vectors& current, Step& step) {
  downhill(current, step);
  bordered_.clear();
  for (std::size_t c = 0; c < circuits.size(); ++c)
    if (circuits[c].flux_given) bordered_.push_back(c);
  border_.resize(bordered_.size());
  std::vector<Four*> sides{step.da.data()};
  for (std::size_t k = 0; k < bordered_.size(); ++k) {
    border_[k] = windings_[bordered_[k]];
    sides.push_back(border_[k].data());
  }
  if (!cholesky_.solve(values_.data(), sides, air_factored_)) return false;
  air_factored_ = true;
  close_circuits(circuits, current, step);
  return true;
}

void NewtonFour::take(const Step& step, const Four& share, Vectors& current) {
  for (std::size_t k = 0; k < a_.size(); ++k)
    for (std::size_t p = 0; p < four; ++p) a_[k].of[p] += share.of[p] * step.da[k].of[p];
  for (std::size_t p = 0; p < four; ++p)
    for (std::size_t c = 0; c < step.di.size(); ++c) current[p][c] += share.of[p] * step.di[c].of[p];
}

/// What the currents have to change by, so that the step meets the fluxes.
void NewtonFour::close_circuits(const std::vector<Circuit>& circuits, const Vectors& current, Step& step) {
  const std::size_t n = bordered_.size();
  step.di.assign(circuits.size(), {});
  step.miss = {};
  std::vector<Four> rest(n), schur(n * n);
  for (std::size_t k = 0; k < n; ++k) {
    const auto& w = windings_[bordered_[k]];
    const Four linked = dot(w, a_), moved = dot(w, step.da);
    Four size{};
    for (std::size_t j = 0; j < a_.size(); ++j)
      for (std::size_t p = 0; p < four; ++p) size.of[p] += std::fabs(w[j].of[p] * a_[j].of[p]);
    const auto& circuit = circuits[bordered_[k]];
    for (std::size_t p = 0; p < four; ++p) {
      const double missing = circuit.value - linked.of[p] - circuit.resistance * current[p][bordered_[k]];
      rest[k].of[p] = missing - moved.of[p];
      step.miss.of[p] = std::max(
          step.miss.of[p], std::fabs(missing) / std::max({std::fabs(circuit.value), size.of[p], 1e-300}));
    }
    for (std::size_t l = 0; l < n; ++l) {
      schur[k * n + l] = dot(w, border_[l]);
      if (k == l)
        for (double& s : schur[k * n + l].of) s += circuit.resistance;
    }
  }
  for (std::size_t p = 0; p < four; ++p) {
    inverse_[p] = inverse_of(one_of(schur, p), n);
    for (std::size_t k = 0; k < n; ++k) {
      double di = 0;
      for (std::size_t l = 0; l < n; ++l) di += inverse_[p][k * n + l] * rest[l].of[p];
      step.di[bordered_[k]].of[p] = di;
    }
  }
  for (std::size_t k = 0; k < n; ++k)
    for (std::size_t j = 0; j < a_.size(); ++j)
      for (std::size_t p = 0; p < four; ++p)
        step.da[j].of[p] += step.di[bordered_[k]].of[p] * border_[k][j].of[p];
  step.da.back() = {};
}

/// lambda^2 = da^T H da of each problem's step, on what the circuits leave free.
Four NewtonFour::decrement_of(const std::vector<Circuit>& circuits, const Vectors& current,
                              const Step& step) const {
  Four decrement = dot(gradient_, step.da);
  for (double& d : decrement.of) d = -d;
  for (std::size_t c = 0; c < circuits.size(); ++c) {
    const Four linked = dot(windings_[c], step.da);
    for (std::size_t p = 0; p < four; ++p)
      decrement.of[p] += (current[p][c] + (circuits[c].flux_given ? step.di[c].of[p] : 0)) * linked.of[p];
  }
  for (double& d : decrement.of) d = std::fabs(d);
  return decrement;
}

std::array<NewtonReport, 4> NewtonFour::solve(const std::vector<Circuit>& circuits, Vectors& a,
                                              Vectors& current, const NewtonOptions& options) {
  constexpr double met = 1e-8;  // circuits count as met
  // A step that changes the energy by less than this is taken whole as long as they become smaller.
  constexpr double small = 1e-4;
  // Tolerances: a step smaller than this is enough where the third order of the energy is small, or is followed by
  // one with the Hessian it was made with.
  constexpr double near = 10;
  // Of the tolerance: what a step may leave by its third order, a lower bound. Of the states of five drawings
  // that went on 99 % left less than 300 times that.
  constexpr double trusted = 1e-5;
  std::array<NewtonReport, 4> reports;
  Step step;
  interleave(a_, gradient_.size(), [&](std::size_t p) { return a[p].data(); });
  for (auto& i : current) {
    i.resize(circuits.size(), 0);
    for (std::size_t c = 0; c < circuits.size(); ++c)
      if (!circuits[c].flux_given) i[c] = circuits[c].value;
  }
  const auto all_converged = [&] {
    return std::all_of(reports.begin(), reports.end(), [](const auto& r) { return r.converged; });
  };
  Four before;
  std::fill_n(before.of, four, std::numeric_limits<double>::infinity());
  evaluate(true);
  for (int iteration = 0; iteration < options.most_iterations; ++iteration) {
    if (!direction(circuits, current, step)) break;
    const Four decrement = decrement_of(circuits, current, step), energy = energy_;
    const Four slope = dot(gradient_, step.da);
    bool close = true;
    Four share;
    for (std::size_t p = 0; p < four; ++p) {
      const double lambda = decrement.of[p], size = std::fabs(energy_.of[p]);
      ++reports[p].iterations;
      const bool feasible = step.miss.of[p] < met;
      close = close && feasible && lambda <= near * options.tolerance * size;
      reports[p].converged = feasible && lambda <= options.tolerance * size;
      share.of[p] = 1;
      const bool safe = lambda <= small * size && lambda < before.of[p];
      before.of[p] = lambda;
      if (!options.line_search || !feasible || reports[p].converged || safe) continue;
      const auto at = one_of(a_, p), da = one_of(step.da, p);
      const LineSearch line{*problems_[p], problems_[p]->linear(), nullptr, circuits};
      share.of[p] =
          line.share(at, da, current[p], one_of(step.di, p), lambda, quadratic_.of[p], reports[p].cuts);
      close = close && share.of[p] == 1;
    }
    take(step, share, current);
    evaluate(!close);
    for (std::size_t p = 0; p < four; ++p) {
      const double lambda = decrement.of[p], size = std::fabs(energy_.of[p]);
      reports[p].decrement = lambda / std::max(size, 1e-300);
      // E(a + da) = E + g^T da + lambda^2 / 2 + R: along da the gradient left is 3 R
      const double rest = 3 * (energy_.of[p] - energy.of[p] - slope.of[p] - 0.5 * lambda);
      const bool little = close && rest * rest <= trusted * options.tolerance * size * lambda;
      reports[p].converged = reports[p].converged || little || energy_.of[p] == 0;
    }
    if (close && !all_converged()) {
      chord(circuits, current, decrement, options, reports);
      if (!all_converged()) evaluate(true);
    }
    if (all_converged()) break;
  }
  correct(current);
  for (std::size_t p = 0; p < four; ++p) a[p] = one_of(a_, p);
  return reports;
}

/// One more step with the Hessian of the last one, whose decrements were `decrement`: no factorisation. Such steps
/// shrink the decrement by the same factor each, so this one leaves (its own)^2 / (the last one). Where it shrinks
/// little, or the energy rises, that Hessian says nothing any more and the step is not taken.
void NewtonFour::chord(const std::vector<Circuit>& circuits, Vectors& current, const Four& decrement,
                       const NewtonOptions& options, std::array<NewtonReport, 4>& reports) {
  constexpr double trusted = 1e-7;  // of the tolerance, of what is left
  constexpr double shrinks = 0.25, rounding = 1e-12;
  Step step;
  downhill(current, step);
  cholesky_.solve_again(step.da.data());
  close_circuits(circuits, current, step);
  const Four own = decrement_of(circuits, current, step);
  const Four energy = energy_;
  Four share, back;
  for (std::size_t p = 0; p < four; ++p) share.of[p] = own.of[p] < shrinks * decrement.of[p] ? 1 : 0;
  take(step, share, current);
  evaluate(false);
  for (std::size_t p = 0; p < four; ++p) {
    const double size = std::fabs(energy.of[p]);
    const bool falls = energy_.of[p] <= energy.of[p] + rounding * size;
    back.of[p] = falls ? 0 : -share.of[p];
    if (!falls || share.of[p] == 0) continue;
    const double left = own.of[p] * own.of[p], limit = trusted * options.tolerance * size;
    reports[p].converged = reports[p].converged || left <= limit * decrement.of[p];
  }
  if (std::all_of(back.of, back.of + four, [](double b) { return b == 0; })) return;
  take(step, back, current);
  evaluate(false);
}

/// The currents of one more step with the last Hessian: they err by the square of what is left, as the energy does.
void NewtonFour::correct(Vectors& current) {
  const std::size_t n = bordered_.size();
  for (std::size_t c = 0; c < windings_.size(); ++c)
    for (std::size_t k = 0; k < a_.size(); ++k)
      for (std::size_t p = 0; p < four; ++p) gradient_[k].of[p] -= current[p][c] * windings_[c][k].of[p];
  std::vector<Four> left;
  for (const auto& b : border_) left.push_back(dot(b, gradient_));
  for (std::size_t p = 0; p < four; ++p)
    for (std::size_t k = 0; k < n; ++k)
      for (std::size_t l = 0; l < n; ++l) current[p][bordered_[k]] += inverse_[p][k * n + l] * left[l].of[p];
}

NewtonFour::Vectors NewtonFour::flux_tangent(std::size_t k) const {
  const std::size_t n = bordered_.size();
  Vectors tangent;
  for (std::size_t p = 0; p < four; ++p) {
    tangent[p].assign(a_.size(), 0);
    for (std::size_t l = 0; l < n; ++l)
      for (std::size_t j = 0; j < a_.size(); ++j)
        tangent[p][j] += inverse_[p][l * n + k] * border_[l][j].of[p];
  }
  return tangent;
}

}  // namespace powbench::sim
