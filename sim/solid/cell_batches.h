#pragma once

#include <array>
#include <vector>

#include "sim/solid/cell_kernel.h"
#include "sim/solid/hex_shape.h"
#include "sim/solid/solid_material.h"
#include "sim/solid/solid_mesh.h"

/// The cells of a mesh, cut into batches that fit a processor's first cache: each copies the displacement of its nodes,
/// computes with local numbers and keeps its forces to itself. A node's force is the sum over its batches in their
/// order, so it does not depend on which thread computed which batch.

namespace powbench::sim {

/// Stress of one cell as ParaView wants it: xx yy zz xy yz xz, Pa (Cauchy), and the plastic strain.
struct CellStress {
  std::array<double, 6> stress{};
  double plastic = 0;
};

double von_mises(const CellStress&);

/// Energies of one part's cells, J.
struct CellEnergies {
  double strain = 0, hourglass = 0, plastic = 0;
};

class CellBatches {
 public:
  /// Throws std::invalid_argument for a bad mesh or material (see check_mesh, check_material), and for parts whose
  /// nodes do not stand together.
  CellBatches(const SolidMesh&, const std::vector<SolidMaterial>& materials, bool float_forces);

  int count() const { return static_cast<int>(batches_.size()); }
  int part_of(int batch) const { return batches_[static_cast<std::size_t>(batch)].part; }

  /// Computes the forces of one batch from displacement u and velocity v (4 numbers a node); `dt` is the step that led
  /// here. Safe for different batches at once. Returns -1, or the number of a cell that is inside out.
  int compute(int batch, const double* u, const double* v, double dt);

  const int* slot_begin() const { return slot_begin_.data(); }
  const int* slots() const { return slots_.data(); }
  bool in_float() const { return in_float_; }
  const double* forces() const { return forces_.data(); }
  const float* float_forces() const { return float_forces_.data(); }
  Vec3 node_force(int node) const;

  /// Lumped masses, kg: an eighth (a quarter) of the cell at each corner.
  const std::vector<double>& masses() const { return masses_; }
  int nodes_begin(int part) const { return part_begin_[static_cast<std::size_t>(part)]; }
  int nodes_end(int part) const { return part_begin_[static_cast<std::size_t>(part) + 1]; }
  const SolidMesh& mesh() const { return mesh_; }
  const SolidMaterial& material(int part) const { return materials_[static_cast<std::size_t>(part)]; }
  const CellKernel& kernel() const { return *kernel_; }

  CellEnergies energies(int part, const std::vector<double>& u) const;
  std::vector<CellStress> stresses(const std::vector<double>& u) const;

  /// Of all plastic cells, the smallest time a wave needs through one as it is now, s (0: there are none). The critical
  /// step shrinks with it. `gains`: by cell, what added inertia multiplies its step with; may be empty.
  double plastic_transit(const double* u, const std::vector<double>& gains) const;

  /// Everything the cells remember (stress, plastic strain, hourglass forces, work booked), for a restart.
  std::vector<double> memory() const;
  void restore_memory(const std::vector<double>&);

 private:
  enum class Kind { brick, hex, tet, plastic, plastic_tet };

  static bool flows(Kind k) { return k == Kind::plastic || k == Kind::plastic_tet; }
  static std::size_t corners_of(Kind k) { return k == Kind::tet || k == Kind::plastic_tet ? 4 : 8; }
  static std::size_t numbers_of(Kind);  ///< of shape or state, a cell

  struct Batch {
    Kind kind{};
    int part = 0, spare = 0;
    std::size_t force_place = 0;
    std::vector<int> cells, nodes, corners;
    std::vector<double> shape, state;
    std::vector<float> float_shape;
    double stored = 0, plastic = 0, hourglass = 0;  ///< booked work, J
  };

  Kind kind_of(const SolidCell&) const;
  void sort_parts();
  void cut();
  void fill(Batch&);
  void number_nodes(Batch&);
  void fill_shape(Batch&, std::size_t cell);
  void make_slots();
  void add_masses();
  template <class Real>
  double elastic(Batch&, const double* u);
  double plastic(Batch&, const double* u, const double* v, double dt);
  int inverted(const Batch&, const double* u) const;

  SolidMesh mesh_;
  std::vector<SolidMaterial> materials_;
  bool in_float_;
  const CellKernel* kernel_;
  std::vector<Batch> batches_;
  std::vector<int> part_begin_, slot_begin_, slots_;
  std::vector<double> masses_, forces_;
  std::vector<float> float_forces_;
};

/// Hourglass stiffness k_hi of an elastic hexahedron, N/m, [3 h + i]: bends and warps a brick along the axes exactly.
std::array<double, 12> hourglass_stiffness(const HexShape&, const SolidMaterial&);

}  // namespace powbench::sim
