#include <catch2/catch.hpp>
#include <cmath>
#include <cstdio>

#include "bench/fields/contactor.h"
#include "core/random.h"
#include "sim/magnetics/plane/table_build.h"
#include "sim/specimen/specimen_potential.h"

using namespace powbench::sim;

/// What a table answers beyond its last flux and its last gap.

namespace {

MagnetDesign contactor(bool ring) {
  auto design = powbench::bench::reference_contactor();
  design.turns = 1000;
  design.residual_gap = 20e-6;
  if (ring) design.shape.ring_share = 0.6;
  return design;
}

PotentialTable table_to(double gap, double field, bool ring = false) {
  TableOptions o;
  o.accuracy = 0.02;
  o.psi_nodes = ring ? 14 : 24;
  o.gap_nodes = ring ? 10 : 20;
  o.ring_nodes = 14;
  o.ring = ring;
  o.largest_gap = gap;
  o.largest_field = field;
  Team team(2);
  return build_table(contactor(ring), o, team);
}

const TablePotential& with_ring() {
  static const TablePotential table(table_to(4e-3, 2.2, true));
  return table;
}

constexpr double MagneticResponse::*second[] = {
    &MagneticResponse::current_psi,  &MagneticResponse::current_gap, &MagneticResponse::pull_gap,
    &MagneticResponse::current_ring, &MagneticResponse::ring_ring,   &MagneticResponse::ring_gap};

/// Second derivatives on both sides of an edge.
void check_smooth(const TablePotential& t, const MagneticState& in, const MagneticState& out) {
  const auto a = t.at(in), b = t.at(out);
  CHECK_FALSE(a.beyond);
  CHECK(b.beyond);
  for (const auto f : second) CHECK(b.*f == Approx(a.*f).epsilon(1e-5).margin(1e-6));
}

}  // namespace

TEST_CASE("beyond the last flux and the last gap a table goes on without a jump of its second derivatives") {
  const TablePotential t(table_to(6e-3, 2.4));
  const double psi = t.table().psi.back(), gap = t.table().gap.back();
  constexpr double e = 1e-9;
  for (const double share : {0.02, 0.3, 0.77, 0.99}) {
    check_smooth(t, {psi * (1 - e), 0, share * gap}, {psi * (1 + e), 0, share * gap});
    check_smooth(t, {share * psi, 0, gap * (1 - e)}, {share * psi, 0, gap * (1 + e)});
  }
  const auto& r = with_ring();
  const double p = r.table().psi.back(), q = r.table().ring.back(), g = r.table().gap.back();
  for (const double share : {0.1, 0.6}) {
    check_smooth(r, {p * (1 - e), share * q, share * g}, {p * (1 + e), share * q, share * g});
    check_smooth(r, {share * p, q * (1 - e), share * g}, {share * p, q * (1 + e), share * g});
    check_smooth(r, {share * p, -q * (1 - e), share * g}, {share * p, -q * (1 + e), share * g});
    check_smooth(r, {share * p, share * q, g * (1 - e)}, {share * p, share * q, g * (1 + e)});
  }
}

TEST_CASE("with the ring, too, the answers beyond the edges are derivatives of one energy") {
  const auto& t = with_ring();
  const double p = t.table().psi.back(), q = t.table().ring.back(), g = t.table().gap.back();
  for (const MagneticState s :
       {MagneticState{1.3 * p, 0.2 * q, 0.4 * g}, MagneticState{0.6 * p, -1.4 * q, 0.4 * g},
        MagneticState{1.2 * p, 1.3 * q, 1.5 * g}, MagneticState{0.5 * p, 0.3 * q, 2 * g}}) {
    const auto r = t.at(s);
    const auto slope = [&](double MagneticState::*axis, double step, double MagneticResponse::*f) {
      auto a = s, b = s;
      a.*axis -= step;
      b.*axis += step;
      return (t.at(b).*f - t.at(a).*f) / (2 * step);
    };
    constexpr double dp = 1e-6, dr = 1e-9, dg = 1e-8;
    INFO("psi " << s.psi << " ring " << s.ring << " gap " << s.gap);
    CHECK(slope(&MagneticState::psi, dp, &MagneticResponse::energy) == Approx(r.current).epsilon(1e-5));
    CHECK(slope(&MagneticState::ring, dr, &MagneticResponse::energy) == Approx(r.ring_current).epsilon(1e-5));
    CHECK(slope(&MagneticState::gap, dg, &MagneticResponse::energy) == Approx(r.pull).epsilon(1e-5));
    CHECK(slope(&MagneticState::psi, dp, &MagneticResponse::current) == Approx(r.current_psi).epsilon(1e-4));
    CHECK(slope(&MagneticState::ring, dr, &MagneticResponse::current) ==
          Approx(r.current_ring).epsilon(1e-4).margin(1e-4));
    CHECK(slope(&MagneticState::ring, dr, &MagneticResponse::ring_current) ==
          Approx(r.ring_ring).epsilon(1e-4));
    CHECK(slope(&MagneticState::gap, dg, &MagneticResponse::current) ==
          Approx(r.current_gap).epsilon(1e-4).margin(1e-2));
    CHECK(slope(&MagneticState::gap, dg, &MagneticResponse::ring_current) ==
          Approx(r.ring_gap).epsilon(1e-4).margin(1));
    CHECK(slope(&MagneticState::gap, dg, &MagneticResponse::pull) ==
          Approx(r.pull_gap).epsilon(1e-4).margin(1));
  }
}

TEST_CASE("half the gap beyond the last one the pull is that of a longer table") {
  const TablePotential t(table_to(6e-3, 2.4)), truth(table_to(10e-3, 2.4));
  double pull = 0, current = 0, straight = 0;
  const double psi = t.table().psi.back();
  for (const double share : {0.1, 0.3, 0.5, 0.7, 0.9})
    for (const double gap : {7e-3, 8e-3, 9e-3}) {
      const auto a = t.at({share * psi, 0, gap}), b = truth.at({share * psi, 0, gap});
      pull = std::max(pull, std::fabs(a.pull / b.pull - 1));
      current = std::max(current, std::fabs(a.current / b.current - 1));
      straight = std::max(straight, std::fabs(t.at({share * psi, 0, 6e-3}).pull / b.pull - 1));
      CHECK(a.beyond);
      CHECK(a.current_psi > 0);
    }
  std::printf("to 1.5 times the last gap: pull %.1f %% off (the last one's: %.0f %%), current %.2f %%\n",
              100 * pull, 100 * straight, 100 * current);
  CHECK(pull < 0.15);
  CHECK(current < 0.02);
  for (const double gap : {20e-3, 0.1, 1.0, 1e3})
    for (const double share : {0.05, 0.5, 1.0, 1.5}) {
      const auto r = t.at({share * psi, 0, gap});
      CHECK(r.pull >= 0);
      CHECK(r.current_psi > 0);
    }
}

TEST_CASE("beyond the last flux current and pull are those of a table to a higher field") {
  const TablePotential truth(table_to(6e-3, 4.0));
  const auto compare = [&](double field, double& current, double& pull, double& air) {
    const TablePotential t(table_to(6e-3, field));
    const double psi = t.table().psi.back();
    for (const double times : {1.05, 1.1, 1.2, 1.35, 1.5})
      for (const double gap : {0.0, 0.5e-3, 2e-3, 5e-3}) {
        const auto a = t.at({times * psi, 0, gap}), b = truth.at({times * psi, 0, gap});
        current = std::max(current, std::fabs(a.current / b.current - 1));
        pull = std::max(pull, std::fabs(a.pull / b.pull - 1));
        if (gap > 0) continue;  // as if the steel were air from the edge on
        const double straight = t.at({psi, 0, gap}).current + t.table().air[0] * (times - 1) * psi;
        air = std::max(air, std::fabs(straight / b.current - 1));
      }
  };
  double current = 0, pull = 0, air = 0, early_current = 0, early_pull = 0, early_air = 0;
  compare(2.4, current, pull, air);
  compare(2.0, early_current, early_pull, early_air);
  std::printf(
      "to 1.5 times the last flux, from 2.4 T: current %.1f %% off (steel as air at once: %.0f %%), pull "
      "%.1f %%\n",
      100 * current, 100 * air, 100 * pull);
  std::printf(
      "                            from 2.0 T: current %.1f %% off (steel as air at once: %.0f %%), pull "
      "%.1f %%\n",
      100 * early_current, 100 * early_air, 100 * early_pull);
  CHECK(current < 0.03);
  CHECK(pull < 0.12);
  CHECK(early_current < 0.33);
  CHECK(early_pull < 0.3);
}

TEST_CASE("both polarities give the same bits") {
  const TablePotential t(table_to(6e-3, 2.4));
  const SpecimenPotential circuit{Specimen{}};
  powbench::Random random(11);
  for (const MagneticPotential* p :
       {static_cast<const MagneticPotential*>(&t), static_cast<const MagneticPotential*>(&with_ring()),
        static_cast<const MagneticPotential*>(&circuit)})
    for (int k = 0; k < 400; ++k) {
      const double psi = k % 8 == 0 ? 0.0 : 3 * random.uniform() - 1.5;
      const double ring = k % 16 == 8 ? 0.0 : 3e-3 * (random.uniform() - 0.5);
      const double gap = 9e-3 * random.uniform();
      const auto a = p->at({psi, ring, gap}), b = p->at({-psi, -ring, gap});
      REQUIRE(a.energy == b.energy);
      REQUIRE(a.pull == b.pull);
      REQUIRE(a.current == -b.current);
      REQUIRE(a.ring_current == -b.ring_current);
      REQUIRE(a.current_psi == b.current_psi);
      REQUIRE(a.current_gap == -b.current_gap);
      REQUIRE(a.ring_gap == -b.ring_gap);
      REQUIRE(a.pull_gap == b.pull_gap);
    }
}
