#pragma once

#include "sim/magnetics/circuit/one_number.h"

/// The equations of magnetic_circuit.h, for one circuit and for several side by side.

namespace powbench::sim {

template <class N>
struct CircuitNumbers {
  N area, iron_length, residual;
  N fringe;                        ///< c, 1/m
  N share;                         ///< a2
  N inverse_bare, inverse_shaded;  ///< 1 / (1 - a2); 1 / a2, 0 without a shaded share
  N ring_resistance;
  N linear, saturation, exponent;               ///< of the law of the iron
  N iron_per_area, volume, mu0_area, one_bare;  ///< of those above
};

/// Everything the circuit gives at one state.
template <class Of>
struct FieldOf {
  using T = typename Of::Number;
  T mmf;              ///< N i, A
  T mmf_phi;          ///< d mmf / d phi, A/Wb
  T mmf_phi2;         ///< d mmf / d phi2
  T mmf_separation;   ///< d mmf / d separation, A/m
  T ring_current;     ///< i_sh, A; its derivative by phi is mmf_phi2
  T ring_phi2;        ///< d ring_current / d phi2
  T ring_separation;  ///< d ring_current / d separation = d pull / d phi2
  T pull;             ///< N, on the moving core in closing direction; its derivative by phi is mmf_separation
  T pull_separation;  ///< d pull / d separation, N/m
  T energy;           ///< J, stored, without the leakage
};

/// The iron at one flux density.
template <class Of>
struct IronOf {
  using T = typename Of::Number;
  T mmf;     ///< A
  T slope;   ///< dH/dB, m/H
  T energy;  ///< J
  T steep;   ///< the law's part that saturates; a steel has none
};

/// `power`: |b|^(exponent - 1).
template <class Of, class T>
POWBENCH_EQUATION IronOf<Of> law_iron(const CircuitNumbers<typename Of::Stored>& n, T power, T b) {
  const T steep = Of::at(n.saturation) * power;
  return {Of::at(n.iron_length) * (Of::at(n.linear) + steep) * b,
          Of::at(n.linear) + Of::at(n.exponent) * steep,
          Of::at(n.volume) * b * b * (0.5 * Of::at(n.linear) + steep / (Of::at(n.exponent) + 1.0)), steep};
}

/// b^even for an even number >= 2.
template <class Of, class T>
POWBENCH_EQUATION T even_power_of(int even, T b) {
  T result = Of::all(1.0), square = b * b;
  for (int n = even / 2; n > 0; n /= 2) {
    if (n % 2 == 1) result *= square;
    square *= square;
  }
  return result;
}

template <class Of, class T>
POWBENCH_EQUATION T gap_of(const CircuitNumbers<typename Of::Stored>& n, T separation) {
  const T residual = Of::at(n.residual);
  return Of::choose(
      separation >= 0.0, [&] { return residual + separation; },
      [&] { return residual * residual / (residual - separation); });
}

/// What the place of the core alone decides.
template <class Of>
struct ReluctanceOf {
  using T = typename Of::Number;
  T r, slope, bend;  ///< A/Wb; its first and second derivative by the separation
};
template <class Of, class T>
POWBENCH_EQUATION ReluctanceOf<Of> reluctance(const CircuitNumbers<typename Of::Stored>& n, T separation) {
  const T residual = Of::at(n.residual), fringe = Of::at(n.fringe), mu0_area = Of::at(n.mu0_area);
  const auto open = separation >= 0.0;
  const T g = gap_of<Of>(n, separation);
  const T gap_slope = Of::choose(
      open, [&] { return Of::all(1.0); }, [&] { return (g / residual) * (g / residual); });
  const T gap_bend = Of::choose(
      open, [&] { return Of::all(0.0); }, [&] { return 2.0 * g * gap_slope / (residual * residual); });
  const T wide = Of::all(1.0) / (1.0 + fringe * g);
  return {g * wide / mu0_area, wide * wide * gap_slope / mu0_area,
          wide * wide / mu0_area * (gap_bend - 2.0 * fringe * wide * gap_slope * gap_slope)};
}

template <class Of, class T>
POWBENCH_EQUATION FieldOf<Of> circuit_field(const CircuitNumbers<typename Of::Stored>& n,
                                            const ReluctanceOf<Of>& gap, const IronOf<Of>& iron, T phi,
                                            T phi2) {
  const T of_bare = Of::at(n.inverse_bare), of_shaded = Of::at(n.inverse_shaded);
  const T phi1 = phi - phi2;
  const T unlike = of_shaded * phi2 - of_bare * phi1;
  const T squares = phi * phi + of_bare * phi1 * phi1 + of_shaded * phi2 * phi2;
  FieldOf<Of> f;
  f.mmf = iron.mmf + gap.r * (phi + of_bare * phi1);
  f.mmf_phi = Of::at(n.iron_per_area) * iron.slope + gap.r * Of::at(n.one_bare);
  f.mmf_phi2 = -gap.r * of_bare;
  f.mmf_separation = gap.slope * (phi + of_bare * phi1);
  f.ring_current = gap.r * unlike;
  f.ring_phi2 = gap.r * (of_shaded + of_bare);
  f.ring_separation = gap.slope * unlike;
  f.pull = 0.5 * gap.slope * squares;
  f.pull_separation = 0.5 * gap.bend * squares;
  f.energy = iron.energy + 0.5 * gap.r * squares;
  return f;
}

}  // namespace powbench::sim
