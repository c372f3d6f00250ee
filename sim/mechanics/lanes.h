#pragma once

#include <cmath>
#include <cstring>

#include "sim/mechanics/clones.h"

/// Eight values side by side: a vector register (or several) of doubles, or an array of long doubles for reference
/// solutions. Arguments go by reference, because how vectors are passed depends on the machine.

/// A source that defines POWBENCH_HALF_LANES has two registers of four in place of one of eight, with the same layout
/// in memory and the same bits: where a processor has no wider ones, the compiler splits eight badly.
#ifdef POWBENCH_HALF_LANES
#define POWBENCH_LANE_SPACE lanes_in_halves
#else
#define POWBENCH_LANE_SPACE lanes_whole
#endif

namespace powbench::sim {
inline namespace POWBENCH_LANE_SPACE {

inline constexpr int lane_count = 8;

/// The long double version: slow, and only for references.
struct alignas(64) LongLanes {
  long double v[lane_count] = {};
  long double& operator[](int i) { return v[i]; }
  long double operator[](int i) const { return v[i]; }
};

#define POWBENCH_LANE_OPERATOR(op)                                       \
  inline LongLanes operator op(const LongLanes& a, const LongLanes& b) { \
    LongLanes r;                                                         \
    for (int i = 0; i < lane_count; ++i) r.v[i] = a.v[i] op b.v[i];      \
    return r;                                                            \
  }                                                                      \
  inline LongLanes operator op(long double a, const LongLanes& b) {      \
    LongLanes r;                                                         \
    for (int i = 0; i < lane_count; ++i) r.v[i] = a op b.v[i];           \
    return r;                                                            \
  }                                                                      \
  inline LongLanes& operator op##=(LongLanes& a, const LongLanes& b) {   \
    for (int i = 0; i < lane_count; ++i) a.v[i] = a.v[i] op b.v[i];      \
    return a;                                                            \
  }
POWBENCH_LANE_OPERATOR(+)
POWBENCH_LANE_OPERATOR(-)
POWBENCH_LANE_OPERATOR(*)
#undef POWBENCH_LANE_OPERATOR

#ifdef POWBENCH_HALF_LANES
struct alignas(64) HalfLanes {
  typedef double Half __attribute__((vector_size(32), may_alias));
  Half half[2];
  double& operator[](int i) { return reinterpret_cast<double*>(half)[i]; }
  double operator[](int i) const { return reinterpret_cast<const double*>(half)[i]; }
};

#define POWBENCH_LANE_OPERATOR(op)                                                \
  POWBENCH_INLINE HalfLanes operator op(const HalfLanes& a, const HalfLanes& b) { \
    return {{a.half[0] op b.half[0], a.half[1] op b.half[1]}};                    \
  }                                                                               \
  POWBENCH_INLINE HalfLanes operator op(double a, const HalfLanes& b) {           \
    return {{a op b.half[0], a op b.half[1]}};                                    \
  }                                                                               \
  POWBENCH_INLINE HalfLanes& operator op##=(HalfLanes& a, const HalfLanes& b) {   \
    return a = a op b;                                                            \
  }
POWBENCH_LANE_OPERATOR(+)
POWBENCH_LANE_OPERATOR(-)
POWBENCH_LANE_OPERATOR(*)
#undef POWBENCH_LANE_OPERATOR
#endif

template <class Real>
struct LaneType;
template <>
struct LaneType<double> {
#ifdef POWBENCH_HALF_LANES
  using type = HalfLanes;
#else
  typedef double type __attribute__((vector_size(64)));
#endif
};
template <>
struct LaneType<long double> {
  using type = LongLanes;
};
template <class Real>
using Lanes = typename LaneType<Real>::type;

/// From eight neighbours in memory, at any address.
template <class Real>
POWBENCH_INLINE void load(const Real* from, Lanes<Real>& to) {
  std::memcpy(static_cast<void*>(&to), from, lane_count * sizeof(Real));
}
template <class Real>
POWBENCH_INLINE void store(const Lanes<Real>& from, Real* to) {
  std::memcpy(to, &from, lane_count * sizeof(Real));
}

/// max(v, 0).
POWBENCH_INLINE void clip(const Lanes<double>& v, Lanes<double>& out) {
#ifdef POWBENCH_HALF_LANES
  const HalfLanes::Half zero{};
  for (int i = 0; i < 2; ++i) out.half[i] = v.half[i] > zero ? v.half[i] : zero;
#else
  const Lanes<double> zero{};
  out = v > zero ? v : zero;
#endif
}
inline void clip(const LongLanes& v, LongLanes& out) {
  for (int i = 0; i < lane_count; ++i) out[i] = v[i] > 0 ? v[i] : 0;
}

/// v where `test` is positive, else 0.
POWBENCH_INLINE void keep(const Lanes<double>& test, const Lanes<double>& v, Lanes<double>& out) {
#ifdef POWBENCH_HALF_LANES
  const HalfLanes::Half zero{};
  for (int i = 0; i < 2; ++i) out.half[i] = test.half[i] > zero ? v.half[i] : zero;
#else
  const Lanes<double> zero{};
  out = test > zero ? v : zero;
#endif
}
inline void keep(const LongLanes& test, const LongLanes& v, LongLanes& out) {
  for (int i = 0; i < lane_count; ++i) out[i] = test[i] > 0 ? v[i] : 0;
}

template <class Real>
POWBENCH_INLINE void square_root(const Lanes<Real>& v, Lanes<Real>& out) {
  alignas(64) Real t[lane_count];
  store<Real>(v, t);
  for (int i = 0; i < lane_count; ++i) t[i] = std::sqrt(t[i]);
  load<Real>(t, out);
}

template <class Real>
POWBENCH_INLINE Real lane_sum(const Lanes<Real>& v) {
  return ((v[0] + v[4]) + (v[2] + v[6])) + ((v[1] + v[5]) + (v[3] + v[7]));
}

}  // namespace POWBENCH_LANE_SPACE
}  // namespace powbench::sim
