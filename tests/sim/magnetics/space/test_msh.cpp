#include <catch2/catch.hpp>
#include <cstring>
#include <string>

#include "sim/magnetics/plane/msh.h"

using powbench::sim::MshShape;
using powbench::sim::read_msh;

namespace {

const std::string format = "$MeshFormat\n4.1 0 8\n$EndMeshFormat\n";
const std::string names = "$PhysicalNames\n2\n2 7 \"iron core\"\n1 3 \"outer\"\n$EndPhysicalNames\n";
const std::string entities =
    "$Entities\n0 1 1 0\n5 0 0 0 1 0 0 1 3 0\n1 0 0 0 1 1 0 1 -7 1 5\n$EndEntities\n";
const std::string nodes =
    "$Nodes\n1 4 10 40\n2 1 0 4\n10\n20\n30\n40\n0 0 0\n1 0 0\n1 1 0\n0 1e0 0\n$EndNodes\n";
const std::string elements =
    "$Elements\n2 3 1 3\n1 5 1 1\n1 10 20\n2 1 2 2\n2 10 20 30\n3 10 30 40\n$EndElements\n";
const std::string square = format + names + entities + nodes + elements;

std::string replaced(std::string text, const std::string& what, const std::string& by) {
  const auto at = text.find(what);
  REQUIRE(at != std::string::npos);
  return text.replace(at, what.size(), by);
}

std::string refusal(const std::string& text) {
  try {
    read_msh(text);
  } catch (const std::invalid_argument& e) {
    return e.what();
  }
  return "accepted";
}

/// The square as a binary file.
std::string binary_square() {
  std::string out = "$MeshFormat\n4.1 1 8\n";
  const auto put = [&](auto value) {
    char bytes[sizeof value];
    std::memcpy(bytes, &value, sizeof value);
    out.append(bytes, sizeof value);
  };
  const auto ints = [&](std::initializer_list<int> list) {
    for (const int v : list) put(v);
  };
  const auto sizes = [&](std::initializer_list<std::uint64_t> list) {
    for (const auto v : list) put(v);
  };
  const auto reals = [&](std::initializer_list<double> list) {
    for (const double v : list) put(v);
  };
  put(1);
  out += "\n$EndMeshFormat\n" + names + "$Entities\n";
  sizes({0, 1, 1, 0});
  put(5), reals({0, 0, 0, 1, 0, 0}), sizes({1}), put(3), sizes({0});
  put(1), reals({0, 0, 0, 1, 1, 0}), sizes({1}), put(-7), sizes({1}), put(5);
  out += "\n$EndEntities\n$Nodes\n";
  sizes({1, 4, 10, 40}), ints({2, 1, 0}), sizes({4, 10, 20, 30, 40});
  reals({0, 0, 0, 1, 0, 0, 1, 1, 0, 0, 1, 0});
  out += "\n$EndNodes\n$Elements\n";
  sizes({2, 3, 1, 3}), ints({1, 5, 1}), sizes({1, 1, 10, 20});
  ints({2, 1, 2}), sizes({2, 2, 10, 20, 30, 3, 10, 30, 40});
  out += "\n$EndElements\n";
  return out;
}

void check_square(const powbench::sim::MshMesh& m) {
  REQUIRE(m.nodes.size() == 4);
  CHECK(m.nodes[2] == std::array<double, 3>{1, 1, 0});
  REQUIRE(m.blocks.size() == 2);
  CHECK(m.blocks[0].shape == MshShape::line);
  CHECK(m.blocks[0].groups == std::vector<int>{3});
  CHECK(m.blocks[1].shape == MshShape::triangle);
  CHECK(m.blocks[1].elements() == 2);
  CHECK(m.blocks[1].groups == std::vector<int>{7});
  CHECK(m.blocks[1].nodes == std::vector<int>{0, 1, 2, 0, 2, 3});
  REQUIRE(m.group("iron core", 2));
  CHECK(m.group("iron core", 2)->tag == 7);
  CHECK_FALSE(m.group("iron core", 1));
}

}  // namespace

TEST_CASE("A mesh of gmsh is read from text and from binary data") {
  check_square(read_msh(square));
  check_square(read_msh(binary_square()));
  check_square(read_msh(replaced(square, "$Nodes", "$Periodic\n0\nanything\n$EndPeriodic\n$Nodes")));
}

TEST_CASE("A mesh of version 2.2 is read from text and from binary data") {
  const std::string head = "$MeshFormat\n2.2 0 8\n$EndMeshFormat\n" + names;
  const std::string text =
      head +
      "$Nodes\n4\n10 0 0 0\n20 1 0 0\n30 1 1 0\n40 0 1e0 0\n$EndNodes\n$Elements\n3\n1 1 2 3 5 10 20\n"
      "2 2 2 -7 1 10 20 30\n3 2 3 7 1 0 10 30 40\n$EndElements\n";
  check_square(read_msh(text));
  std::string binary = "$MeshFormat\n2.2 1 8\n";
  const auto put = [&](auto value) {
    char bytes[sizeof value];
    std::memcpy(bytes, &value, sizeof value);
    binary.append(bytes, sizeof value);
  };
  const auto ints = [&](std::initializer_list<int> list) {
    for (const int v : list) put(v);
  };
  put(1);
  binary += "\n$EndMeshFormat\n" + names + "$Nodes\n4\n";
  const double at[4][2] = {{0, 0}, {1, 0}, {1, 1}, {0, 1}};
  for (int k = 0; k < 4; ++k) put(10 * (k + 1)), put(at[k][0]), put(at[k][1]), put(0.0);
  binary += "\n$EndNodes\n$Elements\n3\n";
  ints({1, 1, 2, 1, 3, 5, 10, 20});
  ints({2, 2, 2, 2, 7, 1, 10, 20, 30, 3, 7, 1, 10, 30, 40});
  binary += "\n$EndElements\n";
  check_square(read_msh(binary));
  CHECK(refusal(replaced(text, "3 2 3 7 1 0 10 30 40", "3 2 3 7 1 0 10 30 50")) ==
        "line 20: element 3 names node 50, which does not exist");
  CHECK(refusal(replaced(text, "$Elements\n3", "$Elements\n9")).starts_with("line 21: an element tag"));
  CHECK(refusal(replaced(text, "2 2 2 -7", "2 2 1 -7")) ==
        "line 19: 1 tags of an element, allowed from 2 on");
  CHECK(refusal(replaced(text, "20 1 0 0", "10 1 0 0")) == "line 12: node 10 appears twice");
}

TEST_CASE("Every kind of element is read with its number of nodes") {
  const auto [type, dimension, count] = GENERATE(table<int, int, int>({{15, 0, 1},
                                                                       {8, 1, 3},
                                                                       {9, 2, 6},
                                                                       {3, 2, 4},
                                                                       {16, 2, 8},
                                                                       {10, 2, 9},
                                                                       {4, 3, 4},
                                                                       {11, 3, 10},
                                                                       {5, 3, 8},
                                                                       {17, 3, 20},
                                                                       {12, 3, 27}}));
  std::string text = format + "$Nodes\n1 27 1 27\n3 1 0 27\n";
  for (int k = 1; k <= 27; ++k) text += std::to_string(k) + "\n";
  for (int k = 1; k <= 27; ++k) text += std::to_string(k) + " 0 0\n";
  text +=
      "$EndNodes\n$Elements\n1 1 1 1\n" + std::to_string(dimension) + " 1 " + std::to_string(type) + " 1\n1";
  for (int k = 1; k <= count; ++k) text += " " + std::to_string(k);
  text += "\n$EndElements\n";
  const auto mesh = read_msh(text);
  REQUIRE(mesh.blocks.size() == 1);
  CHECK(mesh.blocks[0].nodes_per_element == count);
  CHECK(mesh.blocks[0].elements() == 1);
  CHECK(mesh.blocks[0].nodes.back() == count - 1);
}

TEST_CASE("What is not a mesh is refused with a sentence that names the line") {
  const auto check = [](const std::string& text, const std::string& sentence) {
    CAPTURE(sentence);
    CHECK(refusal(text) == sentence);
  };
  check("", "line 1: the file is empty; $MeshFormat expected");
  check("solid cube\n", "line 1: $MeshFormat expected, found 'solid'");
  check(replaced(square, "4.1", "3.0"),
        "line 2: format version 2.2 or 4.1 expected, found '3.0' (gmsh writes it with -format msh41)");
  check(replaced(square, "4.1 0 8", "4.1 0 4"), "line 2: numbers of 4 bytes, allowed 8");
  check(replaced(square, "2 7 \"iron core\"", "2 7 iron"),
        "line 6: a name between quotation marks expected, found 'iron'");
  check(replaced(square, "1e0", "1e999"), "line 24: a coordinate expected (a finite number), found '1e999'");
  check(replaced(square, "1e0", "nan"), "line 24: a coordinate expected (a finite number), found 'nan'");
  check(replaced(square, "30\n40\n", "30\n30\n"), "line 20: node 30 appears twice");
  check(replaced(square, "1 4 10 40", "1 5 10 40"), "line 24: 5 nodes announced, 4 given");
  check(replaced(square, "1 4 10 40", "1 4000000000 10 40"),
        "line 15: the number of nodes: 4000000000 announced, more than the rest of the file holds");
  check(replaced(square, "3 10 30 40", "3 10 30 50"),
        "line 32: element 3 names node 50, which does not exist");
  check(replaced(square, "3 10 30 40", "3 10 30 30"), "line 32: element 3 names node 30 twice");
  check(replaced(square, "2 1 2 2", "2 1 6 2"),
        "line 30: element type 6; read are points, lines, triangles, quadrangles, tetrahedra and hexahedra "
        "of order "
        "1 and 2");
  check(replaced(square, "2 1 2 2", "2 9 2 2"), "line 30: entity 9 of dimension 2 is not in $Entities");
  check(replaced(square, "2 1 2 2", "2 1 4 2"), "line 30: element type 4 on an entity of dimension 2");
  check(format + nodes, "line 16: the file has no section $Elements");
  check(format + elements, "line 4: $Elements before $Nodes");
}

TEST_CASE("A mesh cut off anywhere is refused, never read beyond its end") {
  for (const auto& whole : {square, binary_square()})
    for (std::size_t size = 0; size + 2 < whole.size(); ++size) {
      CAPTURE(size);
      const auto sentence = refusal(whole.substr(0, size));
      CHECK((sentence.starts_with("line ") || sentence.starts_with("byte ")));
    }
}
