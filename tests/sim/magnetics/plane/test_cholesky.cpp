#include <catch2/catch.hpp>
#include <cmath>
#include <vector>

#include "core/random.h"
#include "sim/magnetics/plane/cholesky.h"
#include "sim/magnetics/plane/cholesky_four.h"
#include "sim/magnetics/plane/dense_kernel.h"

using powbench::sim::Cholesky;
using powbench::sim::Pattern;

namespace {

/// Five-point Laplacian of an n x n square, plus `shift` on the diagonal, in a fill-reducing order.
struct Square {
  Pattern pattern;
  std::vector<double> values;
};

Square square(int n, double shift) {
  std::vector<int> pairs;
  for (int y = 0; y < n; ++y)
    for (int x = 0; x < n; ++x) {
      const int k = y * n + x;
      if (x + 1 < n) pairs.insert(pairs.end(), {k, k + 1});
      if (y + 1 < n) pairs.insert(pairs.end(), {k, k + n});
    }
  const auto order = fill_reducing_order(powbench::sim::pattern_of(n * n, pairs, 2));
  std::vector<int> place(order.size());
  for (std::size_t k = 0; k < order.size(); ++k)
    place[static_cast<std::size_t>(order[k])] = static_cast<int>(k);
  for (int& k : pairs) k = place[static_cast<std::size_t>(k)];
  Square s;
  s.pattern = powbench::sim::pattern_of(n * n, pairs, 2);
  for (int j = 0; j < s.pattern.size; ++j)
    for (int at = s.pattern.start[static_cast<std::size_t>(j)];
         at < s.pattern.start[static_cast<std::size_t>(j) + 1]; ++at)
      s.values.push_back(s.pattern.row[static_cast<std::size_t>(at)] == j ? 4 + shift : -1);
  return s;
}

std::vector<double> product(const Square& a, const std::vector<double>& x) {
  std::vector<double> y(x.size(), 0);
  for (std::size_t j = 0; j < x.size(); ++j)
    for (int at = a.pattern.start[j]; at < a.pattern.start[j + 1]; ++at) {
      const auto i = static_cast<std::size_t>(a.pattern.row[static_cast<std::size_t>(at)]);
      y[i] += a.values[static_cast<std::size_t>(at)] * x[j];
      if (i != j) y[j] += a.values[static_cast<std::size_t>(at)] * x[i];
    }
  return y;
}

}  // namespace

TEST_CASE("the factorisation solves a Laplacian of any size to round-off, again and again") {
  for (const int n : {1, 2, 3, 7, 20, 61, 120}) {
    INFO("n = " << n);
    Square a = square(n, 0.01);
    Cholesky cholesky(a.pattern);
    powbench::Random random(7);
    std::vector<double> x(a.pattern.start.size() - 1);
    for (auto& value : x) value = random.uniform() - 0.5;
    for (int repeat = 0; repeat < 2; ++repeat) {
      auto b = product(a, x);
      REQUIRE(cholesky.factor(a.values.data()));
      cholesky.solve(b.data());
      double worst = 0;
      for (std::size_t k = 0; k < x.size(); ++k) worst = std::max(worst, std::fabs(b[k] - x[k]));
      CHECK(worst < 1e-11);
      auto one = product(a, x), two = one, three = one;
      for (auto& value : two) value *= -2;
      for (auto& value : three) value *= 4;
      cholesky.solve({one.data(), two.data(), three.data()});
      for (std::size_t k = 0; k < x.size(); ++k) {
        worst = std::max(worst, std::fabs(one[k] - x[k]));
        worst = std::max(worst, std::fabs(two[k] + 2 * x[k]));
        worst = std::max(worst, std::fabs(three[k] - 4 * x[k]));
      }
      CHECK(worst < 4e-11);
      for (auto& value : a.values) value *= 3;
    }
  }
}

TEST_CASE("a factor of which a part is kept is the whole one to the bit") {
  for (const int n : {3, 20, 61}) {
    INFO("n = " << n);
    Square a = square(n, 0.01);
    const auto columns = static_cast<std::size_t>(a.pattern.size);
    powbench::Random random(3);
    std::vector<char> changing(columns, 0);
    for (std::size_t k = 0; k < columns; ++k) changing[k] = k % 61 < 3;
    Cholesky some(a.pattern);
    some.set_changing(changing);
    REQUIRE(some.factor(a.values.data(), true));  // nothing to keep yet
    for (int repeat = 0; repeat < 3; ++repeat) {
      for (std::size_t j = 0; j < columns; ++j)
        if (changing[j]) a.values[static_cast<std::size_t>(a.pattern.start[j])] += random.uniform();
      Cholesky whole(a.pattern);
      REQUIRE(some.factor(a.values.data(), true));
      REQUIRE(whole.factor(a.values.data()));
      std::vector<double> x(columns, 1), y(columns, 1);
      some.solve(x.data());
      whole.solve(y.data());
      CHECK(x == y);
    }
    for (auto& value : a.values) value *= 2;  // all of it
    Cholesky whole(a.pattern);
    REQUIRE(some.factor(a.values.data()));
    REQUIRE(whole.factor(a.values.data()));
    std::vector<double> x(columns, 1), y(columns, 1);
    some.solve(x.data());
    whole.solve(y.data());
    CHECK(x == y);
  }
}

TEST_CASE("a matrix that is not positive definite is refused") {
  Square a = square(10, -4.5);
  Cholesky cholesky(a.pattern);
  CHECK_FALSE(cholesky.factor(a.values.data()));
}

TEST_CASE("each instruction set solves with a panel as plain loops do") {
  using namespace powbench::sim;
  std::vector<const DenseKernel*> kernels{&portable_dense_kernel()};
#ifdef __x86_64__
  if (__builtin_cpu_supports("avx2") && __builtin_cpu_supports("fma"))
    kernels.push_back(&avx2_dense_kernel());
  if (__builtin_cpu_supports("avx512f")) kernels.push_back(&avx512_dense_kernel());
#endif
  const auto at = [](int i) { return static_cast<std::size_t>(i); };
  for (const auto* kernel : kernels)
    for (int m = 1; m < 40; m += 3)
      for (int n = 1; n <= m; n += n < 9 ? 1 : 7) {
        INFO(kernel->name << ", " << m << " x " << n);
        powbench::Random random(static_cast<std::uint64_t>(m * 100 + n));
        const int lda = (m + 7) / 8 * 8, ldx = lda + dense_slack;
        std::vector<double> a(at(lda * n + dense_slack), 0), x(at(2 * ldx), 0);
        for (int j = 0; j < n; ++j)
          for (int i = j; i < m; ++i) a[at(i + j * lda)] = random.uniform() - 0.5 + (i == j ? 2 : 0);
        for (int v = 0; v < 2; ++v)
          for (int i = 0; i < m; ++i) x[at(i + v * ldx)] = random.uniform();
        auto down = x, up = x;
        for (int v = 0; v < 2; ++v) {
          double *const d = down.data() + v * ldx, *const u = up.data() + v * ldx;
          for (int j = 0; j < n; ++j) {
            d[j] /= a[at(j + j * lda)];
            for (int i = j + 1; i < m; ++i) d[i] -= a[at(i + j * lda)] * d[j];
          }
          for (int j = n - 1; j >= 0; --j) {
            for (int i = j + 1; i < m; ++i) u[j] -= a[at(i + j * lda)] * u[i];
            u[j] /= a[at(j + j * lda)];
          }
        }
        for (const int vectors : {1, 2}) {
          auto forward = x, backward = x;
          kernel->forward(a.data(), lda, m, n, forward.data(), ldx, vectors);
          kernel->backward(a.data(), lda, m, n, backward.data(), ldx, vectors);
          double worst = 0;
          for (int v = 0; v < vectors; ++v)
            for (int i = 0; i < m; ++i) {
              worst = std::max(worst, std::fabs(forward[at(i + v * ldx)] - down[at(i + v * ldx)]));
              worst = std::max(worst, std::fabs(backward[at(i + v * ldx)] - up[at(i + v * ldx)]));
            }
          CHECK(worst < 1e-13);
        }
      }
}

namespace {

/// What one lane of `values` is, and the right sides: other numbers in each lane.
std::vector<powbench::sim::Four> four_of(const std::vector<double>& values, powbench::Random& random) {
  std::vector<powbench::sim::Four> out(values.size());
  double scale[4];
  for (double& s : scale) s = 1 + random.uniform();
  for (std::size_t k = 0; k < values.size(); ++k)
    for (std::size_t p = 0; p < 4; ++p) out[k].of[p] = scale[p] * values[k];
  return out;
}

}  // namespace

TEST_CASE("four matrices side by side have the solutions of each alone") {
  for (const int n : {1, 2, 3, 7, 20, 61}) {
    INFO("n = " << n);
    const Square a = square(n, 0.01);
    powbench::Random random(5);
    auto values = four_of(a.values, random);
    for (std::size_t j = 0; j + 1 < a.pattern.start.size(); ++j)
      for (double& v : values[static_cast<std::size_t>(a.pattern.start[j])].of) v += random.uniform();
    powbench::sim::CholeskyFour four(a.pattern);
    for (std::size_t sides = 1; sides <= 3; ++sides) {
      std::vector<std::vector<powbench::sim::Four>> b;
      std::vector<powbench::sim::Four*> to;
      for (std::size_t v = 0; v < sides; ++v) {
        std::vector<double> side(a.pattern.start.size() - 1);
        for (double& x : side) x = random.uniform() - 0.5;
        b.push_back(four_of(side, random));
      }
      auto solved = b;
      for (auto& s : solved) to.push_back(s.data());
      auto again = b.front();
      REQUIRE(four.solve(values.data(), to));
      four.solve_again(again.data());
      for (std::size_t k = 0; k < again.size(); ++k)
        for (std::size_t p = 0; p < 4; ++p) CHECK(std::fabs(again[k].of[p] - solved[0][k].of[p]) < 1e-12);
      for (std::size_t p = 0; p < 4; ++p) {
        Cholesky alone(a.pattern);
        std::vector<double> own;
        for (const auto& v : values) own.push_back(v.of[p]);
        REQUIRE(alone.factor(own.data()));
        for (std::size_t v = 0; v < sides; ++v) {
          std::vector<double> x;
          for (const auto& k : b[v]) x.push_back(k.of[p]);
          alone.solve(x.data());
          double worst = 0;
          for (std::size_t k = 0; k < x.size(); ++k)
            worst = std::max(worst, std::fabs(x[k] - solved[v][k].of[p]));
          CHECK(worst < 1e-12);
        }
      }
    }
    values[static_cast<std::size_t>(a.pattern.start[(a.pattern.start.size() - 1) / 2])].of[2] = -9;
    auto x = four_of(std::vector<double>(a.pattern.start.size() - 1, 1), random);
    CHECK_FALSE(four.solve(values.data(), {x.data()}));
  }
}

TEST_CASE("four factors of which a part is kept are the whole ones to the bit") {
  using powbench::sim::CholeskyFour;
  for (const int n : {3, 20, 61}) {
    INFO("n = " << n);
    const Square a = square(n, 0.01);
    const auto columns = static_cast<std::size_t>(a.pattern.size);
    powbench::Random random(3);
    auto values = four_of(a.values, random);
    std::vector<char> changing(columns, 0);
    for (std::size_t k = 0; k < columns; ++k) changing[k] = k % 61 < 3;
    CholeskyFour some(a.pattern);
    some.set_changing(changing);
    const auto check = [&](bool others_kept) {
      CholeskyFour whole(a.pattern);
      auto x = four_of(std::vector<double>(columns, 1), random), y = x;
      REQUIRE(some.solve(values.data(), {x.data()}, others_kept));
      REQUIRE(whole.solve(values.data(), {y.data()}));
      bool same = true;
      for (std::size_t k = 0; k < columns; ++k)
        for (std::size_t p = 0; p < 4; ++p) same = same && x[k].of[p] == y[k].of[p];
      CHECK(same);
    };
    check(true);  // nothing to keep yet
    for (int repeat = 0; repeat < 3; ++repeat) {
      for (std::size_t j = 0; j < columns; ++j)
        if (changing[j])
          for (double& v : values[static_cast<std::size_t>(a.pattern.start[j])].of) v += random.uniform();
      check(true);
    }
    for (auto& value : values)
      for (double& v : value.of) v *= 2;  // all of it
    check(false);
  }
}

TEST_CASE("each instruction set factors and solves four panels as plain loops do") {
  using namespace powbench::sim;
  std::vector<const FourKernel*> kernels{&portable_four_kernel()};
#ifdef __x86_64__
  if (__builtin_cpu_supports("avx2") && __builtin_cpu_supports("fma")) kernels.push_back(&avx2_four_kernel());
#endif
  const auto at = [](int i) { return static_cast<std::size_t>(i); };
  for (const auto* kernel : kernels)
    for (int m = 1; m < 24; m += 3)
      for (int n = 1; n <= m; n += n < 9 ? 1 : 7) {
        INFO(kernel->name << ", " << m << " x " << n);
        powbench::Random random(static_cast<std::uint64_t>(m * 100 + n));
        std::vector<Four> a(at(m * n)), update(packed_column(at(m - n), at(m - n)) + 1);
        for (int j = 0; j < n; ++j)
          for (int i = j; i < m; ++i)
            for (double& x : a[at(i + j * m)].of) x = random.uniform() - 0.5 + (i == j ? m : 0);
        auto l = a;
        REQUIRE(kernel->factor_panel(l.data(), m, n) == -1);
        kernel->square(update.data(), l.data() + n, m, m - n, n);
        double worst = 0;
        for (std::size_t p = 0; p < 4; ++p) {
          const auto entry = [&](int i, int j) {
            const double x = l[at(i + j * m)].of[p];
            return i == j ? 1 / x : x;
          };
          for (int j = 0; j < m; ++j)
            for (int i = j; i < m; ++i) {
              double sum = 0;
              for (int k = 0; k < std::min(n, j + 1); ++k) sum += entry(i, k) * entry(j, k);
              const double is = j < n ? a[at(i + j * m)].of[p]
                                      : -update[packed_column(at(m - n), at(j - n)) + at(i - j)].of[p];
              worst = std::max(worst, std::fabs(sum - is));
            }
        }
        CHECK(worst < 1e-12);
      }
}
