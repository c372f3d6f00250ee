#pragma once

#include "sim/solid/cell_batches.h"
#include "sim/solid/contactor_mesh.h"
#include "sim/solid/solid_contact.h"
#include "sim/solid/solid_loads.h"

/// Where the parts of the contactor meet: layers with the stiffness and the damping of the specimen, the same on every
/// mesh. The compliance of the metal behind them is added.

namespace powbench::sim {

struct ContactorContacts {
  ContactOptions options;  ///< pads of each bridge, then stop, then seats of each bridge
  int stop = 0;            ///< pair: mover against base
  SolidPlane rest;         ///< that the mover rests on while open
  double seat_depth = 0;   ///< m, of each bridge in its seat under the preload of its spring, open
};

/// Linear layers F = k l + c dl/dt >= 0 whose sums over the faces that meet are
///   pads   k = contact_stiffness, c = pad_damping(specimen)
///   seats  k = seat_stiffness,    c = 2 seat_damping sqrt(k m_bridge)
///   stop, rest  k = stop_stiffness, c = stop_damping(specimen)
/// as in the lumped model. The rest lies so that everything is in balance with the mover `seat_depth` below its place
/// in the mesh.
ContactorContacts contactor_contacts(const ContactorMesh&, const CellBatches&, const Specimen&);

}  // namespace powbench::sim
