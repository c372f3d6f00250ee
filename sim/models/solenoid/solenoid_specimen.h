#pragma once

#include <string>

#include "sim/magnetics/plane/solenoid_field.h"

/// One solenoid, as the simulator sees it: a coil, a plunger between two stops, a spring and a load. SI. The defaults
/// are those of `powbench plan template solenoid`.

namespace powbench::sim {

/// Coil: u = R i + d psi/dt, R(T) = R (1 + alpha (T - 293.15 K)). Its turns stand in SolenoidDesign.
struct SolenoidCoil {
  double resistance = 9;                     ///< R at 20 degC, ohm
  double temperature_coefficient = 3.93e-3;  ///< alpha, 1/K, copper

  /// Economiser with a tap: from `hold_from` on an auxiliary contact, moved by the plunger, feeds both windings in
  /// series; before, the coil alone is fed and the hold winding carries no current. Both wind round the same flux, so
  /// the ampere turns do not jump.
  double hold_turns = 0;       ///< of the hold winding; 0: none
  double hold_resistance = 0;  ///< ohm, at 20 degC
  double hold_from = 0;        ///< m, travel of the plunger at which the contact changes over
};

/// Plunger, spring, load and stops.
struct SolenoidPlunger {
  double mass = 0.07;             ///< kg, the plunger and what is fixed to it
  double load_mass = 0;           ///< kg, moved by the plunger
  double return_preload = 5;      ///< N, spring at the open stop
  double return_rate = 300;       ///< N/m
  double load = 0;                ///< N, constant, against the closing; below zero: with it
  double friction = 0;            ///< N, Coulomb
  double stop_stiffness = 1e7;    ///< N/m, of both stops
  double stop_restitution = 0.2;  ///< rebound over approach speed at both stops, 0.01 .. 1

  double moving_mass() const { return mass + load_mass; }
};

struct SolenoidSpecimen {
  std::string name = "solenoid";
  SolenoidDesign design;    ///< `largest_gap` is the travel
  double conductivity = 0;  ///< S/m, of the iron parts, for closings with eddy currents; 0: none
  SolenoidCoil coil;
  SolenoidPlunger plunger;

  double travel() const { return design.largest_gap; }  ///< m
};

/// Throws std::invalid_argument with section, key, value and range: of `check_solenoid` and of numbers that do not go
/// together.
void require_valid(const SolenoidSpecimen&);

}  // namespace powbench::sim
