#pragma once

#include <memory>
#include <optional>
#include <string>

#include "sim/magnetics/plane/drawn_magnet.h"

/// Drawings made from the outlines of docs/examples/own-magnet by gmsh, and the same magnets at other gaps by
/// FreeFem++ (quadratic elements, full Newton steps, pull by the stress weighted with a harmonic function of its own)
/// and, in the plane, by GetDP (quadratic elements). The steel is `reference`, solid. Everything is written into a
/// temporary folder.

namespace powbench::bench {

struct OwnPeerResult {
  double flux = 0, pull = 0;  ///< Wb, N, of the whole device
  int unknowns = 0;
  double getdp_flux = 0;  ///< Wb; 0: none
};

class OwnPeer {
 public:
  /// `folder` is made if missing; `outlines`: where the .geo files are.
  OwnPeer(std::string folder, std::string outlines);

  /// Meshes an outline with these lengths (arguments of gmsh) at a gap, m, and reads it. Nothing without gmsh.
  std::shared_ptr<const sim::DrawnMagnet> drawing(const std::string& outline, const std::string& lengths,
                                                  double gap, double size, double residual_gap,
                                                  double travel);

  /// Reads the mesh that `drawing` made last for this outline.
  std::shared_ptr<const sim::DrawnMagnet> read(const std::string& outline, double residual_gap,
                                               double travel) const;

  /// The same outline meshed at `gap`, solved at a current, A. Nothing without the programs, or where one fails.
  std::optional<OwnPeerResult> solve(const std::string& outline, const std::string& lengths, double gap,
                                     double size, double current);

 private:
  std::string folder_, outlines_;
};

}  // namespace powbench::bench
