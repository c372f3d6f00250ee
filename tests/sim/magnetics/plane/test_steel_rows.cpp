#include <algorithm>
#include <catch2/catch.hpp>
#include <cmath>
#include <cstdio>

#include "core/random.h"
#include "sim/magnetics/circuit/magnetic_circuit.h"
#include "sim/magnetics/steel_rows.h"

using namespace powbench::sim;
using Catch::Matchers::Contains;

namespace {

/// Even steps of log H from `from` to `to` A/m on a known curve, B off by `noise` T rms.
std::vector<BhRow> measured(const Steel& truth, double from, double to, int count, double noise,
                            std::uint64_t seed) {
  powbench::Random random(seed);
  std::vector<BhRow> rows;
  for (int k = 0; k < count; ++k) {
    const double h = from * std::pow(to / from, static_cast<double>(k) / (count - 1));
    rows.push_back({flux_density(truth, h) + noise * random.normal(), h});
  }
  return rows;
}

std::vector<BhRow> scaled(std::vector<BhRow> rows, double b, double h) {
  for (auto& r : rows) {
    r.b *= b;
    r.h *= h;
  }
  return rows;
}

}  // namespace

TEST_CASE("rows without noise stay as they are, whatever their order") {
  const auto rows = measured(builtin_steel("team20"), 20, 2e4, 30, 0, 1);
  auto turned = rows;
  std::reverse(turned.begin(), turned.end());
  const auto f = fit_rows(turned);
  CHECK_FALSE(f.smoothed);
  CHECK(f.rms == 0);
  REQUIRE(f.rows.size() == rows.size());
  for (std::size_t k = 0; k < rows.size(); ++k) CHECK(f.rows[k].b == rows[k].b);
}

TEST_CASE(
    "noise is taken out: the curve is nearer to the truth than the rows, and the residual is the noise") {
  // the truths are the curves of steels; seeds and sizes of noise of this test were not used to choose the steps of
  // the fit
  for (const char* name : {"team13", "team20", "lamination", "reference"})
    for (const double noise : {0.005, 0.02}) {
      const Steel truth = builtin_steel(name);
      double squares = 0, residual = 0;
      int count = 0;
      for (std::uint64_t seed = 101; seed < 106; ++seed) {
        const auto rows = measured(truth, 30, 1e4, 60, noise, seed);
        const auto f = fit_rows(rows);
        CHECK(f.smoothed);
        residual += f.rms / 5;
        const Steel curve = Steel::table("fit", f.rows);
        for (const auto& r : rows) {
          squares += std::pow(flux_density(curve, r.h) - flux_density(truth, r.h), 2);
          ++count;
        }
      }
      INFO(name << ", noise " << noise);
      const double error = std::sqrt(squares / count);
      std::printf("%s, noise %.0f mT: curve %.2f, residual %.2f of the noise\n", name, 1e3 * noise,
                  error / noise, residual / noise);
      CHECK(error < 0.75 * noise);
      CHECK(residual > 0.6 * noise);  // the fit follows some of the noise
      CHECK(residual < 1.1 * noise);
    }
}

TEST_CASE("many rows, and several at the same field") {
  const Steel truth = builtin_steel("lamination");
  auto rows = measured(truth, 10, 1e4, 2000, 0.01, 7);
  for (int k = 0; k < 40; ++k) rows.push_back({flux_density(truth, 500) + 0.001 * (k - 20), 500});
  const auto f = fit_rows(rows);
  CHECK(f.rms == Approx(0.01).epsilon(0.1));
  const Steel curve = Steel::table("fit", f.rows);
  for (const double h : {30.0, 100.0, 500.0, 2000.0, 8000.0})
    CHECK(flux_density(curve, h) == Approx(flux_density(truth, h)).margin(0.012));
}

TEST_CASE("loops, branches and clouds are no curve") {
  auto rows = measured(builtin_steel("team13"), 50, 1e4, 40, 0.005, 3);
  auto loop = rows;
  for (const auto& r : rows) loop.push_back({-r.b, -r.h});
  CHECK_THROWS_WITH(fit_rows(loop), Contains("a loop"));
  auto branch = rows;
  branch.insert(branch.begin(), {0.9, 0});
  CHECK_THROWS_WITH(fit_rows(branch), Contains("a branch of a loop"));
  auto cloud = rows;
  for (std::size_t k = 0; k < cloud.size(); k += 2) cloud[k].b *= 0.6;
  CHECK_THROWS_WITH(fit_rows(cloud), Contains("misses the rows by") && Contains("allowed up to 3 %"));
  CHECK_THROWS_WITH(fit_rows({{0, 0}, {1, 200}, {1.5, 1000}}), Contains("at least 4"));
}

TEST_CASE("a slip of unit is found, and the units that would fit are named") {
  for (const char* name : {"team13", "team20", "lamination", "reference"}) {
    INFO(name);
    const auto rows = measured(builtin_steel(name), 30, 1e4, 40, 0.01, 5);
    CHECK(doubt_units(rows).empty());
    CHECK_THAT(doubt_units(scaled(rows, 1, 1e-3)),
               Contains("allowed up to 1.5e+05") && Contains("fit H in kA/m"));
    CHECK_THAT(doubt_units(scaled(rows, 1e4, 1)),
               Contains("iron saturates at 2.2 T") && Contains("fit B in G"));
    CHECK_THAT(doubt_units(scaled(rows, 1e3, 1)), Contains("B in mT"));
    CHECK_THAT(doubt_units(scaled(rows, 1, 1e3)), Contains("allowed from"));
    auto swapped = rows;
    for (auto& r : swapped) std::swap(r.b, r.h);
    CHECK_THAT(doubt_units(swapped), Contains("would fit") && Contains("the columns swapped"));
  }
  // J in the place of B, far into saturation
  std::vector<BhRow> polarised;
  for (const auto& r : measured(builtin_steel("team20"), 30, 3e5, 40, 0, 5))
    polarised.push_back({r.b - mu0 * r.h, r.h});
  CHECK_THAT(doubt_units(polarised), Contains("saturation does not fall") && Contains("J (T)"));
}
