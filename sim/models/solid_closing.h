#pragma once

#include <array>
#include <functional>

#include "core/conditions.h"
#include "sim/magnetics/potential.h"
#include "sim/solid/contactor_mesh.h"
#include "sim/solid/explicit_solid.h"

/// One closing with deforming parts: coil and field in turn with the bodies. In every coupling interval
///
///   gap -> potential -> current, pull; psi += (u - R i) dt, phi_s -= R_s i_s dt; pull as body load on mover and
///   base; bodies move on; gap -> ...
///
/// Parts are rigid in flight and deform from `window` before the first touch on.

namespace powbench::sim {

struct SolidClosingOptions {
  double cell = 2e-3;           ///< m
  double end = 30e-3;           ///< s
  double coupling = 5e-7;       ///< s, between two looks at the field
  double window = 0.2e-3;       ///< s, deformable so long before the first touch
  double flight_step = 2.5e-7;  ///< s, while everything is rigid
  double sample = 5e-6;         ///< s, between samples while parts deform; 50 us in flight
  bool deform = true;           ///< false: rigid throughout
  bool pressed_gap = true;      ///< the potential is also defined for gap < 0, faces pressed together
  int workers = 1;
  SolidOptions solid;
};

/// One state, for curves and pictures.
struct SolidClosingSample {
  double time = 0, current = 0, flux = 0, pull = 0;
  double travel = 0, base = 0;  ///< m, of mover and base
  double pad_force = 0;         ///< N, of the first bridge on its pads
  std::vector<double> bridges;  ///< m, mean of each bridge
};

/// Of the magnet, J. Supplied less lost, field and pull work is zero but for the error of the coupling.
struct CoilEnergies {
  double supplied = 0;   ///< integral of u i dt
  double lost = 0;       ///< in coil and ring
  double field = 0;      ///< stored now
  double pull_work = 0;  ///< integral of pull along the gap: what the bodies get

  double residual() const { return supplied - lost - field - pull_work; }
};

struct SolidClosingResult {
  double first_touch = -1, core_seat = -1, last_touch = -1;  ///< s, of the first bridge and the mover
  int openings = 0;                                          ///< of the first bridge
  std::vector<std::array<double, 2>> open;                   ///< s, each of them: from, to
  double peak_force = 0;                                     ///< N, on the first bridge's pads
  double residual = 0;  ///< largest energy residual over the largest energy
  SolidEnergies energies;
  CoilEnergies electric;
  long cells = 0, rigid_steps = 0, deformed_steps = 0;
  int scaled_cells = 0;                     ///< with inertia added on request (SolidOptions::scale_masses_to)
  double added_inertia = 0;                 ///< theirs over the mass of all bodies
  std::vector<SolidClosingSample> samples;  ///< in their order of time
};

/// `watch` sees the bodies at each sample, and the state a SolidStop leaves behind. Throws SolidStop,
/// std::invalid_argument.
SolidClosingResult solid_closing(
    const Specimen&, const Conditions&, const MagneticPotential&, const SolidClosingOptions&,
    const std::function<void(const ExplicitSolid&, const ContactorMesh&)>& watch = {});

}  // namespace powbench::sim
