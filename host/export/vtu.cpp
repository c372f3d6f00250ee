#include "host/export/vtu.h"

#include <fmt/format.h>

#include <bit>
#include <cstring>
#include <iterator>
#include <stdexcept>

#include "host/export/base64.h"
#include "host/export/xml_text.h"

namespace powbench::host {
namespace {

int corners_of(VtkCell kind) {
  switch (kind) {
    case VtkCell::vertex:
      return 1;
    case VtkCell::line:
      return 2;
    case VtkCell::triangle:
      return 3;
    case VtkCell::quad:
    case VtkCell::tetrahedron:
      return 4;
    case VtkCell::wedge:
    case VtkCell::quadratic_triangle:
      return 6;
    case VtkCell::hexahedron:
      return 8;
    case VtkCell::quadratic_tetrahedron:
      return 10;
  }
  throw std::invalid_argument("VTU cell kind: not one of those listed in VtkCell");
}

/// One array as bytes, preceded by their number as an unsigned 64-bit word, as VTK wants both encodings.
template <class T>
std::string bytes_of(const std::vector<T>& values) {
  const std::uint64_t size = values.size() * sizeof(T);
  std::string out(sizeof size + size, '\0');
  std::memcpy(out.data(), &size, sizeof size);
  if (size > 0) std::memcpy(out.data() + sizeof size, values.data(), size);
  return out;
}

/// Collects the arrays: their XML as they come, their appended bytes for the end.
class Writer {
 public:
  explicit Writer(VtuEncoding encoding) : encoding_(encoding) {}

  void line(const std::string& xml) { xml_ += xml + '\n'; }

  template <class T>
  void array(const char* type, const std::string& name, int components, const std::vector<T>& values) {
    const std::string head = fmt::format("<DataArray type=\"{}\" Name=\"{}\" NumberOfComponents=\"{}\"", type,
                                         escaped(name), components);
    if (encoding_ == VtuEncoding::base64) {
      const std::string bytes = bytes_of(values);
      line(head + " format=\"binary\">" + base64(bytes) + "</DataArray>");
    } else {
      line(fmt::format("{} format=\"appended\" offset=\"{}\"/>", head, appended_.size()));
      appended_ += bytes_of(values);
    }
  }

  std::string finish() {
    if (encoding_ == VtuEncoding::appended_raw)
      xml_ += "<AppendedData encoding=\"raw\">\n_" + appended_ + "\n</AppendedData>\n";
    return xml_ + "</VTKFile>\n";
  }

 private:
  VtuEncoding encoding_;
  std::string xml_;
  std::string appended_;
};

void check_fields(const std::vector<VtuField>& fields, std::size_t count, const char* what) {
  for (const VtuField& f : fields)
    if (f.components < 1 || f.values.size() != count * static_cast<std::size_t>(f.components))
      throw std::invalid_argument(fmt::format("VTU field '{}': {} values, but {} {} of {} components need {}",
                                              f.name, f.values.size(), count, what, f.components,
                                              count * static_cast<std::size_t>(f.components)));
}

void check(const VtuGrid& grid, std::size_t points) {
  if (grid.points.size() % 3 != 0)
    throw std::invalid_argument("VTU points: their number of coordinates must be a multiple of 3");
  std::size_t corners = 0;
  for (const VtkCell kind : grid.cells) corners += static_cast<std::size_t>(corners_of(kind));
  if (corners != grid.connectivity.size())
    throw std::invalid_argument(fmt::format("VTU connectivity: {} corners, but the {} cells have {}",
                                            grid.connectivity.size(), grid.cells.size(), corners));
  for (const std::int64_t corner : grid.connectivity)
    if (corner < 0 || corner >= static_cast<std::int64_t>(points))
      throw std::invalid_argument(fmt::format("VTU connectivity: corner {} outside [0, {})", corner, points));
  check_fields(grid.point_fields, points, "points");
  check_fields(grid.cell_fields, grid.cells.size(), "cells");
}

void write_fields(Writer& out, const std::vector<VtuField>& fields, const char* tag) {
  out.line(fmt::format("<{}>", tag));
  for (const VtuField& f : fields) out.array("Float64", f.name, f.components, f.values);
  out.line(fmt::format("</{}>", tag));
}

const char* byte_order() {
  return std::endian::native == std::endian::little ? "LittleEndian" : "BigEndian";
}

}  // namespace

void VtuGrid::add_cell(VtkCell kind, const std::vector<std::int64_t>& corners) {
  cells.push_back(kind);
  connectivity.insert(connectivity.end(), corners.begin(), corners.end());
}

std::string to_vtu(const VtuGrid& grid, VtuEncoding encoding) {
  const std::size_t points = grid.points.size() / 3;
  check(grid, points);
  std::vector<std::int64_t> offsets;
  std::vector<std::uint8_t> kinds;
  std::int64_t end = 0;
  for (const VtkCell kind : grid.cells) {
    offsets.push_back(end += corners_of(kind));
    kinds.push_back(static_cast<std::uint8_t>(kind));
  }
  Writer out(encoding);
  out.line("<?xml version=\"1.0\"?>");
  out.line(fmt::format(
      "<VTKFile type=\"UnstructuredGrid\" version=\"1.0\" byte_order=\"{}\" header_type=\"UInt64\">",
      byte_order()));
  out.line("<UnstructuredGrid>");
  out.line(fmt::format("<Piece NumberOfPoints=\"{}\" NumberOfCells=\"{}\">", points, grid.cells.size()));
  write_fields(out, grid.point_fields, "PointData");
  write_fields(out, grid.cell_fields, "CellData");
  out.line("<Points>");
  out.array("Float64", "Points", 3, grid.points);
  out.line("</Points>\n<Cells>");
  out.array("Int64", "connectivity", 1, grid.connectivity);
  out.array("Int64", "offsets", 1, offsets);
  out.array("UInt8", "types", 1, kinds);
  out.line("</Cells>\n</Piece>\n</UnstructuredGrid>");
  return out.finish();
}

std::string to_pvd(const std::vector<PvdStep>& steps) {
  std::string out = fmt::format(
      "<?xml version=\"1.0\"?>\n<VTKFile type=\"Collection\" version=\"1.0\" "
      "byte_order=\"{}\">\n<Collection>\n",
      byte_order());
  for (const PvdStep& s : steps)
    fmt::format_to(std::back_inserter(out), "<DataSet timestep=\"{:.17g}\" part=\"{}\" file=\"{}\"/>\n",
                   s.time, s.part, escaped(s.file));
  return out + "</Collection>\n</VTKFile>\n";
}

}  // namespace powbench::host
