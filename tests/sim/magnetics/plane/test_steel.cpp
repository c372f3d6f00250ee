#include <algorithm>
#include <catch2/catch.hpp>
#include <cmath>
#include <cstdio>

#include "sim/magnetics/circuit/magnetic_circuit.h"
#include "sim/magnetics/steel.h"
#include "sim/magnetics/steel_rows.h"

using powbench::sim::BhRow;
using powbench::sim::mu0;
using powbench::sim::Steel;

TEST_CASE("every built-in steel says where its numbers come from") {
  for (const auto& name : powbench::sim::builtin_steel_names())
    CHECK(powbench::sim::builtin_steel_source(name).find("measure") != std::string::npos);
}

TEST_CASE("every built-in steel rises strictly, never faster than vacuum, smoothly to 6 T") {
  for (const auto& name : powbench::sim::builtin_steel_names()) {
    INFO(name);
    const Steel s = powbench::sim::builtin_steel(name);
    double worst_jump = 0, energy = 0;
    constexpr double step = 1e-5;
    auto last = s.at(0);
    for (double b = step; b < 6; b += step) {
      const auto p = s.at(b);
      if (!(p.dh_db > 0) || p.dh_db > (1 + 1e-9) / mu0 || !(p.h > last.h)) {
        FAIL("dH/dB = " << p.dh_db << " at B = " << b);
      }
      worst_jump = std::max(worst_jump, std::fabs(p.dh_db - last.dh_db) * mu0);
      energy += 0.5 * step * (p.h + last.h);
      last = p;
    }
    CHECK(worst_jump < 2e-3);
    CHECK(last.energy == Approx(energy).epsilon(1e-6));
    CHECK(s.dh_db(5) == Approx(1 / mu0));
    CHECK(s.h(-1.2) == -s.h(1.2));
  }
}

TEST_CASE("the analytic steel keeps its law") {
  const Steel s = powbench::sim::builtin_steel("reference");
  CHECK(s.straight_from() == Approx(2.16084356878).epsilon(1e-9));
  CHECK(s.h(s.straight_from()) == Approx(96757.237251622).epsilon(1e-9));
  for (const double b : {0.01, 0.3, 1.0, 1.7, 2.1})
    CHECK(s.h(b) == Approx(b * (100 + 10 * std::exp(1.8 * b * b))).epsilon(1e-8));
  CHECK(s.h(4) == Approx(96757.237251622 + (4 - 2.16084356878) / mu0).epsilon(1e-9));
}

TEST_CASE("tables go through their rows, and far above them the magnetisation stays") {
  const Steel s = powbench::sim::builtin_steel("team13");
  CHECK(s.h(1.5) == Approx(933));
  CHECK(s.h(0.0125) == Approx(54));
  CHECK(4 - mu0 * s.h(4) == Approx(2.16).epsilon(2e-3));
  const Steel t = powbench::sim::builtin_steel("team20");
  CHECK(t.h(1.8) == Approx(10100));
  CHECK(4 - mu0 * t.h(4) == Approx(2.16).epsilon(2e-3));
}

TEST_CASE("a table that starts late and ends below saturation is continued at both ends") {
  const Steel s = Steel::table("short", {{1.2, 400}, {1.4, 900}, {1.5, 2000}, {1.6, 4000}});
  CHECK(s.h(0.6) > 0);
  CHECK(s.data_end() == 1.6);
  const double saturation = 4 - mu0 * s.h(4);
  CHECK(saturation > 1.6);
  CHECK(saturation < 2.6);
}

TEST_CASE("a curve cut at 1.5 .. 1.8 T is continued as the steel itself goes on") {
  // measured curves that go on, cut short; the same curves to their end are the truth
  double squares[3] = {}, worst[3] = {};
  int count = 0;
  for (const char* name :
       {"team13", "team20", "m350-50a", "m530-50a", "m700-100a", "m940-100a", "aisi1008", "9smnpb28"})
    for (const double cut : {1.5, 1.6, 1.7, 1.8}) {
      const Steel whole = powbench::sim::builtin_steel(name);
      std::vector<BhRow> rows;
      for (const auto& k : whole.knots())
        if (k.b <= cut + 1e-9) rows.push_back({k.b, k.h});
      const Steel part = Steel::table("cut", rows);
      int far = 0;
      for (const double times : {2.0, 4.0, 10.0}) {
        const double h = times * rows.back().h;
        const double miss = powbench::sim::flux_density(part, h) / powbench::sim::flux_density(whole, h) - 1;
        squares[far] += miss * miss;
        worst[far] = std::max(worst[far], std::fabs(miss));
        ++far;
      }
      ++count;
    }
  const auto rms = [&](int far) { return 100 * std::sqrt(squares[far] / count); };
  std::printf(
      "beyond the last row: at 2, 4, 10 times its H the flux density is %.1f, %.1f, %.1f %% off rms, %.1f, "
      "%.1f, "
      "%.1f %% at most\n",
      rms(0), rms(1), rms(2), 100 * worst[0], 100 * worst[1], 100 * worst[2]);
  CHECK(rms(0) < 1.0);  // an exponential end of the susceptibility is 1.2, 3.6, 8.3 % off
  CHECK(rms(1) < 3.0);
  CHECK(rms(2) < 7.0);
}

TEST_CASE("bad rows are named") {
  using Catch::Matchers::Contains;
  CHECK_THROWS_WITH(Steel::table("x", {{0, 0}, {0.5, 100}, {0.4, 120}, {1, 200}}),
                    Contains("row 3") && Contains("B must"));
  CHECK_THROWS_WITH(Steel::table("x", {{0, 0}, {0.5, 100}, {0.8, 90}, {1, 200}}),
                    Contains("row 3") && Contains("H must"));
  CHECK_THROWS_WITH(Steel::table("x", {{0, 0}, {0.5, 100}, {0.6, 400}, {1, 450}, {1.5, 3000}}),
                    Contains("row"));
  CHECK_THROWS_WITH(Steel::table("x", {{0, 0}, {0.5, 100}, {0.6, 100000}, {1, 500000}}),
                    Contains("above 1/mu0"));
  CHECK_THROWS_WITH(Steel::table("x", {{0, 0}, {1, 100}}), Contains("2 rows"));
  CHECK_THROWS_WITH(powbench::sim::builtin_steel("wood"), Contains("team20"));
}

TEST_CASE("noise and falling rows are refused with the row that is wrong, not smoothed") {
  using Catch::Matchers::Contains;
  const auto curve = [](std::size_t row, double factor) {
    std::vector<BhRow> rows;
    const Steel good = powbench::sim::builtin_steel("team13");
    for (const double b : {0.2, 0.4, 0.6, 0.8, 1.0, 1.2, 1.4, 1.6, 1.8}) rows.push_back({b, good.h(b)});
    rows[row].h *= factor;
    return rows;
  };
  CHECK_NOTHROW(Steel::table("x", curve(3, 1)));
  CHECK_THROWS_WITH(Steel::table("x", curve(4, 0.5)), Contains("row 5") && Contains("H must"));
  CHECK_THROWS_WITH(Steel::table("x", curve(8, 0.2)), Contains("row 9") && Contains("H must"));
  CHECK_THROWS_WITH(Steel::table("x", curve(5, 2)), Contains("row"));  // up, then slower than before
}

TEST_CASE("to 4 T and on the curve rises by vacuum, and the energy is its integral") {
  for (const char* name : {"team13", "team20", "lamination", "reference", "power"}) {
    const Steel s = powbench::sim::builtin_steel(name);
    INFO(name);
    const double from = std::max(s.straight_from(), 3.0);
    CHECK(s.h(from + 1) - s.h(from) == Approx(1 / mu0));
    double sum = 0;
    constexpr int steps = 40000;
    for (int k = 0; k < steps; ++k) sum += s.h(4.0 * (k + 0.5) / steps) * 4.0 / steps;
    CHECK(s.energy(4) == Approx(sum).epsilon(1e-6));
  }
}

TEST_CASE("a stack carries iron and insulation side by side") {
  const Steel s = powbench::sim::builtin_steel("reference");
  const Steel stack = s.stacked(0.9);
  for (const double b : {0.5, 1.5, 2.0}) {
    const double h = s.h(b);
    CHECK(stack.h(0.9 * b + 0.1 * mu0 * h) == Approx(h).epsilon(1e-6));
  }
  CHECK_THROWS_AS(s.stacked(0), std::invalid_argument);
}
