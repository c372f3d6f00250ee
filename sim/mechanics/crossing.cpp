#include "sim/mechanics/crossing.h"

#include "sim/mechanics/lanes.h"

namespace powbench::sim {
namespace {

template <class Real>
POWBENCH_INLINE bool any_negative(int n, const StepEnds<Real>& ends, const Real* value0, const Real* rate0,
                                  const Real* curve0, const Real* value1, const Real* rate1,
                                  const Real* curve1) {
  using V = Lanes<Real>;
  const Real square0 = ends.first * ends.first / 20;
  const Real square1 = ends.last * ends.last / 20;
  V hull{};  // sum of the negative parts of all coefficients
  for (int i = 0; i < n; i += lane_count) {
    V g0, g1, r0, r1, c0, c1;
    load<Real>(value0 + i, g0);
    load<Real>(value1 + i, g1);
    load<Real>(rate0 + i, r0);
    load<Real>(rate1 + i, r1);
    load<Real>(curve0 + i, c0);
    load<Real>(curve1 + i, c1);
    const V v0 = (ends.first / 5) * r0;
    const V v1 = (ends.last / 5) * r1;
    const V b2 = g0 + (v0 + v0) + (square0 * c0 + (ends.first_bend / 20) * r0);
    const V b3 = g1 - (v1 + v1) + (square1 * c1 + (ends.last_bend / 20) * r1);
    const V all[] = {g0, g0 + v0, b2, b3, g1 - v1, g1};
    for (const V& b : all) {
      const V down = Real(-1) * b;
      V part;
      clip(down, part);
      hull += part;
    }
  }
  for (int i = 0; i < lane_count; ++i)
    if (hull[i] > 0) return true;
  return false;
}

}  // namespace

POWBENCH_CLONES
bool may_cross(int n, const StepEnds<double>& ends, const double* value0, const double* rate0,
               const double* curve0, const double* value1, const double* rate1, const double* curve1) {
  return any_negative(n, ends, value0, rate0, curve0, value1, rate1, curve1);
}
bool may_cross(int n, const StepEnds<long double>& ends, const long double* value0, const long double* rate0,
               const long double* curve0, const long double* value1, const long double* rate1,
               const long double* curve1) {
  return any_negative(n, ends, value0, rate0, curve0, value1, rate1, curve1);
}

}  // namespace powbench::sim
