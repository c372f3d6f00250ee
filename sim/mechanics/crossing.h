#pragma once

#include <algorithm>
#include <array>
#include <cmath>
#include <type_traits>

#include "sim/mechanics/dop853.h"

/// First instant at which a guard turns negative inside one step, from what is known at its two ends.

namespace powbench::sim {

/// What guards are worth at one state: mode k is valid while value[k] > 0. The first ones are smooth and also give
/// their first and second time derivatives; the others are functions that are only compared in sign.
template <class Real, int Capacity>
struct Guards {
  static_assert(Capacity % dop853::lanes == 0 && Capacity <= 64);
  alignas(dop853::alignment) Real value[Capacity] = {};
  alignas(dop853::alignment) Real rate[Capacity] = {};
  alignas(dop853::alignment) Real curve[Capacity] = {};
};

/// From time to the variable of a step: v = first * rate, c = first^2 * curve + first_bend * rate at its begin, and
/// likewise at its end.
template <class Real>
struct StepEnds {
  Real first = 0, first_bend = 0, last = 0, last_bend = 0;
};

/// Quintic Hermite polynomial of a guard over one step, in Bernstein form on 0 .. 1. From value, slope and
/// curvature at both ends, the latter two per step. The curve stays within the hull of the six coefficients, so
/// coefficients that are all positive prove that there is no zero: no even root can hide between the ends.
template <class Real>
using Bernstein = std::array<Real, 6>;

template <class Real>
inline Bernstein<Real> quintic(Real g0, Real v0, Real c0, Real g1, Real v1, Real c1) {
  return {g0, g0 + v0 / 5, g0 + 2 * v0 / 5 + c0 / 20, g1 - 2 * v1 / 5 + c1 / 20, g1 - v1 / 5, g1};
}

template <class Real>
inline bool all_positive(const Bernstein<Real>& b) {
  return b[1] >= 0 && b[2] >= 0 && b[3] >= 0 && b[4] >= 0 && b[5] >= 0;
}

/// Where the cubic with these values and slopes at 0 and 1 is lowest, if that is inside and below a twentieth of the
/// larger value, else 2: a function known by its slopes only may be negative there.
template <class Real>
inline Real lowest_share(Real g0, Real v0, Real g1, Real v1) {
  const Real enough = std::max(g0, g1) / 20;
  if (std::min(g0 + v0 / 3, g1 - v1 / 3) >= enough) return 2;  // the hull of its coefficients is above
  const Real a = 3 * (v0 + v1 + 2 * (g0 - g1)),
             b = 2 * (3 * (g1 - g0) - 2 * v0 - v1);  // slope: a x^2 + b x + v0
  const Real root = b * b - 4 * a * v0;
  if (!(root > 0)) return 2;
  // the zero at which the slope rises; without cancellation
  const Real q = b > 0 ? b + std::sqrt(root) : b - std::sqrt(root);
  const Real x = b > 0 ? -2 * v0 / q : -q / (2 * a);
  if (!(x > 0 && x < 1)) return 2;
  const Real y = g0 + x * (v0 + x * (b / 2 + x * a / 3));
  return y < enough ? x : Real(2);
}

/// Bracket of a first crossing: the guard is positive at `low` and negative at `high`.
template <class Real>
struct Crossing {
  bool found = false;
  Real low = 0;
  Real high = 1;
};

namespace crossing_detail {

template <class Real>
inline void halve(const Bernstein<Real>& b, Bernstein<Real>& left, Bernstein<Real>& right) {
  Bernstein<Real> w = b;
  for (std::size_t level = 0; level < 6; ++level) {
    left[level] = w[0];
    right[5 - level] = w[5 - level];
    for (std::size_t i = 0; i + 1 < 6 - level; ++i) w[i] = (w[i] + w[i + 1]) / 2;
  }
}

/// Depth first, so that the first zero is found first. `budget` bounds the work on a curve that hugs zero.
template <class Real>
Crossing<Real> search(const Bernstein<Real>& b, Real low, Real high, int depth, int& budget) {
  if (all_positive(b)) return {};
  if (b[0] >= 0 && b[5] < 0) {  // one sign change of the coefficients: exactly one zero
    int changes = 0;
    for (std::size_t i = 0; i + 1 < 6; ++i) changes += (b[i] < 0) != (b[i + 1] < 0);
    if (changes == 1) return {true, low, high};
  }
  if (depth == 30 || --budget < 0) return {b[5] < 0 && b[0] >= 0, low, high};
  Bernstein<Real> left;
  Bernstein<Real> right;
  halve(b, left, right);
  const Real middle = (low + high) / 2;
  const auto first = search(left, low, middle, depth + 1, budget);
  if (first.found) return first;
  return search(right, middle, high, depth + 1, budget);
}

}  // namespace crossing_detail

/// First crossing of the quintic from positive to negative on 0 .. 1. A first value below zero counts as zero:
/// the step began on the event.
template <class Real>
inline Crossing<Real> first_crossing(Bernstein<Real> b) {
  if (b[0] < 0) b[0] = 0;
  if (all_positive(b)) return {};
  int budget = 300;
  return crossing_detail::search(b, Real(0), Real(1), 0, budget);
}

/// First share, 0 .. most, at which a guard is negative, 2 if it is nowhere. at(share, slope) is its value and, where
/// that is known, its slope (0 else). The bracket may be off by a little: the quintic is not the guard.
template <class Real, class At>
Real first_negative(const Crossing<Real>& bracket, Real most, const At& at) {
  Real low = bracket.low;
  Real high = bracket.high;
  Real slope = 0;
  Real g = at(high, slope);
  for (int i = 0; g >= 0 && high < most && i < 12; ++i) {  // the quintic was a little early
    high = std::min(most, high + (high - low + Real(1e-9L)));
    g = at(high, slope);
  }
  if (g >= 0) return 2;
  Real x = high;
  for (Real wider = high - low; low > 0; wider *= 2) {  // or a little late
    Real unused = 0;
    if (at(low, unused) >= 0) break;
    low = std::max(Real(0), low - wider);
  }
  const Real resolution = std::is_same_v<Real, double> ? Real(2e-16L) : Real(1e-19L);
  for (int i = 0; i < 100 && high - low > resolution; ++i) {
    Real next = slope < 0 ? x - g / slope : (low + high) / 2;
    if (!(next > low && next < high) || i > 8) next = i % 3 == 0 || slope >= 0 ? (low + high) / 2 : next;
    if (!(next > low && next < high)) next = (low + high) / 2;
    if (next <= low || next >= high) break;
    const Real moved = std::fabs(next - x);
    x = next;
    g = at(x, slope);
    (g < 0 ? high : low) = x;
    if (moved < Real(1e-10L) && slope < 0) break;  // the next Newton step would be round-off
  }
  return x;
}

/// False if none of the first n guards can turn negative within the step. n is a multiple of `dop853::lanes`.
bool may_cross(int n, const StepEnds<double>&, const double* value0, const double* rate0,
               const double* curve0, const double* value1, const double* rate1, const double* curve1);
bool may_cross(int n, const StepEnds<long double>&, const long double* value0, const long double* rate0,
               const long double* curve0, const long double* value1, const long double* rate1,
               const long double* curve1);

template <class Real, int Capacity>
bool may_cross(int n, const StepEnds<Real>& ends, const Guards<Real, Capacity>& a,
               const Guards<Real, Capacity>& b) {
  return may_cross(n, ends, a.value, a.rate, a.curve, b.value, b.rate, b.curve);
}

}  // namespace powbench::sim
