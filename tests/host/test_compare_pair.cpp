#include <catch2/catch.hpp>
#include <cmath>

#include "core/random.h"
#include "host/compare/pair.h"
#include "host/compare/repeats.h"

using namespace powbench;
using namespace powbench::host;

namespace {

ComparisonRow row(double angle, double value, double u, double dof, int n) {
  ComparisonRow r;
  r.quantity = "t_ct1", r.unit = "s";
  r.closing_angle = angle;
  r.measured = {value, u};
  r.dof = dof;
  r.repeats = n;
  return r;
}

}  // namespace

TEST_CASE("pair: U of the difference from both uncertainties, k by the combined degrees of freedom",
          "[compare]") {
  // equal u and 4 degrees of freedom each: 8 together, k = 2.366416
  const auto rows =
      compare_pair({{row(1, 10e-3, 3e-6, 4, 5)}}, {{row(1, 10.02e-3, 3e-6, 4, 5), row(2, 9e-3, 1e-6, 4, 5)}});
  REQUIRE(rows.size() == 2);
  CHECK(rows[0].difference == Approx(20e-6));
  CHECK(rows[0].U == Approx(2.366416 * std::sqrt(2.0) * 3e-6).epsilon(1e-6));
  CHECK(rows[0].over_U() == Approx(20e-6 / rows[0].U));
  CHECK(rows[1].n[0] == 0);  // only the second campaign has this angle
  CHECK(std::isnan(rows[1].difference));
  CHECK(std::isnan(rows[1].over_U()));
}

TEST_CASE("pair: a value without an uncertainty, or none at all, leaves the difference open", "[compare]") {
  const double none = std::nan("");
  const double known = std::numeric_limits<double>::infinity();
  for (const ComparisonRow& other : {row(1, 10e-3, none, known, 1), row(1, none, none, known, 0)})
    for (const auto& rows : {compare_pair({{row(1, 10e-3, 3e-6, 4, 5)}}, {{other}}),
                             compare_pair({{other}}, {{row(1, 10e-3, 3e-6, 4, 5)}})}) {
      REQUIRE(rows.size() == 1);
      CHECK(std::isnan(rows[0].U));
      CHECK(agreement(rows[0].over_U()) == "not known");
    }
}

TEST_CASE("pair: each side keeps its own number of repeats and its own coverage factor", "[compare]") {
  ComparisonRow a = row(1, 10e-3, 3e-6, 4, 5), b = row(1, 10.02e-3, 2e-6, 2, 3);
  a.coverage = 2.87, b.coverage = 4.53;
  const auto rows = compare_pair({{a}}, {{b}});
  REQUIRE(rows.size() == 1);
  CHECK(rows[0].n[0] == 5);
  CHECK(rows[0].n[1] == 3);
  CHECK(rows[0].k[0] == 2.87);
  CHECK(rows[0].k[1] == 4.53);
}

TEST_CASE("pair: repeats that are all equal and have no u of their own leave U at zero", "[compare]") {
  const double known = std::numeric_limits<double>::infinity();
  const auto rows = compare_pair({{row(1, 10e-3, 0, known, 3)}}, {{row(1, 11e-3, 0, known, 3)}});
  REQUIRE(rows.size() == 1);
  CHECK(rows[0].difference == Approx(1e-3));
  CHECK(rows[0].U == 0);
  CHECK(agreement(rows[0].over_U()) == "not known");
}

TEST_CASE("pair: of two campaigns of one device 4.55 % are told apart", "[compare]") {
  Random random(5);
  const int trials = 4000;
  int told = 0;
  for (int i = 0; i < trials; ++i) {
    Comparison c[2];
    for (int k = 0; k < 2; ++k) {
      std::vector<Measured> repeats;
      for (int n = 0; n < 3 + 4 * k; ++n) repeats.push_back({random.normal() * (1 + 2 * k), 0.0});
      const Repeats r = repeats_of(repeats);
      c[k].rows = {row(0, r.mean, r.u, r.dof, r.n)};
    }
    told += compare_pair(c[0], c[1]).front().over_U() > 1;
  }
  CHECK(told > 0.035 * trials);
  CHECK(told < 0.065 * trials);
}
