#pragma once

#include <memory>
#include <string>
#include <vector>

#include "core/units.h"
#include "sim/magnetics/circuit/lumped_magnet.h"
#include "sim/magnetics/magnet_shape.h"

/// One contactor, as the simulator sees it. SI. The defaults are the reference contactor of
/// `scenes/reference.specimen.toml`. Symbols are those of docs/reference/notation.md.

namespace powbench::sim {

struct DrawnMagnet;  // sim/magnetics/plane/drawn_magnet.h
struct SpaceMagnet;  // sim/magnetics/space/space_magnet.h

/// Coil: u = R i + d psi/dt.
struct Coil {
  double turns = 2000;                       ///< N
  double resistance = 245;                   ///< R at 20 degC, ohm
  double leakage = 0.25;                     ///< L_leak, H: flux that links the coil and crosses no pole gap
  double temperature_coefficient = 3.93e-3;  ///< 1/K, copper: R(T) = R (1 + alpha (T - 293.15 K))
};

/// Moving core with its bracket (the "holder"), return spring and stop on the static core.
struct Core {
  double mass = 0.1995;                  ///< M, kg: armature and holder
  double travel = 4.06e-3;               ///< m: contact gap plus overtravel
  double return_preload = 9.15;          ///< F_r0, N, open
  double return_rate = 1890;             ///< k_r, N/m
  double friction = 2.0;                 ///< F_f, N, Coulomb
  double stop_stiffness = 3.14e7;        ///< k_core, N/m
  double stop_restitution = 0.13126570;  ///< e_core, rebound of a drop test (sim/mechanics/contact_damping.h)
  double stop_exponent = 1;              ///< n: 1, 1.5 (Hertz) or 2
  double stop_depth = 10e-6;             ///< d_0, m: with n > 1, where F = k d_0
  double stop_speed = 0.5;               ///< m/s: with n > 1, of the drop test
  double tilt_inertia = 0;     ///< I, kg m2: of core and holder against tilt; 0: guided without play
  double tilt_hertz = 300;     ///< f_t: mode of the tilt on guide and springs
  double tilt_damping = 0.05;  ///< z_t
  double pole_arm = 12e-3;     ///< m: pole faces and stops from the tilt axis
};

/// Contact bridges with overtravel springs. Forces, rates and masses are those of ONE bridge.
struct Bridges {
  int poles = 3;                      ///< number of equal double-break bridges
  double gap = 2.50e-3;               ///< x_c, m: travel to first touch
  double mass = 7.76e-3;              ///< m_c, kg
  double preload = 3.07;              ///< F_c0, N: overtravel spring, open
  double rate = 3000;                 ///< k_c, N/m
  double contact_stiffness = 2.86e6;  ///< k_con, N/m, both breaks together
  double contact_restitution =
      0.51133007;                    ///< e_con, rebound of a drop test (sim/mechanics/contact_damping.h)
  double contact_exponent = 1;       ///< n: 1, 1.5 (Hertz) or 2
  double contact_depth = 10e-6;      ///< d_0, m: with n > 1, where F = k d_0
  double contact_speed = 0.5;        ///< m/s: with n > 1, of the drop test
  double seat_stiffness = 1.667e6;   ///< N/m: bridge against its seat in the holder
  double seat_damping = 0.10192631;  ///< damping ratio of the seat
  double half_length = 12e-3;        ///< m: bridge centre to break
  double seat_half_length = 4e-3;    ///< m: bridge centre to each edge of its seat
  double inertia = 6.0e-7;           ///< kg m2, about the tilt axis
  double tilt_gap = 0.0;             ///< m: break B opens this much wider than break A (tilted bridge)
  double pitch = 0.0;                ///< m: from pole to pole along the lever of the core's tilt
  double gap_spread = 0.0;  ///< m: each pole opens this much wider than the one before; the first is measured
};

/// Static core and fixed contacts as one floating mass on the mounting; or, with a `core_mass`, the static core as a
/// second mass on buffer springs in the housing that carries the fixed contacts.
struct Base {
  double mass = 0.100;         ///< M_h, kg
  double hertz = 137.5;        ///< f_h: mounting mode
  double damping = 0.020;      ///< z_h
  double core_mass = 0;        ///< M_s, kg: static core on its buffer; 0 = it is part of M_h
  double core_hertz = 250;     ///< f_s: mode of M_s on the buffer, housing held
  double core_damping = 0.05;  ///< z_s
  int flex_modes = 0;          ///< bending modes of the housing, a free beam along the poles
  double flex_hertz = 820;     ///< f_1; the higher ones at 2.757 and 5.404 times that
  double flex_mass = 0.15;     ///< kg, modal, of each
  double flex_damping = 0.01;  ///< z of each
};

struct Specimen {
  std::string name = "reference";
  Coil coil;
  Magnet magnet;
  Core core;
  Bridges bridges;
  Base base;
  bool shaped = true;  ///< `shape` is this contactor's; else only the circuit describes its magnet
  MagnetShape shape;   ///< read by the field rungs alone; the lumped circuit has its own lengths in `magnet`
  std::shared_ptr<const DrawnMagnet> drawn;     ///< of `magnet.drawing`, in place of `shape`; null: none
  std::shared_ptr<const SpaceMagnet> in_space;  ///< the same, of a drawing in space
  bool lumped = true;  ///< false: a drawn magnet whose circuit is not stated; only its table describes it
};

}  // namespace powbench::sim
