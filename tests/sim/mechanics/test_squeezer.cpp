// Andrews' squeezing mechanism: seven bars, six constraints, from the Bari test set. The constraints are solved at
// the level of accelerations; the published positions at 0.03 s are the reference.

#include <catch2/catch.hpp>
#include <cmath>
#include <cstdio>
#include <utility>

#include "bench/mechanics/smooth.h"

namespace {

using namespace powbench::sim;

constexpr int bars = 7;
constexpr int unknowns = 13;

/// Lengths m, masses kg, inertias kg m2, spring N/m and m, drive N m.
struct Squeezer {
  double m[bars + 1] = {0, .04325, .00365, .02373, .00706, .07050, .00706, .05498};
  double in[bars + 1] = {0, 2.194e-6, 4.410e-7, 5.255e-6, 5.667e-7, 1.169e-5, 5.667e-7, 1.912e-5};
  double xa = -.06934, ya = -.00227, xb = -.03635, yb = .03273, xc = .014, yc = .072, c0 = 4530, l0 = .07785;
  double d = .028, da = .0115, e = .02, ea = .01421, rr = .007, ra = .00092, ss = .035, sa = .01874,
         sb = .01043;
  double sc = .018, sd = .02, ta = .02308, tb = .00916, u = .04, ua = .01228, ub = .00449, zf = .02, zt = .04;
  double fa = .01421, drive = .033;
};

void solve(double (&a)[unknowns][unknowns], double (&b)[unknowns]) {
  for (int c = 0; c < unknowns; ++c) {
    int p = c;
    for (int r = c + 1; r < unknowns; ++r)
      if (std::fabs(a[r][c]) > std::fabs(a[p][c])) p = r;
    for (int k = 0; k < unknowns; ++k) std::swap(a[c][k], a[p][k]);
    std::swap(b[c], b[p]);
    for (int r = c + 1; r < unknowns; ++r) {
      const double f = a[r][c] / a[c][c];
      for (int k = c; k < unknowns; ++k) a[r][k] -= f * a[c][k];
      b[r] -= f * b[c];
    }
  }
  for (int r = unknowns - 1; r >= 0; --r) {
    for (int k = r + 1; k < unknowns; ++k) b[r] -= a[r][k] * b[k];
    b[r] /= a[r][r];
  }
}

enum { be, th, ga, ph, de, om, ep };

void masses(const Squeezer& s, const double* q, double (&a)[unknowns][unknowns]) {
  const double ez = s.e - s.ea;
  const double zfa = s.zf - s.fa;
  const auto* m = s.m;
  const auto* in = s.in;
  a[be][be] = m[1] * s.ra * s.ra + m[2] * (s.rr * s.rr - 2 * s.da * s.rr * std::cos(q[th]) + s.da * s.da) +
              in[1] + in[2];
  a[be][th] = a[th][be] = m[2] * (s.da * s.da - s.da * s.rr * std::cos(q[th])) + in[2];
  a[th][th] = m[2] * s.da * s.da + in[2];
  a[ga][ga] = m[3] * (s.sa * s.sa + s.sb * s.sb) + in[3];
  a[ph][ph] = m[4] * ez * ez + in[4];
  a[ph][de] = a[de][ph] = m[4] * (ez * ez + s.zt * ez * std::sin(q[ph])) + in[4];
  a[de][de] = m[4] * (s.zt * s.zt + 2 * s.zt * ez * std::sin(q[ph]) + ez * ez) +
              m[5] * (s.ta * s.ta + s.tb * s.tb) + in[4] + in[5];
  a[om][om] = m[6] * zfa * zfa + in[6];
  a[om][ep] = a[ep][om] = m[6] * (zfa * zfa - s.u * zfa * std::sin(q[om])) + in[6];
  a[ep][ep] = m[6] * (zfa * zfa - 2 * s.u * zfa * std::sin(q[om]) + s.u * s.u) +
              m[7] * (s.ua * s.ua + s.ub * s.ub) + in[6] + in[7];
}

void loads(const Squeezer& s, const double* q, const double* v, double* b) {
  const double xd = s.sd * std::cos(q[ga]) + s.sc * std::sin(q[ga]) + s.xb;
  const double yd = s.sd * std::sin(q[ga]) - s.sc * std::cos(q[ga]) + s.yb;
  const double length = std::hypot(xd - s.xc, yd - s.yc);
  const double force = -s.c0 * (length - s.l0) / length;
  const double fx = force * (xd - s.xc);
  const double fy = force * (yd - s.yc);
  const double ez = s.e - s.ea;
  const double zfa = s.zf - s.fa;
  b[be] = s.drive - s.m[2] * s.da * s.rr * v[th] * (v[th] + 2 * v[be]) * std::sin(q[th]);
  b[th] = s.m[2] * s.da * s.rr * v[be] * v[be] * std::sin(q[th]);
  b[ga] = fx * (s.sc * std::cos(q[ga]) - s.sd * std::sin(q[ga])) +
          fy * (s.sd * std::cos(q[ga]) + s.sc * std::sin(q[ga]));
  b[ph] = s.m[4] * s.zt * ez * v[de] * v[de] * std::cos(q[ph]);
  b[de] = -s.m[4] * s.zt * ez * v[ph] * (v[ph] + 2 * v[de]) * std::cos(q[ph]);
  b[om] = -s.m[6] * s.u * zfa * v[ep] * v[ep] * std::cos(q[om]);
  b[ep] = s.m[6] * s.u * zfa * v[om] * (v[om] + 2 * v[ep]) * std::cos(q[om]);
}

/// Jacobian G of the six constraints into the matrix, and -G' v v into the right side.
void constraints(const Squeezer& s, const double* q, const double* v, double (&a)[unknowns][unknowns],
                 double* b) {
  const double sb = std::sin(q[be]), cb = std::cos(q[be]), sbt = std::sin(q[be] + q[th]),
               cbt = std::cos(q[be] + q[th]);
  const double sg = std::sin(q[ga]), cg = std::cos(q[ga]), sd = std::sin(q[de]), cd = std::cos(q[de]);
  const double spd = std::sin(q[ph] + q[de]), cpd = std::cos(q[ph] + q[de]);
  const double soe = std::sin(q[om] + q[ep]), coe = std::cos(q[om] + q[ep]), se = std::sin(q[ep]),
               ce = std::cos(q[ep]);
  double g[6][bars] = {};
  for (int row = 0; row < 6; row += 2) {
    g[row][be] = -s.rr * sb + s.d * sbt;
    g[row][th] = s.d * sbt;
    g[row + 1][be] = s.rr * cb - s.d * cbt;
    g[row + 1][th] = -s.d * cbt;
  }
  g[0][ga] = -s.ss * cg;
  g[1][ga] = -s.ss * sg;
  g[2][ph] = -s.e * cpd;
  g[2][de] = -s.e * cpd + s.zt * sd;
  g[3][ph] = -s.e * spd;
  g[3][de] = -s.e * spd - s.zt * cd;
  g[4][om] = s.zf * soe;
  g[4][ep] = s.zf * soe - s.u * ce;
  g[5][om] = -s.zf * coe;
  g[5][ep] = -s.zf * coe - s.u * se;
  const double bt = (v[be] + v[th]) * (v[be] + v[th]);
  const double pd = (v[ph] + v[de]) * (v[ph] + v[de]);
  const double oe = (v[om] + v[ep]) * (v[om] + v[ep]);
  const double wx = -s.rr * cb * v[be] * v[be] + s.d * cbt * bt;
  const double wy = -s.rr * sb * v[be] * v[be] + s.d * sbt * bt;
  const double w[6] = {wx + s.ss * sg * v[ga] * v[ga],
                       wy - s.ss * cg * v[ga] * v[ga],
                       wx + s.e * spd * pd + s.zt * cd * v[de] * v[de],
                       wy - s.e * cpd * pd + s.zt * sd * v[de] * v[de],
                       wx + s.zf * coe * oe + s.u * se * v[ep] * v[ep],
                       wy + s.zf * soe * oe - s.u * ce * v[ep] * v[ep]};
  for (int i = 0; i < 6; ++i) {
    for (int j = 0; j < bars; ++j) a[bars + i][j] = a[j][bars + i] = g[i][j];
    b[bars + i] = -w[i];
  }
}

}  // namespace

TEST_CASE("Andrews' squeezing mechanism at 0.03 s", "[mechanics]") {
  const Squeezer s;
  long calls = 0;
  Smooth<2 * bars> system;
  system.rate = [&](double, const double* y, double* dy) {
    ++calls;
    double a[unknowns][unknowns] = {};
    double b[unknowns] = {};
    masses(s, y, a);
    loads(s, y, y + bars, b);
    constraints(s, y, y + bars, a, b);
    solve(a, b);
    for (int i = 0; i < bars; ++i) {
      dy[i] = y[bars + i];
      dy[bars + i] = b[i];
    }
  };
  EventSolver solver(system, 1e-12, 1e-3);
  const double start[2 * bars] = {-0.0617138900142764496358948458001, 0,
                                  0.455279819163070380255912382449,   0.222668390165885884674473185609,
                                  0.487364979543842550225598953530,   -0.222668390165885884674473185609,
                                  1.23054744454982119249735015568};
  solver.restart(0, start, 1e-6);
  while (solver.end() < 0.03) REQUIRE(solver.extend());
  alignas(64) double y[EventSolver<Smooth<2 * bars>>::capacity] = {};
  solver.state(0.03, y);
  const double reference[bars] = {15.81077119629904,   -15.75637105984298, 0.04082224013073101,
                                  -0.5347301163226948, 0.5244099658805304, 0.5347301163226948,
                                  1.048080741042263};
  double worst = 0;
  for (int i = 0; i < bars; ++i)
    worst = std::max(worst, std::fabs(y[i] - reference[i]) / std::max(1.0, std::fabs(reference[i])));
  std::printf("  squeezer: largest error %.1e after %ld calls\n", worst, calls);
  CHECK(worst < 1e-9);
}
