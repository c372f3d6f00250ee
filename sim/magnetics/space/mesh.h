#pragma once

#include <vector>

#include "sim/vec.h"

/// Meshes in three dimensions, one kind of cell each, and what the shape functions of the cells need.

namespace powbench::sim::space {

/// Cells by their nodes. Orders 1, 2 (serendipity), 2 (complete) of hexahedra; 1 and 2 of tetrahedra. The nodes of a
/// cell are in the order of gmsh.
enum class Cell { hex8, hex20, hex27, tet4, tet10 };

/// Shape functions N_a and their slopes dN_a/dxi at the integration points of the reference cell: the cube -1 .. 1, or
/// the tetrahedron with unit edges. 27 points; exact for stiffness on parallelepipeds.
struct CellRule {
  int nodes = 0;
  int points = 0;
  std::vector<Vec3> node;      ///< [node] place on the reference cell
  std::vector<double> weight;  ///< [point]
  std::vector<double> value;   ///< [point][node]
  std::vector<Vec3> slope;     ///< [point][node]
};

/// The rule of a kind of cell; computed once.
const CellRule& cell_rule(Cell);

/// Shape functions and slopes at one point of the reference cell.
void cell_shape(Cell, const Vec3& xi, std::vector<double>& value, std::vector<Vec3>& slope);

/// Nodes, cells and their regions.
struct Mesh {
  Cell cell = Cell::hex20;
  std::vector<Vec3> nodes;  ///< m
  std::vector<int> cells;   ///< [cell][node of the cell]
  std::vector<int> region;  ///< [cell], index into Problem::media

  int per_cell() const { return cell_rule(cell).nodes; }
  int count() const { return static_cast<int>(region.size()); }
};

/// The same tetrahedra, by their corners alone, with straight sides: Cell::tet10. Nodes that no cell uses are left out;
/// corners come first. A cell turned inside out is turned back.
Mesh straight_tetrahedra(const Mesh&);

/// Sets the values at the middles of the edges of such a mesh to the mean of their ends.
void set_middles(const Mesh&, std::vector<double>& values);

/// Six times the volume of the tetrahedron of four nodes of a mesh, below 0: turned inside out.
double six_volumes(const Vec3& a, const Vec3& b, const Vec3& c, const Vec3& d);

/// Gradients of the shape functions of cell `c` in space and the determinant of its Jacobian, from the slopes on the
/// reference cell. Throws std::invalid_argument for a cell turned inside out.
double cell_gradients(const Mesh&, int c, const Vec3* slope, Vec3* gradient);

}  // namespace powbench::sim::space
