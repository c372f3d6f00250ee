#pragma once

#include <array>
#include <cmath>
#include <cstdint>
#include <limits>

#include "sim/supply/sine.h"

/// The mains at the coil switch, analytic in time: harmonics, dips and interruptions behind a source impedance.
///
///   u(t) = sqrt(2) U d [ sin a + sum over k of h_k sin(k a + phase_k) ],   a = 2 pi f t + phase + jump
///
/// with the share d and the jump of the piece of time that t lies in. Behind it the source takes R i + L di/dt.
///
/// A direct source gives u = U d. Behind a rectifier the coil sees e - R i with
///
///   half wave  e = u(t) - V_r,    full wave  e = |u(t)| - V_r
///
/// as long as its current is above zero; V_r is the forward voltage of all diodes in series.

namespace powbench::sim {

/// Part of the voltage at a multiple of the mains frequency, locked to the fundamental.
struct Harmonic {
  int order = 0;     ///< 2 .. 50
  double share = 0;  ///< of the fundamental's amplitude, 0 .. 1; 0: none
  double phase = 0;  ///< rad, at the fundamental's rising zero
};

/// A while at another voltage. The source keeps its impedance: an interruption is 0 V behind it, no open circuit.
struct Dip {
  double start = 0;     ///< s after the coil is first commanded on
  double duration = 0;  ///< s; 0: none
  double depth = 0;     ///< 0 .. 1, share of the voltage that is missing; 1: interruption
  double jump = 0;      ///< rad, by which the phase leads while it lasts
};

struct Mains {
  enum class Kind : std::uint8_t { ac, dc, half_wave, full_wave };
  Kind kind = Kind::ac;
  double rectifier_drop = 0;  ///< V_r, V, half and full wave
  double volts = 230;         ///< V rms of the fundamental; V of a direct source
  double hertz = 50;          ///< Hz
  double phase = 0;           ///< rad at t = 0
  double resistance = 0;      ///< ohm, source
  double inductance = 0;      ///< H, source
  std::array<Harmonic, 4> harmonics{{{3, 0, 0}, {5, 0, 0}, {7, 0, 0}, {11, 0, 0}}};
  std::array<Dip, 2> dips{};  ///< where they overlap, shares multiply and jumps add
};

/// A time between two changes of the mains, and what holds in it. Beyond its end the voltage goes on smoothly, so
/// that a step of an integrator may overshoot.
struct MainsPiece {
  double share = 1;
  double jump = 0;                                       ///< rad
  double end = std::numeric_limits<double>::infinity();  ///< s
};

/// The piece that `t` lies in, for dips that count from `origin`; a piece contains its beginning. Both in s.
MainsPiece mains_piece(const Mains&, double t, double origin);

/// Of the fundamental: its angle is mains_rate t + mains_phase, rad.
template <class Real>
Real mains_rate(const Mains& m) {
  constexpr Real two_pi = static_cast<Real>(2 * 3.14159265358979323846264338327950288L);
  return two_pi * static_cast<Real>(m.hertz);
}
template <class Real>
Real mains_phase(const Mains& m, const MainsPiece& piece) {
  return static_cast<Real>(m.phase + piece.jump);
}
/// V.
template <class Real>
Real mains_amplitude(const Mains& m, const MainsPiece& piece) {
  return std::sqrt(Real(2)) * static_cast<Real>(m.volts * piece.share);
}

/// u(t), V.
template <class Real>
Real mains_voltage(const Mains& m, const MainsPiece& piece, Real t) {
  if (m.kind == Mains::Kind::dc) return static_cast<Real>(m.volts * piece.share);
  const Real angle = mains_rate<Real>(m) * t + mains_phase<Real>(m, piece);
  Real wave = sine(angle);
  for (const auto& h : m.harmonics)
    if (h.share != 0)
      wave +=
          static_cast<Real>(h.share) * sine(static_cast<Real>(h.order) * angle + static_cast<Real>(h.phase));
  return mains_amplitude<Real>(m, piece) * wave;
}

/// An alternating sine without source impedance, harmonics and dips.
bool plain(const Mains&);

/// Throws std::invalid_argument naming what is out of range.
void require_valid(const Mains&);

}  // namespace powbench::sim
