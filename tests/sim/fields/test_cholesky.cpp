#include <catch2/catch.hpp>
#include <cmath>
#include <vector>

#include "core/random.h"
#include "sim/fields/cholesky.h"

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
      for (auto& value : a.values) value *= 3;
    }
  }
}

TEST_CASE("a matrix that is not positive definite is refused") {
  Square a = square(10, -4.5);
  Cholesky cholesky(a.pattern);
  CHECK_FALSE(cholesky.factor(a.values.data()));
}
