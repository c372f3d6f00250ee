#pragma once

#include <array>
#include <string>
#include <vector>

#include "sim/solid/explicit_solid.h"

/// CalculiX as a peer: a separate process in a scratch folder, on one core.

namespace powbench::bench {

bool ccx_is_here();

struct CcxRun {
  bool ran = false;
  double cpu = 0;       ///< s, of the process
  double selected = 0;  ///< s, the time increment it chose
  std::string dat;      ///< its printed results
};
CcxRun run_ccx(const std::string& input);

/// 5000 cells of 1 mm, 300 increments or so; contact: "tied", "n2s" (node to surface) or "s2s".
std::string ccx_bar(const std::string& contact, double end);

/// The same cells with nodes in the middles of their edges, on the skin of a rod of this radius where both ends are.
sim::SolidMesh with_middles(const sim::SolidMesh&, double radius, std::vector<std::array<int, 20>>& cells);

/// The rod of taylor_bar() with its foot held in z: C3D20R, which does not lock where the flow keeps the volume, in
/// implicit steps of at most `dt`. Explicit C3D8 locks. SI turned to mm, N, t.
std::string ccx_taylor(const sim::SolidMesh&, const std::vector<std::array<int, 20>>& cells, double dt);

struct CcxTaylor {
  bool ran = false;
  double length = 0, radius = 0, plastic_strain = 0, cpu = 0;
};
CcxTaylor read_taylor(const sim::SolidMesh&, const CcxRun&);

}  // namespace powbench::bench
