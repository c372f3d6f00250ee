#pragma once

#include "sim/solid/explicit_solid.h"

/// Impacts whose outcome is known: set-up, run, and the numbers to compare. Tests assert them, the table prints them.

namespace powbench::bench {

struct BarOnWall {
  double contact_error = 0;                  ///< contact time / (2 L / c) - 1
  double kinetic_low = 0, kinetic_high = 0;  ///< after the rebound, over the kinetic energy before
  double hourglass = 0;                      ///< largest hourglass over largest strain energy
  double residual = 0;                       ///< largest |energy residual| over the start's
};
/// nu = 0, `cells` long, no gap, 1 m/s.
BarOnWall bar_on_wall(int cells, double safety, double factor);

struct ConfinedBar {
  double touch = 0, leave = 0;  ///< s
  double plateau = 0;           ///< Pa, mean stress at the foot between 30 % and 70 % of the contact
  double front = 0;  ///< m/s, speed of the half-height of the front between 20 % and 60 % of the bar
};
/// SDNV100 of Code_Aster: L = 0.2 m, E = 2e11, nu = 0.3, rho = 8000, gap 2 mm, 100 m/s, lateral strain prevented.
ConfinedBar confined_bar(int cells);

struct TwoBars {
  double contact_error = 0;          ///< contact time / (2 L / c) - 1
  double v_first = 0, v_second = 0;  ///< after, over before (0 and 1 expected)
  double force_error = 0;            ///< mean contact force at mid-contact / (rho c v A / 2) - 1
  double residual = 0;
};
/// Equal bars, nu = 0, 100 cells each; `nodes_meet` or with different sections of mesh.
TwoBars two_bars(bool nodes_meet);

struct SphereImpact {
  double depth = 0, force = 0, time = 0;  ///< m, N, s
  long cells = 0, steps = 0;
};
/// Steel body with the face and the mass of a ball R = 10 mm on a steel half-space at 1 m/s, a quarter of it;
/// `finest` cell at the pole, m.
SphereImpact sphere_on_half_space(double finest, int workers);

struct CylinderContact {
  double half_width = 0, pressure = 0;  ///< m, Pa
  double load = 0;                      ///< N/m reached
};
/// Steel cylinder R = 50 mm pressed on an aluminium block with 35 kN/mm, plane strain, no friction.
CylinderContact cylinder_on_block(double finest);

struct TaylorBar {
  double length = 0, radius = 0, plastic_strain = 0;  ///< m, m, 1
  double residual = 0;
  long steps = 0;
};
/// Copper rod R 3.2 mm, L 32.4 mm, 227 m/s, yield 400 MPa, hardening 100 MPa, quarter mesh; after 80 us.
/// `held`: the foot cannot leave the wall, as the peer has it. Tetrahedra: twelve around the middle of each hexahedron.
/// `hourglass`: SolidMaterial::hourglass.
enum class TaylorCells { hexahedra, tetrahedra };
TaylorBar taylor_bar(int across, int along, bool held, TaylorCells = TaylorCells::hexahedra,
                     double hourglass = 1);
/// The mesh of it, for the peer.
sim::SolidMesh taylor_mesh(int across, int along);

/// A copper contact bridge (24 x 6 x 1.5 mm) that falls flat with 0.6 m/s on two rigid pads with springs of 3e6 N/m
/// each at its ends: reduced against explicit, over the first contact.
struct BridgeOnPads {
  double worst = 0;       ///< largest difference of the forces over the peak force
  double rms = 0;         ///< root mean square of the difference over the peak
  double peak_error = 0;  ///< of the peaks
  double impulse_error = 0;
  int modes = 0;         ///< elastic and attachment modes
  double cpu_ratio = 0;  ///< explicit over reduced
};
std::vector<BridgeOnPads> bridge_on_pads(const std::vector<int>& modes, bool attachments);

/// First bending frequency of a square steel beam (nu 0.3) over the Euler-Bernoulli value less 1; slenderness L / h.
double cantilever_error(int through, double slenderness, double hourglass = 1);

}  // namespace powbench::bench
