#pragma once

/// The inner loops of contact: where the nodes near another part are and how far they have moved, and what faces they
/// see, eight nodes a block; compiled once for each instruction set and chosen at run time. Raw arrays only, as in
/// cell_kernel.h.
///
/// Rounding: products and sums are never fused, and each lane does what `project` (contact_geometry.h) does, in its
/// order. Every instruction set gives the bits of the plain code.

namespace powbench::sim {

inline constexpr int contact_lanes = 8;

/// Box of the displacements of many nodes, m.
struct MovedBox {
  double lo[4] = {1e300, 1e300, 1e300, 1e300}, hi[4] = {-1e300, -1e300, -1e300, -1e300};
};

/// Eight nodes, each seen from one four-sided face: the numbers of a `Projection`; and how far a node that does not
/// touch the face must at least move against it to touch it.
struct SeenFaces {
  double distance[contact_lanes], gap[contact_lanes], aside[contact_lanes], way[contact_lanes];
  double inner[contact_lanes];  ///< 1 at the middle of the face, 0 on its border and beyond
  double normal[3][contact_lanes];
  double weights[4][contact_lanes];
};

struct SeeTask {
  const double* points = nullptr;  ///< m, 4 numbers a node
  const int* point = nullptr;      ///< [lane]: 4 times the number of the node among `points`
  const double* places = nullptr;  ///< m, of the corners
  const int* corners = nullptr;    ///< [face][4]: 4 times the number of the corner among `places`
  const int* face = nullptr;       ///< [lane]
  int blocks = 0;                  ///< of eight lanes
  double limit = 0;                ///< m, distance beyond which nothing touches
  double ledge = 0;                ///< m, so far beyond its border a node may stand on a face
  SeenFaces* out = nullptr;        ///< [block]
};

/// Eight nodes that touch a face, and what friction does with them in one step.
struct PressedNodes {
  int node[contact_lanes], corner[4][contact_lanes];  ///< 4 times the number in the mesh
  double weights[4][contact_lanes], normal[3][contact_lanes];
  double stiff[contact_lanes];         ///< N/m
  double before[3][contact_lanes];     ///< N, tangential force of the step before
  double approach[contact_lanes];      ///< m/s, along the normal
  double speed[3][contact_lanes];      ///< m/s, in the face
  double trial[3][contact_lanes];      ///< N, tangential force should it stick; what it becomes
  double square[contact_lanes];        ///< N2, of the trial
  double normal_force[contact_lanes];  ///< N
  double force[3][contact_lanes];      ///< N, normal and tangential
  double lost[contact_lanes];          ///< J, by friction in this step
  double stored[contact_lanes];        ///< J, in the tangential spring
};

struct PressTask {
  const double* v = nullptr;  ///< m/s, 4 numbers a node
  double dt = 0;              ///< s
  int blocks = 0;
  PressedNodes* nodes = nullptr;
};

struct ContactKernel {
  const char* name;
  void (*see)(const SeeTask&);
  /// Speeds and trial forces, from what stands above them in PressedNodes.
  void (*slip)(const PressTask&);
  /// What comes of them, once `trial` is what it became and `normal_force` is there.
  void (*rub)(const PressTask&);
  /// Places x = reference + u of `count` nodes (all but u packed, 4 numbers a node); the box of what they moved since
  /// the x that stood there.
  MovedBox (*place)(const double* reference, const double* u, const int* node, int count, double* x);
  /// The box of u less `before` (packed).
  MovedBox (*moved)(const double* u, const int* node, int count, const double* before);
};

const ContactKernel& portable_contact_kernel();
const ContactKernel& avx2_contact_kernel();    ///< built on x86-64 only
const ContactKernel& avx512_contact_kernel();  ///< built on x86-64 only

/// The fastest this processor can run.
const ContactKernel& best_contact_kernel();

}  // namespace powbench::sim
