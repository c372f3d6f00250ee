#pragma once

#include <iosfwd>
#include <optional>
#include <string>
#include <vector>

#include "sim/magnetics/plane/mesh.h"

/// What every peer needs: outlines for gmsh, meshes in and out, programs run and their CPU time taken.

namespace powbench::bench {

bool have_program(const std::string& program);

/// Runs a command with the shell; CPU seconds of the process and its children, or nothing where it fails. One thread.
std::optional<double> cpu_of(const std::string& command);

void write_file(const std::string& path, const std::string& text);

/// Corner of an outline in mm, and the cell size beside it.
struct Corner {
  double x, y, size;
};

/// Closed outline as points, lines and the curve loop `loop` of a gmsh script; `point` and `curve` count on.
void polygon(std::ostream& out, int& point, int& curve, int loop, const std::vector<Corner>& corners);

/// Reads an ASCII mesh of version 2.2: triangles with their physical group as region, A = 0 on lines of the group
/// `rim`.
sim::Mesh read_msh2(const std::string& path, int rim);

/// FreeFem++'s own format; the rim (label 10) are the outer edges between vertices where A = 0.
void write_freefem_mesh(const std::string& path, const sim::Mesh&);

/// H(B) = nu B with nu = 100 + 10 exp(1.8 B^2), the steel `reference`, up to the field where the slope is 1/mu0.
inline constexpr const char *law_end = "2.16084356878122", *law_end_h = "96757.2372516224";

}  // namespace powbench::bench
