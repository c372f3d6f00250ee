// Cross products of columns: every version, every remainder, beside sums in extended precision.

#include "dsp/signal/gram.h"

#include <algorithm>
#include <catch2/catch.hpp>
#include <cmath>
#include <complex>
#include <vector>

#include "core/random.h"
#include "dsp/vibration/mode_columns.h"

using namespace powbench;
using namespace powbench::dsp;

namespace {

std::vector<const GramKernel*> kernels() {
  std::vector<const GramKernel*> list{&portable_gram_kernel()};
#ifdef __x86_64__
  if (__builtin_cpu_supports("avx2") && __builtin_cpu_supports("fma")) list.push_back(&avx2_gram_kernel());
  if (__builtin_cpu_supports("avx512f")) list.push_back(&avx512_gram_kernel());
#endif
  return list;
}

std::vector<double> numbers(std::size_t count, std::uint64_t seed) {
  Random random(seed);
  std::vector<double> v(count);
  for (double& x : v) x = 2 * random.uniform() - 1;
  return v;
}

/// Largest difference to the exact product over the rounding that gram.h allows.
double excess(const ColumnSet& a, const ColumnSet& b, std::size_t rows, const std::vector<double>& c,
              std::size_t c_stride, bool upper) {
  double worst = 0;
  for (std::size_t i = 0; i < a.count; ++i)
    for (std::size_t k = upper ? i : 0; k < b.count; ++k) {
      long double sum = 0, size = 0;
      for (std::size_t r = 0; r < rows; ++r) {
        const long double x = static_cast<long double>(a.data[i * a.stride + r]) * b.data[k * b.stride + r];
        sum += x;
        size += std::fabs(x);
      }
      const long double allowed = (static_cast<long double>(rows) / 8 + 8) * 1.2e-16L * size + 1e-300L;
      worst = std::max(worst, static_cast<double>(std::fabs(sum - c[i + k * c_stride]) / allowed));
    }
  return worst;
}

}  // namespace

TEST_CASE("cross products are right for every number of columns and rows", "[gram]") {
  for (const GramKernel* kernel : kernels()) {
    CAPTURE(kernel->name);
    for (const std::size_t rows : {0U, 1U, 7U, 8U, 9U, 64U, 301U})
      for (std::size_t na = 1; na <= 9; ++na)
        for (std::size_t nb = 1; nb <= 5; ++nb) {
          CAPTURE(rows, na, nb);
          const std::size_t as = rows + 3, bs = rows + 5, cs = na + 2;
          const auto a = numbers(as * na, 1 + rows + na), b = numbers(bs * nb, 900 + rows + nb);
          std::vector<double> c(cs * nb, 7.5);
          const ColumnSet x{a.data(), as, na}, y{b.data(), bs, nb};
          kernel->run(x, y, rows, c.data(), cs, false);
          CHECK(excess(x, y, rows, c, cs, false) <= 1);
          for (std::size_t k = 0; k < nb; ++k) REQUIRE(c[na + k * cs] == 7.5);  // nothing beside the matrix
          if (na < nb) continue;
          const ColumnSet z{a.data(), as, na};
          std::vector<double> half(na * na);
          kernel->run(z, z, rows, half.data(), na, true);
          CHECK(excess(z, z, rows, half, na, true) <= 1);
        }
  }
}

TEST_CASE("a set of columns with itself gives a symmetric matrix, to the bit", "[gram]") {
  constexpr std::size_t rows = 203, n = 7;
  const auto a = numbers(rows * n, 5);
  const ColumnSet x{a.data(), rows, n};
  std::vector<double> c(n * n), other(n * n);
  cross_products(x, x, rows, c.data(), n);
  for (std::size_t i = 0; i < n; ++i)
    for (std::size_t k = 0; k < n; ++k) CHECK(c[i + k * n] == c[k + i * n]);
  const std::vector<double> copy = a;
  cross_products(x, {copy.data(), rows, n}, rows, other.data(), n);
  CHECK(c == other);
}

TEST_CASE(
    "columns of a mode are its exponentials for every number of rows, and nothing is written behind them",
    "[gram]") {
  const std::complex<double> s{-900, 2 * 3.14159265358979 * 17e3}, gain{0.7, -0.2};
  const double tau = -3e-4, dt = 5e-6;
  for (const std::size_t n : {1U, 7U, 8U, 9U, 127U, 128U, 131U, 1000U}) {
    CAPTURE(n);
    std::vector<double> c(n + 1, 77), d(n + 1, 77);
    mode_columns(s, gain, tau, dt, n, c.data(), d.data());
    double worst = 0;
    for (std::size_t i = 0; i < n; ++i) {
      const std::complex<double> exact = gain * std::exp(s * (tau + static_cast<double>(i) * dt));
      worst = std::max(worst, std::abs(std::complex(c[i], d[i]) - exact) / std::abs(exact));
    }
    CHECK(worst < 1e-13);
    CHECK((c[n] == 77 && d[n] == 77));
  }
}
