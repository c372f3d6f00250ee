#pragma once

#include <string>
#include <string_view>
#include <vector>

#include "sim/magnetics/plane/field_problem.h"

/// A plane mesh drawn elsewhere, with the materials named by its physical groups (gmsh, MSH 2.2 or 4.1):
///
///   surfaces air, steel (the specimen's, stacked), armature (the same steel, whose pull is wanted), any built-in
///   steel by its
///             name, coil+ and coil- (out of the plane, into it); the turns spread evenly over each
///   lines     A=0: no flux leaves through them. Other edges: flux leaves at a right angle

namespace powbench::host {

struct FieldMeshOptions {
  double metres = 1e-3;  ///< m, unit of the file
  double turns = 1;
  double depth = 1;  ///< m; times 2 for the half of a symmetric device, whose winding is coil+ alone
  sim::Steel steel = sim::Steel::linear(1);
};

struct FieldMesh {
  sim::Mesh mesh;
  sim::FieldSetup setup;
  std::vector<double> armature;  ///< weight of the force by vertex: 1 on the armature; empty without one
};

/// Throws BadInput, all mistakes at once, each with the name `where`: what read_msh refuses, groups without a known
/// name, no coil+, no line A=0, an extent outside 5 mm .. 5 m (a slip of unit), steel that touches the armature.
FieldMesh read_field_mesh(std::string_view content, const std::string& where, const FieldMeshOptions&);

}  // namespace powbench::host
