#pragma once

#include <array>
#include <vector>

#include "sim/solid/solid_material.h"
#include "sim/specimen/specimen.h"

/// Base and bridges of a contactor as a few elastic coordinates each, from their finite elements: what the modal rung
/// adds to the rigid parts. Displacements along the closing direction only.

namespace powbench::sim {

/// Elastic coordinates of one body (modal masses 1 kg) and the shape of each at the places where forces act.
struct ElasticPart {
  std::vector<double> omega;               ///< rad/s, ascending
  std::vector<std::vector<double>> shape;  ///< kg^-1/2, shape[place][coordinate]

  int modes() const { return static_cast<int>(omega.size()); }
};

struct ModalPartsOptions {
  double cell = 3e-3;    ///< m, largest edge of a cell, 0.1 .. 10 mm
  int base_modes = 6;    ///< elastic modes of the base, before attachment modes
  int bridge_modes = 4;  ///< of each bridge
  bool attached = true;  ///< attachment modes: how a force bends the part at its place
  double stiffness = 1;  ///< factor on Young's modulus, > 0: large ones lead back to rigid parts
  double highest = 6e6;  ///< rad/s; coordinates above it are left out (they only cost steps)
};

/// Places of a base: pad of bridge j at end s is 2 j + s, the pole face is the last. Places of a bridge: pads at both
/// ends, edges of the seat at both ends, spring.
struct ModalParts {
  ElasticPart base, bridge;  ///< all bridges are equal
  int base_nodes = 0, bridge_nodes = 0;
};
enum BridgePlace : int { pad_place = 0, seat_place = 2, spring_place = 4, bridge_places = 5 };

/// Throws std::invalid_argument for a specimen whose parts do not fit, see contactor_mesh(), and options out of range.
ModalParts modal_parts(const Specimen&, const ModalPartsOptions& = {});

}  // namespace powbench::sim
