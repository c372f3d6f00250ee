// The tableau against all order conditions: rooted trees are made one order after the other, and for each the
// elementary weight must be 1 over its density.

#include <catch2/catch.hpp>
#include <cmath>
#include <vector>

#include "sim/mechanics/crossing.h"
#include "sim/mechanics/dop853.h"

namespace {

namespace rk = powbench::sim::dop853;

/// A rooted tree: its sub-trees by index into the list of all trees, in rising order so that each appears once.
struct Tree {
  std::vector<int> children;
  int order = 1;
  long double density = 1;
  std::vector<long double>
      inner;  ///< product over the children of sum_j a_ij (their product at j), per slope
};

long double dot(const long double* row, const std::vector<long double>& v) {
  long double sum = 0;
  for (int j = 0; j < rk::slopes; ++j) sum += row[j] * v[static_cast<std::size_t>(j)];
  return sum;
}

void add_trees(std::vector<Tree>& all, Tree partial, int missing, int smallest) {
  if (missing == 0) {
    partial.density = partial.order;
    partial.inner.assign(rk::slopes, 1);
    for (const int c : partial.children) {
      const auto& child = all[static_cast<std::size_t>(c)];
      partial.density *= child.density;
      for (int i = 0; i < rk::slopes; ++i)
        partial.inner[static_cast<std::size_t>(i)] *= dot(rk::a[i], child.inner);
    }
    all.push_back(partial);
    return;
  }
  for (int c = smallest; c < static_cast<int>(all.size()); ++c) {
    const int order = all[static_cast<std::size_t>(c)].order;
    if (order > missing) break;
    Tree next = partial;
    next.children.push_back(c);
    next.order += order;
    add_trees(all, next, missing - order, c);
  }
}

std::vector<Tree> trees_up_to(int order) {
  std::vector<Tree> all;
  for (int n = 1; n <= order; ++n) {
    std::vector<Tree> more = all;
    const std::size_t before = all.size();
    add_trees(more, {}, n - 1, 0);
    all.insert(all.end(), more.begin() + static_cast<std::ptrdiff_t>(before), more.end());
  }
  return all;
}

}  // namespace

TEST_CASE("the 8(5,3) tableau fulfils the 200 conditions of order 8", "[mechanics]") {
  const auto trees = trees_up_to(8);
  REQUIRE(trees.size() == 200);
  long double worst = 0;
  long double embedded5 = 0;
  long double embedded3 = 0;
  for (const auto& t : trees) {
    worst = std::max(worst, std::fabs(dot(rk::a[12], t.inner) * t.density - 1));
    long double e5 = 0;
    long double e3 = 0;
    for (int j = 0; j < rk::stages; ++j) {
      e5 += rk::error5[j] * t.inner[static_cast<std::size_t>(j)];
      e3 += rk::error3[j] * t.inner[static_cast<std::size_t>(j)];
    }
    if (t.order <= 5) embedded5 = std::max(embedded5, std::fabs(e5));
    if (t.order <= 3) embedded3 = std::max(embedded3, std::fabs(e3));
  }
  CAPTURE(worst, embedded5, embedded3);
  CHECK(worst < 1e-16L);
  CHECK(embedded5 < 1e-17L);
  CHECK(embedded3 < 1e-17L);
}

TEST_CASE("rows of the tableau sum to their instants", "[mechanics]") {
  for (int i = 1; i < rk::slopes; ++i) {
    long double sum = 0;
    for (int j = 0; j < rk::slopes; ++j) sum += rk::a[i][j];
    CHECK(static_cast<double>(std::fabs(sum - rk::c[i])) < 2e-18);
  }
}

TEST_CASE("a grazing double root inside a step is found", "[mechanics]") {
  using powbench::sim::first_crossing;
  using powbench::sim::quintic;
  for (const double at : {0.11, 0.5, 0.7351}) {
    const auto graze = [&](double depth) {
      const auto value = [&](double t) { return (t - at) * (t - at) - depth; };
      const auto rate = [&](double t) { return 2 * (t - at); };
      return first_crossing(quintic(value(0), rate(0), 2.0, value(1), rate(1), 2.0));
    };
    const auto hit = graze(1e-12);
    REQUIRE(hit.found);
    CHECK(hit.low <= at - 1e-6 + 1e-9);
    CHECK(hit.high >= at - 1e-6 - 1e-9);
    CHECK((hit.high - at) * (hit.high - at) - 1e-12 < 0);
    CHECK_FALSE(graze(-1e-12).found);
  }
}

TEST_CASE("the lowest place of a function known by its slopes is found, where it matters", "[mechanics]") {
  using powbench::sim::lowest_share;
  for (const double at : {0.03, 0.4, 0.5, 0.97})
    for (const double bend : {0.0, 0.6, -0.6}) {  // cubic with its minimum at `at`
      const auto low = [&](double depth) {
        const auto value = [&](double t) { return (t - at) * (t - at) * (1 + bend * (t - at)) - depth; };
        const auto rate = [&](double t) { return 2 * (t - at) + 3 * bend * (t - at) * (t - at); };
        return lowest_share(value(0), rate(0), value(1), rate(1));
      };
      CHECK(low(1e-9) == Approx(at).epsilon(1e-9));
      CHECK(low(0.0) == Approx(at).epsilon(1e-9));
      CHECK(low(-0.5) == 2);  // far above zero
    }
  CHECK(lowest_share(1.0, -0.5, 0.5, -0.5) == 2);  // falls all the way: the ends say it
  CHECK(lowest_share(1.0, 0.0, 1.0, 0.0) == 2);
  CHECK(lowest_share(0.0, 1.0, 1.0, 1.0) == 2);
}

TEST_CASE("the first of several crossings is found, and a start on the event does not count", "[mechanics]") {
  using powbench::sim::first_crossing;
  using powbench::sim::quintic;
  // cubic with zeros at 0.2, 0.5 and 0.9, falling first
  const auto value = [](double t) { return -(t - 0.2) * (t - 0.5) * (t - 0.9); };
  const auto rate = [](double t) {
    return -((t - 0.5) * (t - 0.9) + (t - 0.2) * (t - 0.9) + (t - 0.2) * (t - 0.5));
  };
  const auto curve = [](double t) { return -2 * (3 * t - 1.6); };
  const auto hit = first_crossing(quintic(value(0), rate(0), curve(0), value(1), rate(1), curve(1)));
  REQUIRE(hit.found);
  CHECK(hit.low <= 0.2);
  CHECK(hit.high >= 0.2);
  CHECK(hit.high < 0.5);
  CHECK_FALSE(first_crossing(quintic(-1e-18, 1.0, 0.0, 1.0, 1.0, 0.0)).found);
}
