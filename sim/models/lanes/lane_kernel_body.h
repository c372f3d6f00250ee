#pragma once

#include <cmath>

#include "sim/models/lanes/lane_block.h"
#include "sim/supply/sine.h"

/// The step of lane_block.h. For the kernel sources only, which say how many lanes one register holds: wider vectors
/// than that would go through memory at every operation. Everything has internal linkage.

#ifndef POWBENCH_LANES_AT_ONCE
#error "POWBENCH_LANES_AT_ONCE: 2, 4 or 8 lanes in a register"
#endif

namespace powbench::sim {
namespace {

constexpr int at_once = POWBENCH_LANES_AT_ONCE;
typedef double V __attribute__((vector_size(8 * at_once), may_alias));
typedef std::int64_t M __attribute__((vector_size(8 * at_once), may_alias));

#define POWBENCH_LANES inline __attribute__((always_inline))

POWBENCH_LANES V all(double x) {
#if POWBENCH_LANES_AT_ONCE == 8
  return V{x, x, x, x, x, x, x, x};
#elif POWBENCH_LANES_AT_ONCE == 4
  return V{x, x, x, x};
#else
  return V{x, x};
#endif
}
POWBENCH_LANES V size_of(V x) {
  return reinterpret_cast<V>(reinterpret_cast<M>(x) & INT64_MAX);
}
POWBENCH_LANES bool any(M m) {
  std::int64_t sum = 0;
  for (int k = 0; k < at_once; ++k) sum |= m[k];
  return sum != 0;
}

/// Of lanes `first` .. `first + at_once - 1`.
template <int first>
struct LaneNumber {
  using Basis = LaneNumber;
  using Number = V;
  using Stored = Lane;
  using Mask = M;
  static POWBENCH_LANES V at(const Lane& lane) { return *reinterpret_cast<const V*>(lane.data() + first); }
  static POWBENCH_LANES V& at(Lane& lane) { return *reinterpret_cast<V*>(lane.data() + first); }
  static POWBENCH_LANES M at(const LaneMask& mask) {
    return *reinterpret_cast<const M*>(mask.data() + first);
  }
  static POWBENCH_LANES M& at(LaneMask& mask) { return *reinterpret_cast<M*>(mask.data() + first); }
  static POWBENCH_LANES V all(double x) { return sim::all(x); }
  template <class A, class B>
  static POWBENCH_LANES V choose(M which, const A& a, const B& b) {
    const V one = a(), other = b();
    return which ? one : other;
  }
};

/// What the equations ask of a block.
template <int first>
struct Lanes : LaneNumber<first> {
  using Own = LaneNumber<first>;
  Lanes(const LaneLayout& l, int power, const LaneBlock& b)
      : block(b), layout(l), even_power(power), numbers(b.numbers) {}
  const LaneBlock& block;
  const LaneLayout& layout;
  const int even_power;
  const ContactorNumbers<Lane>& numbers;
  POWBENCH_LANES M pressed(int k) const { return Own::at(block.pressed[static_cast<std::size_t>(k)]); }
  POWBENCH_LANES V friction_net(V driving) const {
    return Own::at(block.stick) ? all(0.0) : driving + Own::at(block.sliding_force);
  }
  POWBENCH_LANES V friction_loss(V speed) const { return -Own::at(block.sliding_force) * speed; }
  POWBENCH_LANES IronOf<Own> iron(V b) const {
    return law_iron<Own>(numbers.circuit, even_power_of<Own>(even_power, b), b);
  }
};

constexpr std::size_t most_states = LaneBlock::states, most_guards = LaneBlock::guards;

/// The coil is fed by the source.
template <int first>
POWBENCH_LANES void derivative(const Lanes<first>& lanes, V emf, const V* __restrict s, V* __restrict ds) {
  using Equations = ContactorEquations<Lanes<first>>;
  const auto& n = lanes.numbers;
  typename Equations::Forces f;
  Equations::forces(lanes, s, f);
  const V resistance = lanes.at(n.resistance), current = f.field.mmf / lanes.at(n.turns);
  const V second_rate = Equations::ring_rate(lanes, f.field);
  const V first_rate = Equations::first_rate(lanes, f.field, emf - resistance * current,
                                             Equations::other_rate(lanes, f.field, second_rate, s));
  ds[Equations::phi] = first_rate;
  ds[Equations::phi2] = lanes.layout.has_ring ? second_rate : lanes.at(n.circuit.share) * first_rate;
  Equations::rates(lanes, s, f, ds);
  ds[lanes.layout.ledger] = emf * current;
  ds[lanes.layout.ledger + 1] = resistance * current * current;
}

/// Contacts, then friction; `sticking`: the core of some lane sticks.
template <int first>
POWBENCH_LANES void guards(const Lanes<first>& lanes, const V* s, bool sticking, V* g) {
  using Equations = ContactorEquations<Lanes<first>>;
  const LaneBlock& b = lanes.block;
  typename Equations::Forces f;
  Equations::penetrations(lanes, s, f.pen, f.rate);
  const int contacts = lanes.layout.contacts;
  for (int k = 0; k < contacts; ++k) g[k] = Equations::contact_guard_at(lanes, k, f.pen[k], f.rate[k]);
  V friction = lanes.at(b.slides) ? lanes.at(b.way) * s[Equations::v] : all(1.0);
  if (sticking) {
    Equations::forces_of(lanes, s, f);
    friction = lanes.at(b.stick) ? lanes.at(b.friction) - size_of(f.core) : friction;
  }
  g[contacts] = friction;
}

using Slopes = V[7][most_states];

template <class... A>
POWBENCH_LANES void combine(int n, V h, const V* y, const Slopes& slope, V* result, A... a) {
  for (int j = 0; j < n; ++j) {
    int s = 0;
    const V k[] = {(static_cast<void>(a), slope[s++][j])...};
    const double weight[] = {a...};
    V sum = weight[sizeof...(a) - 1] * k[sizeof...(a) - 1];  // from the last one on, as DormandPrince does
    for (int m = static_cast<int>(sizeof...(a)) - 2; m >= 0; --m) sum = weight[m] * k[m] + sum;
    result[j] = y[j] + h * sum;
  }
}

/// Of most contactors: all bridges alike and level, the static core part of the base, a shading ring.
constexpr LaneLayout usual_layout = [] {
  LaneLayout l;
  l.group[0] = {l.first_group, 2, false};
  l.groups = 1;
  l.contacts = 4;
  l.ledger = l.first_group + 2;
  l.size = l.ledger + 4;
  l.has_ring = true;
  return l;
}();

/// The step in lanes `first` .. `first + at_once - 1`. The compiler knows the numbers of the usual layout, but for the
/// law of the iron: no loop is left.
template <int first, bool usual>
void step_of(const LaneLayout& given, LaneBlock& b) {
  const LaneLayout& layout = usual ? usual_layout : given;
  const int n = layout.size;
  const Lanes<first> lanes(layout, given.even_power, b);
  V y[most_states], result[most_states];
  Slopes k;
  const M accepted = lanes.at(b.accepted);
  for (int i = 0; i < n; ++i) {
    const auto j = static_cast<std::size_t>(i);
    y[i] = accepted ? lanes.at(b.result[j]) : lanes.at(b.y[j]);
    k[0][i] = accepted ? lanes.at(b.last_slope[j]) : lanes.at(b.first_slope[j]);
    lanes.at(b.y[j]) = y[i];
    lanes.at(b.first_slope[j]) = k[0][i];
  }
  const V h = lanes.at(b.step);
  V emf[7];
  for (std::size_t stage = 1; stage < stage_times.size(); ++stage) {
    const V t = lanes.at(b.begin) + stage_times[stage] * h, angle = lanes.at(b.rate) * t + lanes.at(b.phase);
    emf[stage] =
        lanes.at(b.one_sine) ? lanes.at(b.amplitude) * bounded_sine<V, M>(angle) : lanes.at(b.source[stage]);
  }
  emf[6] = emf[5];
  combine(n, h, y, k, result, 1.0 / 5);
  derivative(lanes, emf[1], result, k[1]);
  combine(n, h, y, k, result, 3.0 / 40, 9.0 / 40);
  derivative(lanes, emf[2], result, k[2]);
  combine(n, h, y, k, result, 44.0 / 45, -56.0 / 15, 32.0 / 9);
  derivative(lanes, emf[3], result, k[3]);
  combine(n, h, y, k, result, 19372.0 / 6561, -25360.0 / 2187, 64448.0 / 6561, -212.0 / 729);
  derivative(lanes, emf[4], result, k[4]);
  combine(n, h, y, k, result, 9017.0 / 3168, -355.0 / 33, 46732.0 / 5247, 49.0 / 176, -5103.0 / 18656);
  derivative(lanes, emf[5], result, k[5]);
  combine(n, h, y, k, result, 35.0 / 384, 0.0, 500.0 / 1113, 125.0 / 192, -2187.0 / 6784, 11.0 / 84);
  derivative(lanes, emf[6], result, k[6]);

  V worst = all(0.0);
  M finite = worst == 0.0;
  for (int i = 0; i < n; ++i) {
    const auto j = static_cast<std::size_t>(i);
    const V e = h * (71.0 / 57600 * k[0][i] - 71.0 / 16695 * k[2][i] + 71.0 / 1920 * k[3][i] -
                     17253.0 / 339200 * k[4][i] + 22.0 / 525 * k[5][i] - 1.0 / 40 * k[6][i]);
    const V ratio = size_of(e) / lanes.at(b.tolerance[j]);
    finite &= ratio <= 1.7976931348623157e308;
    worst = ratio > worst ? ratio : worst;
    const V rise = result[i] - y[i], bend = h * k[0][i] - rise;
    lanes.at(b.dense[0][j]) = y[i];
    lanes.at(b.dense[1][j]) = rise;
    lanes.at(b.dense[2][j]) = bend;
    lanes.at(b.dense[3][j]) = rise - h * k[6][i] - bend;
    lanes.at(b.dense[4][j]) =
        h * (-12715105075.0 / 11282082432 * k[0][i] + 87487479700.0 / 32700410799 * k[2][i] -
             10690763975.0 / 1880347072 * k[3][i] + 701980252875.0 / 199316789632 * k[4][i] -
             1453857185.0 / 822651844 * k[5][i] + 69997945.0 / 29380423 * k[6][i]);
    lanes.at(b.result[j]) = result[i];
    lanes.at(b.last_slope[j]) = k[6][i];
  }
  lanes.at(b.error) = finite ? worst : all(HUGE_VAL);

  const bool sticking = any(lanes.at(b.stick));
  V guard[LaneBlock::samples][most_guards];
  for (int p = 0; p < LaneBlock::samples; ++p) {
    const double share = p / double{LaneBlock::samples - 1}, rest = 1 - share;
    V s[most_states];
    for (int i = 0; i < layout.ledger; ++i) {
      const auto c = [&](std::size_t order) { return lanes.at(b.dense[order][static_cast<std::size_t>(i)]); };
      s[i] = c(0) + share * (c(1) + rest * (c(2) + share * (c(3) + rest * c(4))));
    }
    guards(lanes, s, sticking, guard[p]);
    for (int i = 0; i <= layout.contacts; ++i)
      lanes.at(b.guard[static_cast<std::size_t>(p)][static_cast<std::size_t>(i)]) = guard[p][i];
  }
  M interesting = lanes.at(b.error) < 0.0;  // none
  for (int i = 0; i <= layout.contacts; ++i) {
    const auto g = [&](int p) { return guard[p][i]; };
    for (int p = 1; p < LaneBlock::samples; ++p) interesting |= g(p) < 0.0;
    for (int p = 1; p < LaneBlock::samples - 1; ++p) interesting |= dips_low(g(p - 1), g(p), g(p + 1));
  }
  lanes.at(b.interesting) = interesting;
}

template <int first = 0>
POWBENCH_LANES void lane_step(const LaneLayout& layout, LaneBlock& b) {
  LaneLayout usual = usual_layout;
  usual.even_power = layout.even_power;
  if (layout == usual)
    step_of<first, true>(layout, b);
  else
    step_of<first, false>(layout, b);
  if constexpr (first + at_once < lane_width) lane_step<first + at_once>(layout, b);
}

}  // namespace
}  // namespace powbench::sim
