#pragma once

#include <optional>
#include <string>

#include "sim/magnetics/plane/mesh.h"

/// The E-E contactor on an unstructured mesh of gmsh, given to GetDP and to FreeFem++ with the same law of the steel:
/// linear elements, full Newton steps from zero, one thread. Everything is written into a temporary folder.

namespace powbench::bench {

/// Regions of the peers' mesh, also their physical groups.
struct PeerRegion {
  enum : int { fixed_iron = 1, moving_iron, coil, air, rim = 10 };
};

struct PeerResult {
  double flux = 0;  ///< Wb a turn
  int iterations = 0;
  double cpu_iteration = 0;  ///< s: process time of the iterations beyond the second, by each of them
};

class Peers {
 public:
  explicit Peers(std::string folder);  ///< made if missing

  /// Meshes the half model at a gap, m; `size` scales all cells. Returns the mesh in m; empty without gmsh.
  std::optional<sim::Mesh> mesh(double gap, double size);

  /// On the last mesh; nothing without the program, or when it fails.
  std::optional<PeerResult> getdp(double ampere_turns);
  std::optional<PeerResult> freefem(double ampere_turns);

 private:
  std::string folder_;
};

}  // namespace powbench::bench
