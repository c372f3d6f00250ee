#pragma once

#include <cmath>

#include "sim/lanes/lane_block.h"
#include "sim/supply/sine.h"

/// The step of lane_block.h. For the kernel sources only: everything has internal linkage.

namespace powbench::sim {
namespace {

typedef double V __attribute__((vector_size(8 * lane_width), may_alias));
typedef std::int64_t M __attribute__((vector_size(8 * lane_width), may_alias));

#define POWBENCH_LANES inline __attribute__((always_inline))

POWBENCH_LANES V at(const Lane& lane) {
  return *reinterpret_cast<const V*>(lane.data());
}
POWBENCH_LANES V& at(Lane& lane) {
  return *reinterpret_cast<V*>(lane.data());
}
POWBENCH_LANES M at(const LaneMask& mask) {
  return *reinterpret_cast<const M*>(mask.data());
}
POWBENCH_LANES M& at(LaneMask& mask) {
  return *reinterpret_cast<M*>(mask.data());
}
POWBENCH_LANES V all(double x) {
  return V{x, x, x, x, x, x, x, x};
}
POWBENCH_LANES V size_of(V x) {
  return reinterpret_cast<V>(reinterpret_cast<M>(x) & INT64_MAX);
}
POWBENCH_LANES bool any(M m) {
  std::int64_t sum = 0;
  for (int k = 0; k < lane_width; ++k) sum |= m[k];
  return sum != 0;
}

struct LaneNumber {
  using Basis = LaneNumber;
  using Number = V;
  using Stored = Lane;
  using Mask = M;
  static POWBENCH_LANES V at(const Lane& lane) { return sim::at(lane); }
  static POWBENCH_LANES V all(double x) { return sim::all(x); }
  template <class A, class B>
  static POWBENCH_LANES V choose(M first, const A& a, const B& b) {
    const V one = a(), other = b();
    return first ? one : other;
  }
};

/// What the equations ask of a block.
struct Lanes : LaneNumber {
  Lanes(const LaneLayout& l, const LaneBlock& b) : block(b), layout(l), numbers(b.numbers) {}
  const LaneBlock& block;
  const LaneLayout& layout;
  const ContactorNumbers<Lane>& numbers;
  POWBENCH_LANES M pressed(int k) const { return sim::at(block.pressed[static_cast<std::size_t>(k)]); }
  POWBENCH_LANES V friction_net(V driving) const {
    return sim::at(block.stick) ? all(0.0) : driving + at(block.sliding_force);
  }
  POWBENCH_LANES V friction_loss(V speed) const { return -at(block.sliding_force) * speed; }
  POWBENCH_LANES IronOf<LaneNumber> iron(V b) const {
    return law_iron<LaneNumber>(numbers.circuit, even_power_of<LaneNumber>(layout.even_power, b), b);
  }
};
using Equations = ContactorEquations<Lanes>;
using State = std::array<Lane, LaneBlock::states>;

POWBENCH_LANES const V* of(const State& s) {
  return reinterpret_cast<const V*>(s.data());
}
POWBENCH_LANES V* of(State& s) {
  return reinterpret_cast<V*>(s.data());
}

/// The coil is fed by the source.
POWBENCH_LANES void derivative(const Lanes& lanes, V emf, const State& state, State& rates) {
  const V* __restrict s = of(state);
  V* __restrict ds = of(rates);
  const auto& n = lanes.numbers;
  Equations::Forces f;
  Equations::forces(lanes, s, f);
  const V resistance = at(n.resistance), current = f.field.mmf / at(n.turns);
  const V second_rate = Equations::ring_rate(lanes, f.field);
  const V first_rate = Equations::first_rate(lanes, f.field, emf - resistance * current,
                                             Equations::other_rate(lanes, f.field, second_rate, s));
  ds[Equations::phi] = first_rate;
  ds[Equations::phi2] = lanes.layout.has_ring ? second_rate : at(n.circuit.share) * first_rate;
  Equations::rates(lanes, s, f, ds);
  ds[lanes.layout.ledger] = emf * current;
  ds[lanes.layout.ledger + 1] = resistance * current * current;
}

/// Contacts, then friction; `sticking`: the core of some lane sticks.
POWBENCH_LANES void guards(const Lanes& lanes, const State& state, bool sticking,
                           std::array<Lane, LaneBlock::guards>& g) {
  const V* s = of(state);
  const LaneBlock& b = lanes.block;
  Equations::Forces f;
  Equations::penetrations(lanes, s, f.pen, f.rate);
  const int contacts = lanes.layout.contacts;
  for (int k = 0; k < contacts; ++k)
    at(g[static_cast<std::size_t>(k)]) = Equations::contact_guard_at(lanes, k, f.pen[k], f.rate[k]);
  V friction = at(b.slides) ? at(b.way) * s[Equations::v] : all(1.0);
  if (sticking) {
    Equations::forces_of(lanes, s, f);
    friction = at(b.stick) ? at(b.friction) - size_of(f.core) : friction;
  }
  at(g[static_cast<std::size_t>(contacts)]) = friction;
}

template <class... A>
POWBENCH_LANES void combine(LaneBlock& b, int n, A... a) {
  const V h = at(b.step);
  for (int i = 0; i < n; ++i) {
    const auto j = static_cast<std::size_t>(i);
    int s = 0;
    const V k[] = {(static_cast<void>(a), at(b.slope[static_cast<std::size_t>(s++)][j]))...};
    const double weight[] = {a...};
    V sum = weight[sizeof...(a) - 1] * k[sizeof...(a) - 1];  // from the last one on, as DormandPrince does
    for (int m = static_cast<int>(sizeof...(a)) - 2; m >= 0; --m) sum = weight[m] * k[m] + sum;
    at(b.result[j]) = at(b.y[j]) + h * sum;
  }
}

POWBENCH_LANES void lane_step(const LaneLayout& layout, LaneBlock& b) {
  const int n = layout.size;
  const M accepted = at(b.accepted);
  for (int i = 0; i < n; ++i) {
    const auto j = static_cast<std::size_t>(i);
    at(b.y[j]) = accepted ? at(b.result[j]) : at(b.y[j]);
    at(b.slope[0][j]) = accepted ? at(b.slope[6][j]) : at(b.slope[0][j]);
  }
  const Lanes lanes(layout, b);
  V emf[7];
  for (std::size_t stage = 1; stage < 6; ++stage) {
    const V given = at(b.source[stage]);
    emf[stage] = at(b.one_sine) ? at(b.amplitude) * bounded_sine<V, M>(given) : given;
  }
  emf[6] = emf[5];
  combine(b, n, 1.0 / 5);
  derivative(lanes, emf[1], b.result, b.slope[1]);
  combine(b, n, 3.0 / 40, 9.0 / 40);
  derivative(lanes, emf[2], b.result, b.slope[2]);
  combine(b, n, 44.0 / 45, -56.0 / 15, 32.0 / 9);
  derivative(lanes, emf[3], b.result, b.slope[3]);
  combine(b, n, 19372.0 / 6561, -25360.0 / 2187, 64448.0 / 6561, -212.0 / 729);
  derivative(lanes, emf[4], b.result, b.slope[4]);
  combine(b, n, 9017.0 / 3168, -355.0 / 33, 46732.0 / 5247, 49.0 / 176, -5103.0 / 18656);
  derivative(lanes, emf[5], b.result, b.slope[5]);
  combine(b, n, 35.0 / 384, 0.0, 500.0 / 1113, 125.0 / 192, -2187.0 / 6784, 11.0 / 84);
  derivative(lanes, emf[6], b.result, b.slope[6]);

  const V h = at(b.step);
  V worst = all(0.0);
  M finite = worst == 0.0;
  for (int i = 0; i < n; ++i) {
    const auto j = static_cast<std::size_t>(i);
    const auto k = [&](std::size_t stage) { return at(b.slope[stage][j]); };
    const V e = h * (71.0 / 57600 * k(0) - 71.0 / 16695 * k(2) + 71.0 / 1920 * k(3) -
                     17253.0 / 339200 * k(4) + 22.0 / 525 * k(5) - 1.0 / 40 * k(6));
    const V ratio = size_of(e) / at(b.tolerance[j]);
    finite &= ratio <= 1.7976931348623157e308;
    worst = ratio > worst ? ratio : worst;
    const V y = at(b.y[j]), rise = at(b.result[j]) - y, bend = h * k(0) - rise;
    at(b.dense[0][j]) = y;
    at(b.dense[1][j]) = rise;
    at(b.dense[2][j]) = bend;
    at(b.dense[3][j]) = rise - h * k(6) - bend;
    at(b.dense[4][j]) = h * (-12715105075.0 / 11282082432 * k(0) + 87487479700.0 / 32700410799 * k(2) -
                             10690763975.0 / 1880347072 * k(3) + 701980252875.0 / 199316789632 * k(4) -
                             1453857185.0 / 822651844 * k(5) + 69997945.0 / 29380423 * k(6));
  }
  at(b.error) = finite ? worst : all(HUGE_VAL);

  const bool sticking = any(at(b.stick));
  for (int p = 0; p < LaneBlock::samples; ++p) {
    const double share = p / double{LaneBlock::samples - 1}, rest = 1 - share;
    alignas(64) State s;
    for (int i = 0; i < layout.ledger; ++i) {
      const auto j = static_cast<std::size_t>(i);
      at(s[j]) =
          at(b.dense[0][j]) +
          share * (at(b.dense[1][j]) +
                   rest * (at(b.dense[2][j]) + share * (at(b.dense[3][j]) + rest * at(b.dense[4][j]))));
    }
    guards(lanes, s, sticking, b.guard[static_cast<std::size_t>(p)]);
  }
  M interesting = at(b.error) < 0.0;  // none
  for (int k = 0; k <= layout.contacts; ++k) {
    const auto g = [&](int p) {
      return at(b.guard[static_cast<std::size_t>(p)][static_cast<std::size_t>(k)]);
    };
    for (int p = 1; p < LaneBlock::samples; ++p) interesting |= g(p) < 0.0;
    for (int p = 1; p < LaneBlock::samples - 1; ++p) interesting |= (g(p) < g(p - 1)) & (g(p) <= g(p + 1));
  }
  at(b.interesting) = interesting;
}

}  // namespace
}  // namespace powbench::sim
