#include "sim/mechanics/dop853.h"

#include <cmath>

#include "sim/mechanics/clones.h"

namespace powbench::sim::dop853 {
namespace {

/// What one loop pass works on: eight doubles side by side, or one long double.
template <class Real>
struct Pack;
template <>
struct Pack<double> {
  typedef double type __attribute__((vector_size(64), may_alias));
  static constexpr int width = 8;
};
template <>
struct Pack<long double> {
  using type = long double;
  static constexpr int width = 1;
};

template <class Real>
POWBENCH_INLINE const typename Pack<Real>::type& pack(const Real* p) {
  return *reinterpret_cast<const typename Pack<Real>::type*>(p);
}
template <class Real>
POWBENCH_INLINE typename Pack<Real>::type& pack(Real* p) {
  return *reinterpret_cast<typename Pack<Real>::type*>(p);
}

template <int Row, class Real>
POWBENCH_INLINE void row_sum(int n, Real h, const Real* y, const Real* k, int stride, Real* out) {
  constexpr int terms = Row <= 12 ? Row : Row;
  for (int i = 0; i < n; i += Pack<Real>::width) {
    typename Pack<Real>::type sum{};
#pragma GCC unroll 16
    for (int j = 0; j < terms; ++j)
      if (a[Row][j] != 0) sum += static_cast<Real>(a[Row][j]) * pack(k + j * stride + i);
    pack(out + i) = pack(y + i) + h * sum;
  }
}

template <class Real>
POWBENCH_INLINE void argument_of(int row, int n, Real h, const Real* y, const Real* k, int stride,
                                 Real* out) {
  switch (row) {
    case 1:
      return row_sum<1>(n, h, y, k, stride, out);
    case 2:
      return row_sum<2>(n, h, y, k, stride, out);
    case 3:
      return row_sum<3>(n, h, y, k, stride, out);
    case 4:
      return row_sum<4>(n, h, y, k, stride, out);
    case 5:
      return row_sum<5>(n, h, y, k, stride, out);
    case 6:
      return row_sum<6>(n, h, y, k, stride, out);
    case 7:
      return row_sum<7>(n, h, y, k, stride, out);
    case 8:
      return row_sum<8>(n, h, y, k, stride, out);
    case 9:
      return row_sum<9>(n, h, y, k, stride, out);
    case 10:
      return row_sum<10>(n, h, y, k, stride, out);
    case 11:
      return row_sum<11>(n, h, y, k, stride, out);
    case 12:
      return row_sum<12>(n, h, y, k, stride, out);
    case 13:
      return row_sum<13>(n, h, y, k, stride, out);
    case 14:
      return row_sum<14>(n, h, y, k, stride, out);
    default:
      return row_sum<15>(n, h, y, k, stride, out);
  }
}

template <class Real>
POWBENCH_INLINE Real total(const typename Pack<Real>::type& v) {
  if constexpr (Pack<Real>::width == 1) {
    return v;
  } else {
    return ((v[0] + v[4]) + (v[2] + v[6])) + ((v[1] + v[5]) + (v[3] + v[7]));
  }
}

template <class Real>
POWBENCH_INLINE Real error_of(int n, int count, Real h, const Real* k, int stride, const Real* inverse) {
  typename Pack<Real>::type five{};
  typename Pack<Real>::type three{};
  for (int i = 0; i < n; i += Pack<Real>::width) {
    typename Pack<Real>::type e5{};
    typename Pack<Real>::type e3{};
#pragma GCC unroll 16
    for (int j = 0; j < stages; ++j) {
      if (error5[j] != 0) e5 += static_cast<Real>(error5[j]) * pack(k + j * stride + i);
      if (error3[j] != 0) e3 += static_cast<Real>(error3[j]) * pack(k + j * stride + i);
    }
    e5 *= pack(inverse + i);
    e3 *= pack(inverse + i);
    five += e5 * e5;
    three += e3 * e3;
  }
  const Real s5 = total<Real>(five);
  const Real s3 = total<Real>(three);
  if (s5 == 0) return 0;
  return std::fabs(h) * s5 / std::sqrt((s5 + Real(0.01L) * s3) * static_cast<Real>(count));
}

template <class Real>
POWBENCH_INLINE void rows_of(int n, Real h, const Real* y0, const Real* y1, const Real* k, int stride,
                             Real* rows) {
  for (int i = 0; i < n; i += Pack<Real>::width) {
    const auto change = pack(y1 + i) - pack(y0 + i);
    const auto first = h * pack(k + i);
    const auto last = h * pack(k + 12 * stride + i);
    pack(rows + i) = change;
    pack(rows + stride + i) = first - change;
    pack(rows + 2 * stride + i) = Real(2) * change - (last + first);
#pragma GCC unroll 4
    for (int r = 0; r < 4; ++r) {
      typename Pack<Real>::type sum{};
#pragma GCC unroll 16
      for (int j = 0; j < slopes; ++j)
        if (dense[r][j] != 0) sum += static_cast<Real>(dense[r][j]) * pack(k + j * stride + i);
      pack(rows + (3 + r) * stride + i) = h * sum;
    }
  }
}

template <class Real>
POWBENCH_INLINE void state_of(int n, Real x, const Real* y0, const Real* rows, int stride, Real* out) {
  const Real z = 1 - x;
  for (int i = 0; i < n; i += Pack<Real>::width) {
    auto v = x * pack(rows + 6 * stride + i);
    v = z * (v + pack(rows + 5 * stride + i));
    v = x * (v + pack(rows + 4 * stride + i));
    v = z * (v + pack(rows + 3 * stride + i));
    v = x * (v + pack(rows + 2 * stride + i));
    v = z * (v + pack(rows + stride + i));
    v = x * (v + pack(rows + i));
    pack(out + i) = pack(y0 + i) + v;
  }
}

}  // namespace

POWBENCH_CLONES
void argument(int row, int n, double h, const double* y, const double* k, int stride, double* out) {
  argument_of(row, n, h, y, k, stride, out);
}
void argument(int row, int n, long double h, const long double* y, const long double* k, int stride,
              long double* out) {
  argument_of(row, n, h, y, k, stride, out);
}

POWBENCH_CLONES
double error(int n, int count, double h, const double* k, int stride, const double* inverse) {
  return error_of(n, count, h, k, stride, inverse);
}
long double error(int n, int count, long double h, const long double* k, int stride,
                  const long double* inverse) {
  return error_of(n, count, h, k, stride, inverse);
}

POWBENCH_CLONES
void dense_rows(int n, double h, const double* y0, const double* y1, const double* k, int stride,
                double* rows) {
  rows_of(n, h, y0, y1, k, stride, rows);
}
void dense_rows(int n, long double h, const long double* y0, const long double* y1, const long double* k,
                int stride, long double* rows) {
  rows_of(n, h, y0, y1, k, stride, rows);
}

POWBENCH_CLONES
void dense_state(int n, double x, const double* y0, const double* rows, int stride, double* out) {
  state_of(n, x, y0, rows, stride, out);
}
void dense_state(int n, long double x, const long double* y0, const long double* rows, int stride,
                 long double* out) {
  state_of(n, x, y0, rows, stride, out);
}

}  // namespace powbench::sim::dop853
