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

/// The numbers of one call, and the equations of ContactorModel over them.
class Equations {
 public:
  enum : int { phi, phi2, x, v, z, w };
  using State = std::array<Lane, LaneBlock::states>;

  Equations(const LaneLayout& layout, const LaneBlock& block) : l_(layout), b_(block) {}

  struct Contacts {
    V pen[LaneBlock::guards], rate[LaneBlock::guards], force[LaneBlock::guards];
  };
  struct Field {
    V mmf, mmf_phi, mmf_phi2, mmf_separation, ring_current, pull;
  };

  POWBENCH_LANES void penetrations(const State& s, Contacts& c) const {
    const int sc = l_.static_core;
    c.pen[0] = -separation(s);
    c.rate[0] = of(s, v) - of(s, sc + 1);
    c.pen[1] = at(b_.open_stop_depth) - of(s, x);
    c.rate[1] = -of(s, v);
    for (int i = 0; i < l_.groups; ++i) {
      const auto& g = l_.group[static_cast<std::size_t>(i)];
      V *p = c.pen + g.first_contact, *r = c.rate + g.first_contact;
      const V q0 = of(s, g.state), q1 = of(s, g.state + 1);
      const V seat = at(b_.seat_depth) + q0 - of(s, x), seat_rate = q1 - of(s, v);
      const V contact = q0 - of(s, z) - at(b_.gap[static_cast<std::size_t>(i)]), contact_rate = q1 - of(s, w);
      if (!g.tilts) {
        p[0] = seat, r[0] = seat_rate;
        p[1] = contact, r[1] = contact_rate;
        continue;
      }
      const V q2 = of(s, g.state + 2), q3 = of(s, g.state + 3);
      const V half = at(b_.half_length), seat_half = at(b_.seat_half_length);
      p[0] = seat + seat_half * q2, r[0] = seat_rate + seat_half * q3;
      p[1] = seat - seat_half * q2, r[1] = seat_rate - seat_half * q3;
      p[2] = contact + half * q2, r[2] = contact_rate + half * q3;
      p[3] = contact - half * q2 - at(b_.tilt_gap), r[3] = contact_rate - half * q3;
    }
  }

  POWBENCH_LANES Field field(const State& s) const {
    const V separate = separation(s), one = all(1.0);
    const V residual = at(b_.residual);
    const M open = separate >= 0.0;
    const V g = open ? residual + separate : residual * residual / (residual - separate);
    const V gap_slope = open ? one : (g / residual) * (g / residual);
    const V widening = one / (one + at(b_.fringe) * g);
    const V r = g * widening / at(b_.mu0_area);
    const V r_slope = widening * widening * gap_slope / at(b_.mu0_area);
    const V first = of(s, phi), second = l_.has_ring ? of(s, phi2) : at(b_.share) * first;
    const V flux_density = first / at(b_.area), bare = first - second;
    const V steep = at(b_.saturation) * power(flux_density);
    const V iron = at(b_.iron_length) * (at(b_.linear) + steep) * flux_density;
    const V iron_slope = at(b_.linear) + at(b_.exponent) * steep;
    const V of_bare = at(b_.inverse_bare), of_shaded = at(b_.inverse_shaded);
    Field f;
    f.mmf = iron + r * (first + of_bare * bare);
    f.mmf_phi = at(b_.iron_per_area) * iron_slope + r * at(b_.one_bare);
    f.mmf_phi2 = -r * of_bare;
    f.mmf_separation = r_slope * (first + of_bare * bare);
    const V unlike = of_shaded * second - of_bare * bare;
    const V squares = first * first + of_bare * bare * bare + of_shaded * second * second;
    f.ring_current = r * unlike;
    f.pull = 0.5 * r_slope * squares;
    return f;
  }

  POWBENCH_LANES void press(Contacts& c) const {
    for (int k = 0; k < l_.contacts; ++k) {
      const auto i = static_cast<std::size_t>(k);
      c.force[k] =
          at(b_.pressed[i]) ? at(b_.stiffness[i]) * c.pen[k] + at(b_.damping[i]) * c.rate[k] : all(0.0);
    }
  }

  /// On the core, without friction.
  POWBENCH_LANES V core_force(const State& s, const Field& f, const Contacts& c) const {
    V core = f.pull - at(b_.return_preload) - at(b_.return_rate) * of(s, x) + c.force[1] - c.force[0];
    for (int i = 0; i < l_.groups; ++i) {
      const auto& g = l_.group[static_cast<std::size_t>(i)];
      const V* force = c.force + g.first_contact;
      const V spring = at(b_.preload) + at(b_.rate) * (of(s, x) - of(s, g.state));
      const V seat = g.tilts ? force[0] + force[1] : force[0];
      core += at(b_.count[static_cast<std::size_t>(i)]) * (seat - spring);
    }
    return core;
  }

  POWBENCH_LANES void derivative(V emf, const State& s, State& ds) const {
    Contacts c;
    penetrations(s, c);
    press(c);
    const Field f = field(s);
    const int sc = l_.static_core;
    const bool floats = sc != z;
    const V core = core_force(s, f, c);
    const V on_static_core = c.force[0] - f.pull;
    const V buffer = floats ? at(b_.buffer_rate) * (of(s, sc) - of(s, z)) +
                                  at(b_.buffer_damping) * (of(s, sc + 1) - of(s, w))
                            : on_static_core;
    V base = buffer - at(b_.base_rate) * of(s, z) - at(b_.base_damping) * of(s, w);

    // fluxes; the coil is fed by the source
    const V resistance = at(b_.resistance), turns = at(b_.turns);
    const V current = f.mmf / turns;
    const V second_rate = l_.has_ring ? -at(b_.ring_resistance) * f.ring_current : all(0.0);
    const V stiffness = l_.has_ring ? f.mmf_phi : f.mmf_phi + at(b_.share) * f.mmf_phi2;
    const V other = f.mmf_phi2 * second_rate + f.mmf_separation * (of(s, sc + 1) - of(s, v));
    const V linkage_rate = emf - resistance * current;
    const V ratio = at(b_.inductance_per_turn);
    const V first_rate = (linkage_rate - ratio * other) / (turns + ratio * stiffness);
    put(ds, phi, first_rate);
    put(ds, phi2, l_.has_ring ? second_rate : at(b_.share) * first_rate);

    put(ds, x, of(s, v));
    put(ds, v, at(b_.stick) ? all(0.0) : (core + at(b_.sliding_force)) / at(b_.core_mass));

    V lost = -at(b_.sliding_force) * of(s, v) + at(b_.base_damping) * of(s, w) * of(s, w);
    lost += loss(c, 0) + loss(c, 1);
    if (floats) {
      const V rate = of(s, sc + 1) - of(s, w);
      lost += at(b_.buffer_damping) * rate * rate;
    }
    for (int i = 0; i < l_.groups; ++i) {
      const auto& g = l_.group[static_cast<std::size_t>(i)];
      const V* force = c.force + g.first_contact;
      const V count = at(b_.count[static_cast<std::size_t>(i)]);
      const V spring = at(b_.preload) + at(b_.rate) * (of(s, x) - of(s, g.state));
      base += count * (g.tilts ? force[2] + force[3] : force[1]);
      put(ds, g.state, of(s, g.state + 1));
      if (!g.tilts) {
        put(ds, g.state + 1, (spring - force[0] - force[1]) / at(b_.bridge_mass));
      } else {
        put(ds, g.state + 1, (spring - force[0] - force[1] - force[2] - force[3]) / at(b_.bridge_mass));
        put(ds, g.state + 2, of(s, g.state + 3));
        put(ds, g.state + 3,
            -(at(b_.half_length) * (force[2] - force[3]) + at(b_.seat_half_length) * (force[0] - force[1])) /
                at(b_.inertia));
      }
      for (int k = 0; k < (g.tilts ? 4 : 2); ++k) lost += count * loss(c, g.first_contact + k);
    }
    put(ds, z, of(s, w));
    put(ds, w, base / at(b_.base_mass));
    if (floats) {
      put(ds, sc, of(s, sc + 1));
      put(ds, sc + 1, (on_static_core - buffer) / at(b_.static_mass));
    }
    put(ds, l_.ledger, emf * current);
    put(ds, l_.ledger + 1, resistance * current * current);
    put(ds, l_.ledger + 2, l_.has_ring ? at(b_.ring_resistance) * f.ring_current * f.ring_current : all(0.0));
    put(ds, l_.ledger + 3, lost);
  }

  /// Contacts, then friction; `sticking`: the core of some lane sticks.
  POWBENCH_LANES void guards(const State& s, bool sticking, std::array<Lane, LaneBlock::guards>& g) const {
    Contacts c;
    penetrations(s, c);
    for (int k = 0; k < l_.contacts; ++k) {
      const auto i = static_cast<std::size_t>(k);
      const V reduced = c.pen[k] + at(b_.damping_time[i]) * c.rate[k];
      at(g[i]) = at(b_.pressed[i]) ? reduced : -(reduced < c.pen[k] ? reduced : c.pen[k]);
    }
    V friction = at(b_.slides) ? at(b_.way) * of(s, v) : all(1.0);
    if (sticking) {
      press(c);
      const V room = at(b_.friction) - size_of(core_force(s, field(s), c));
      friction = at(b_.stick) ? room : friction;
    }
    at(g[static_cast<std::size_t>(l_.contacts)]) = friction;
  }

 private:
  static POWBENCH_LANES V of(const State& s, int i) { return at(s[static_cast<std::size_t>(i)]); }
  static POWBENCH_LANES void put(State& s, int i, V value) { at(s[static_cast<std::size_t>(i)]) = value; }
  POWBENCH_LANES V separation(const State& s) const {
    return at(b_.travel) - (of(s, x) - of(s, l_.static_core));
  }
  POWBENCH_LANES V power(V flux_density) const {
    V result = all(1.0), square = flux_density * flux_density;
    for (int n = l_.even_power / 2; n > 0; n /= 2) {
      if (n % 2 == 1) result *= square;
      square *= square;
    }
    return result;
  }
  POWBENCH_LANES V loss(const Contacts& c, int k) const {
    const V pressing = c.pen[k] < 0.0 ? all(0.0) : c.pen[k];
    return (c.force[k] - at(b_.stiffness[static_cast<std::size_t>(k)]) * pressing) * c.rate[k];
  }

  const LaneLayout& l_;
  const LaneBlock& b_;
};

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
  const Equations equations(layout, b);
  V emf[7];
  for (std::size_t stage = 1; stage < 6; ++stage) {
    const V given = at(b.source[stage]);
    emf[stage] = at(b.one_sine) ? at(b.amplitude) * bounded_sine<V, M>(given) : given;
  }
  emf[6] = emf[5];
  combine(b, n, 1.0 / 5);
  equations.derivative(emf[1], b.result, b.slope[1]);
  combine(b, n, 3.0 / 40, 9.0 / 40);
  equations.derivative(emf[2], b.result, b.slope[2]);
  combine(b, n, 44.0 / 45, -56.0 / 15, 32.0 / 9);
  equations.derivative(emf[3], b.result, b.slope[3]);
  combine(b, n, 19372.0 / 6561, -25360.0 / 2187, 64448.0 / 6561, -212.0 / 729);
  equations.derivative(emf[4], b.result, b.slope[4]);
  combine(b, n, 9017.0 / 3168, -355.0 / 33, 46732.0 / 5247, 49.0 / 176, -5103.0 / 18656);
  equations.derivative(emf[5], b.result, b.slope[5]);
  combine(b, n, 35.0 / 384, 0.0, 500.0 / 1113, 125.0 / 192, -2187.0 / 6784, 11.0 / 84);
  equations.derivative(emf[6], b.result, b.slope[6]);

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
    alignas(64) Equations::State s;
    for (int i = 0; i < layout.ledger; ++i) {
      const auto j = static_cast<std::size_t>(i);
      at(s[j]) =
          at(b.dense[0][j]) +
          share * (at(b.dense[1][j]) +
                   rest * (at(b.dense[2][j]) + share * (at(b.dense[3][j]) + rest * at(b.dense[4][j]))));
    }
    equations.guards(s, sticking, b.guard[static_cast<std::size_t>(p)]);
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
