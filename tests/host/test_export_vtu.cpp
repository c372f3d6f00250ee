#include <catch2/catch.hpp>
#include <cstring>
#include <stdexcept>

#include "host/export/vtu.h"

using namespace powbench::host;

namespace {

VtuGrid two_cells() {
  VtuGrid g;
  g.points = {0, 0, 0, 1, 0, 0, 1, 1, 0, 0, 1, 0, 0, 0, 1};
  g.add_cell(VtkCell::tetrahedron, {0, 1, 3, 4});
  g.add_cell(VtkCell::triangle, {1, 2, 3});
  g.point_fields.push_back({"u [m]", 3, std::vector<double>(15, 0.25)});
  g.cell_fields.push_back({"p <&> \"q\"", 1, {1.5, -2.5}});
  return g;
}

std::string unbase64(const std::string& text) {
  const std::string digits = "ABCDEFGHIJKLMNOPQRSTUVWXYZabcdefghijklmnopqrstuvwxyz0123456789+/";
  std::string out;
  std::uint32_t word = 0;
  int bits = 0;
  for (const char c : text) {
    if (c == '=') break;
    word = word << 6 | static_cast<std::uint32_t>(digits.find(c));
    bits += 6;
    if (bits >= 8) out += static_cast<char>(word >> (bits -= 8) & 255u);
  }
  return out;
}

template <class T>
T at(const std::string& bytes, std::size_t offset) {
  T value{};
  REQUIRE(offset + sizeof value <= bytes.size());
  std::memcpy(&value, bytes.data() + offset, sizeof value);
  return value;
}

/// The offset attribute of the array called `name`.
std::size_t offset_of(const std::string& xml, const std::string& name) {
  const auto place = xml.find("Name=\"" + name);
  REQUIRE(place != std::string::npos);
  return std::stoul(xml.substr(xml.find("offset=\"", place) + 8));
}

}  // namespace

TEST_CASE("appended VTU: every array is where its offset says, with its length in front") {
  const std::string file = to_vtu(two_cells());
  const std::size_t start = file.find("raw\">\n_") + 7;
  const std::string data = file.substr(start);
  const std::size_t points = offset_of(file, "Points");
  CHECK(at<std::uint64_t>(data, points) == 15 * sizeof(double));
  CHECK(at<double>(data, points + 8 + 3 * sizeof(double)) == 1.0);
  const std::size_t corners = offset_of(file, "connectivity");
  CHECK(at<std::uint64_t>(data, corners) == 7 * sizeof(std::int64_t));
  CHECK(at<std::int64_t>(data, corners + 8 + 3 * 8) == 4);
  const std::size_t ends = offset_of(file, "offsets");
  CHECK(at<std::int64_t>(data, ends + 8) == 4);
  CHECK(at<std::int64_t>(data, ends + 16) == 7);
  const std::size_t types = offset_of(file, "types");
  CHECK(at<std::uint8_t>(data, types + 8) == 10);
  CHECK(at<std::uint8_t>(data, types + 9) == 5);
  const std::size_t p = offset_of(file, "p &lt;&amp;&gt; &quot;q&quot;");
  CHECK(at<double>(data, p + 16) == -2.5);
}

TEST_CASE("base64 VTU holds the same numbers") {
  const std::string file = to_vtu(two_cells(), VtuEncoding::base64);
  const auto place = file.find("Name=\"u [m]\"");
  const auto begin = file.find('>', place) + 1;
  const std::string bytes = unbase64(file.substr(begin, file.find('<', begin) - begin));
  REQUIRE(bytes.size() == 8 + 15 * 8);
  CHECK(at<std::uint64_t>(bytes, 0) == 120);
  CHECK(at<double>(bytes, 8 + 14 * 8) == 0.25);
}

TEST_CASE("a grid that does not fit together is refused") {
  VtuGrid short_field = two_cells();
  short_field.cell_fields[0].values.pop_back();
  CHECK_THROWS_AS(to_vtu(short_field), std::invalid_argument);
  VtuGrid wrong_corner = two_cells();
  wrong_corner.connectivity[0] = 5;
  CHECK_THROWS_AS(to_vtu(wrong_corner), std::invalid_argument);
  VtuGrid missing = two_cells();
  missing.connectivity.pop_back();
  CHECK_THROWS_AS(to_vtu(missing), std::invalid_argument);
}

TEST_CASE("a collection lists its states with their times") {
  const std::string pvd = to_pvd({{0.0, "a_0.vtu", 0}, {1e-3, "a_1.vtu", 0}});
  CHECK(pvd.find("timestep=\"0.001\" part=\"0\" file=\"a_1.vtu\"") != std::string::npos);
}
