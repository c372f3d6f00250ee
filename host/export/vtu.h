#pragma once

#include <cstdint>
#include <string>
#include <vector>

/// Unstructured grids for ParaView: one VTU file a state, one PVD file that puts states in their order of time.

namespace powbench::host {

/// Cell kinds of the VTK file format, with its numbers and its order of corners.
enum class VtkCell : std::uint8_t {
  vertex = 1,
  line = 3,
  triangle = 5,
  quad = 9,
  tetrahedron = 10,
  hexahedron = 12,
  wedge = 13,
  quadratic_triangle = 22,
  quadratic_tetrahedron = 24
};

/// One named field over the points or over the cells; components vary fastest.
struct VtuField {
  std::string name;    ///< with its unit, as in "stress [Pa]"
  int components = 1;  ///< 1 scalar, 3 vector, 6 symmetric tensor xx yy zz xy yz xz, 9 tensor
  std::vector<double> values;
};

/// The grid. Points are x y z of point 0, x y z of point 1, ...; a plane grid has z = 0.
struct VtuGrid {
  std::vector<double> points;              ///< m, 3 a point
  std::vector<std::int64_t> connectivity;  ///< corners of all cells, one cell after the other
  std::vector<VtkCell> cells;              ///< the kind of each cell
  std::vector<VtuField> point_fields;
  std::vector<VtuField> cell_fields;

  void add_cell(VtkCell kind, const std::vector<std::int64_t>& corners);
};

enum class VtuEncoding {
  appended_raw,  ///< binary after the XML: small and quick, not well-formed XML
  base64         ///< inside the XML, a third larger
};

/// The file's content. Throws std::invalid_argument where sizes do not fit together: a field whose length is not
/// components times points (cells), a corner that is not a point, connectivity that does not match the kinds of cells.
std::string to_vtu(const VtuGrid&, VtuEncoding = VtuEncoding::appended_raw);

/// One state of a collection.
struct PvdStep {
  double time = 0;   ///< s
  std::string file;  ///< of the VTU, relative to the PVD
  int part = 0;      ///< distinguishes several files of one time
};

/// A ParaView collection of VTU files.
std::string to_pvd(const std::vector<PvdStep>&);

}  // namespace powbench::host
