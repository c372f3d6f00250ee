#pragma once

/// The inner loops of explicit dynamics: nodal forces of a batch of cells, 16 cells a block, compiled once for each
/// instruction set and chosen at run time. Raw arrays only, so that nothing compiled for a newer processor can be taken
/// by the linker for code that runs on an older one.
///
/// All arrays of nodes are local to the batch, 4 numbers a node (x y z and one unused); all arrays of cells are
/// [block][number][16]. Lanes beyond the last cell have zero shape and name the batch's spare node.
///
/// Rounding: products and sums are fused where the processor can, so processors with and without fused multiply-add
/// give different last digits. On one processor results are bit-reproducible and do not depend on the number of
/// threads.

namespace powbench::sim {

inline constexpr int block_cells = 16;

/// Numbers a cell in `shape`. Bricks: b_1..3 (9), V, k (12). Hexahedra: b_1..6 (18), V, k (12), hourglass (12).
/// Tetrahedra: gradients of L1..L3 = barycentric coordinates 1..3 (9), V.
inline constexpr int brick_numbers = 22;
inline constexpr int hex_numbers = 43;
inline constexpr int tet_numbers = 10;

/// State of a plastic cell: Cauchy stress xx yy zz xy yz xz, plastic strain and, of hexahedra, hourglass forces (12).
inline constexpr int plastic_numbers = 19;
inline constexpr int plastic_tet_numbers = 7;

template <class Real>
struct ElasticBatch {
  const int* nodes = nullptr;  ///< [block][8 or 4][16]: 4 times the local number
  const Real* shape = nullptr;
  const Real* u = nullptr;  ///< m, displacement
  Real* f = nullptr;        ///< N, the forces of the cells are added
  int blocks = 0;
  Real lambda = 0, mu = 0;  ///< Pa
};

struct PlasticBatch {
  const int* nodes = nullptr;
  double* state = nullptr;
  const double* x = nullptr;  ///< m, position now
  const double* v = nullptr;  ///< m/s, half a step ago
  double* f = nullptr;
  int blocks = 0;
  double lambda = 0, mu = 0, yield = 0, hardening = 0;  ///< Pa
  double hourglass = 0;                                 ///< Pa: stiffness is this times V B:B / 72
  double dt = 0;                                        ///< s
  double stored = 0;          ///< out, J: work of the stress in this step, elastic and plastic
  double hourglass_work = 0;  ///< out, J
  double plastic_work = 0;    ///< out, J: share of `stored` that is gone
};

/// One step of the central difference for nodes first .. last - 1: f = sum of the node's slots in the batches' force
/// arrays, in their order; v = (1 - a) v + dt f / m, divided by 1 + a (a = damping dt / 2); u += v dt.
template <class Real>
struct NodeRange {
  int first = 0, last = 0;
  const int* slot_begin = nullptr;       ///< of node n: slots[slot_begin[n]] .. slots[slot_begin[n + 1] - 1]
  const int* slots = nullptr;            ///< places in `f`
  const Real* f = nullptr;               ///< N
  const double* inverse_mass = nullptr;  ///< 1/kg, 4 a node; 0 where fixed
  double* v = nullptr;
  double* u = nullptr;
  double dt = 0;       ///< s
  double drift = 0;    ///< s, dt of the displacement
  double damping = 0;  ///< a
};

struct CellKernel {
  const char* name;
  /// Each returns the smallest J (plastic: smallest V, m3; linear: 1) of its cells.
  double (*brick)(const ElasticBatch<double>&, bool linear);
  double (*hex)(const ElasticBatch<double>&, bool linear);
  float (*brick_float)(const ElasticBatch<float>&, bool linear);
  float (*hex_float)(const ElasticBatch<float>&, bool linear);
  double (*tet)(const ElasticBatch<double>&, bool linear);
  double (*plastic)(PlasticBatch&);
  double (*plastic_tet)(PlasticBatch&);
  void (*advance)(const NodeRange<double>&);
  void (*advance_float)(const NodeRange<float>&);
};

const CellKernel& portable_cell_kernel();
const CellKernel& avx2_cell_kernel();    ///< built on x86-64 only
const CellKernel& avx512_cell_kernel();  ///< built on x86-64 only

/// The fastest this processor can run.
const CellKernel& best_cell_kernel();

}  // namespace powbench::sim
