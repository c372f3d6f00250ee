#pragma once

#include <string>
#include <vector>

#include "sim/magnetics/steel.h"

namespace powbench::sim {

/// Magnetic circuit with two parallel pole faces, one of them inside the shading ring.
struct Magnet {
  double pole_area = 2.74e-4;        ///< A_c, m2: centre pole; both outer poles together have the same
  double iron_length = 0.14;         ///< l_fe, m
  double residual_gap = 36e-6;       ///< d_min, m per pole when closed
  double fringing = 0.50;            ///< A_eff = A (1 + fringing gap / sqrt(A))
  double shaded_share = 0.648;       ///< a_2: share of the outer-pole area inside the shading ring
  double ring_resistance = 1.18e-3;  ///< R_sh, ohm, one turn
  double bh_linear = 100.0;          ///< H(B) = bh_linear B + bh_power B^bh_exponent, A/m and T
  double bh_power = 8.0;
  double bh_exponent = 11.0;
  std::string steel;                     ///< a measured curve in place of that law, by its name; "": the law
  std::vector<double> steel_b, steel_h;  ///< T, A/m: its rows; empty: a built-in steel of that name
  std::string drawing;                   ///< file of the magnet's drawing; "": none, see Specimen::drawn
  std::string drawing_hash;              ///< of its content, 16 hexadecimal digits
  double coercive_field = 0;             ///< H_c, A/m; 0: the iron forgets
  double coercive_span = 0.1;            ///< B_c, T: change of B in which the coercive field turns over
  double remanence = 0;                  ///< -1 .. 1: left by the last switch-off, of the largest there is
};

/// The iron of a magnet: its measured rows, the built-in steel of its name, or without a name the law a B + b B^n.
/// Throws std::invalid_argument for a name that is not built in and for rows that are no curve (`Steel::table`).
Steel steel_of(const Magnet&);

}  // namespace powbench::sim
