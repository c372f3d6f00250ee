// Results do not depend on how bridges, contacts and base modes are numbered: not by one bit.

#include <algorithm>
#include <array>
#include <catch2/catch.hpp>
#include <cstdio>
#include <cstring>

#include "bench/mechanics/reference_closing.h"
#include "sim/mechanics/canonical_order.h"
#include "sim/models/rigid_run.h"

namespace {

using namespace powbench::sim;
using Order = std::array<int, 5>;

/// New bridge j is old bridge order[j]; with `modes` the base modes come in reverse.
RigidParts renumbered(const RigidParts& parts, const Order& order, bool modes) {
  auto turned = parts;
  for (std::size_t j = 0; j < order.size(); ++j) {
    const auto from = static_cast<std::size_t>(order[j]);
    turned.bridges[j] = parts.bridges[from];
    for (std::size_t m = 0; m < parts.modes.size(); ++m)
      for (int end = 0; end < 2; ++end) turned.modes[m].shape[j][end] = parts.modes[m].shape[from][end];
  }
  if (modes) std::reverse(turned.modes.begin(), turned.modes.end());
  return turned;
}

/// The contact's number before renumbering.
int former(int contact, const Order& order) {
  if (contact >= core_group * rigid_lanes) return contact;
  const auto bridge = static_cast<std::size_t>(contact % rigid_lanes);
  return contact - contact % rigid_lanes + order[bridge];
}

bool same_bits(double a, double b) {
  return std::memcmp(&a, &b, sizeof a) == 0;
}

void check_equal(const RigidRun& a, const RigidRun& b, const Order& order) {
  REQUIRE(a.completed);
  REQUIRE(b.completed);
  CHECK(a.steps == b.steps);
  REQUIRE(a.events.size() == b.events.size());
  std::size_t different = 0;
  for (std::size_t k = 0; k < a.events.size(); ++k) {
    const auto& e = a.events[k];
    const auto& f = b.events[k];
    different += e.contact != former(f.contact, order) || e.closes != f.closes ||
                 !same_bits(e.time, f.time) || !same_bits(e.speed, f.speed);
  }
  CHECK(different == 0);
  CHECK(same_bits(a.energy_residual, b.energy_residual));
  CHECK(same_bits(a.energies.contact_loss, b.energies.contact_loss));
}

}  // namespace

TEST_CASE("bridges and modes in any order: equal bits of every event", "[mechanics]") {
  const auto parts = powbench::bench::reference_closing();
  RigidOptions o;
  o.tolerance = 1e-7;
  const auto base = run_rigid(parts, {}, o);
  const auto bounces = std::count_if(base.events.begin(), base.events.end(), [](const RigidEvent& e) {
    return contact_place(e.contact).kind == ContactKind::pad;
  });
  CHECK(bounces > 100);
  for (const Order order : {Order{3, 1, 4, 0, 2}, Order{4, 3, 2, 1, 0}, Order{1, 2, 0, 4, 3}})
    for (const bool modes : {false, true})
      check_equal(base, run_rigid(renumbered(parts, order, modes), {}, o), order);
}

TEST_CASE("equal bits also where forces jump, the core rubs and the sequence is not computable",
          "[mechanics]") {
  auto jumping = powbench::bench::reference_closing();
  jumping.pad = {1e8, 1.5, DampingForm::linear, 50, 0};
  jumping.core_friction = 0.5;
  auto chaotic = powbench::bench::reference_closing(100);
  const Order order{3, 1, 4, 0, 2};
  for (const auto& parts : {jumping, chaotic}) {
    RigidOptions o;
    o.tolerance = 1e-6;
    o.end = 0.04;
    check_equal(run_rigid(parts, {}, o), run_rigid(renumbered(parts, order, true), {}, o), order);
  }
}

TEST_CASE("canonical order: by position first, ties by the other numbers and shapes", "[mechanics]") {
  auto parts = powbench::bench::reference_closing();
  parts.bridges[3] = parts.bridges[1];  // exchangeable but for the shapes of the modes
  const auto a = in_canonical_order(parts);
  for (std::size_t j = 1; j < 5; ++j) CHECK(a.parts.bridges[j - 1].position <= a.parts.bridges[j].position);
  CHECK(a.number[5] == 5);
  const Order order{1, 3, 0, 2, 4};
  const auto b = in_canonical_order(renumbered(parts, order, true));
  for (std::size_t lane = 0; lane < 5; ++lane) {
    CHECK(a.number[lane] == order[static_cast<std::size_t>(b.number[lane])]);
    for (std::size_t m = 0; m < 4; ++m)
      CHECK(std::memcmp(a.parts.modes[m].shape[lane], b.parts.modes[m].shape[lane], 2 * sizeof(double)) == 0);
  }
}

TEST_CASE("modes have one order: by their numbers and where those are equal by their shapes", "[mechanics]") {
  auto parts = powbench::bench::reference_closing();
  for (int end = 0; end < 2; ++end)  // one shape, two frequencies
    for (std::size_t j = 0; j < 5; ++j) parts.modes[1].shape[j][end] = parts.modes[0].shape[j][end];
  parts.modes[3].hertz = parts.modes[2].hertz;  // one frequency, two shapes
  const CanonicalParts one = in_canonical_order(parts);
  for (const Order order : {Order{0, 1, 2, 3, 4}, Order{3, 1, 4, 0, 2}, Order{4, 3, 2, 1, 0}}) {
    const CanonicalParts other = in_canonical_order(renumbered(parts, order, true));
    for (std::size_t m = 0; m < parts.modes.size(); ++m) {
      CHECK(other.parts.modes[m].hertz == one.parts.modes[m].hertz);
      for (std::size_t j = 0; j < 5; ++j)
        for (int end = 0; end < 2; ++end)
          CHECK(other.parts.modes[m].shape[j][end] == one.parts.modes[m].shape[j][end]);
    }
    for (std::size_t j = 0; j < 5; ++j)
      CHECK(other.parts.bridges[j].position == one.parts.bridges[j].position);
  }
}
