#include "sim/magnetics/plane/msh.h"

#include <algorithm>
#include <array>
#include <bit>
#include <cstdint>
#include <map>
#include <unordered_map>
#include <utility>

#include "sim/magnetics/plane/msh_scanner.h"

namespace powbench::sim {
namespace {

struct ElementKind {
  int type;  ///< gmsh's number
  MshShape shape;
  int order;
  int nodes;
};

constexpr ElementKind element_kinds[] = {
    {15, MshShape::point, 1, 1},        {1, MshShape::line, 1, 2},        {8, MshShape::line, 2, 3},
    {2, MshShape::triangle, 1, 3},      {9, MshShape::triangle, 2, 6},    {3, MshShape::quadrangle, 1, 4},
    {16, MshShape::quadrangle, 2, 8},   {10, MshShape::quadrangle, 2, 9}, {4, MshShape::tetrahedron, 1, 4},
    {11, MshShape::tetrahedron, 2, 10}, {5, MshShape::hexahedron, 1, 8},  {17, MshShape::hexahedron, 2, 20},
    {12, MshShape::hexahedron, 2, 27},
};

/// What the sections give, while they are read.
struct Reader {
  explicit Reader(std::string_view content) : scan(content) {}

  MshScanner scan;
  MshMesh mesh;
  std::map<std::pair<int, int>, std::vector<int>> groups_of;  ///< (dimension, entity) -> physical tags
  std::unordered_map<std::int64_t, int> index_of;             ///< node tag -> index
  bool has_entities = false;
  bool version2 = false;

  void format();
  void names();
  void entities();
  void nodes();
  void elements();
  void element_block(std::int64_t& left);
  void nodes2();
  void elements2();
  const ElementKind& kind_of(int type) const;
  void take_nodes(MshBlock& block, std::int64_t tag, bool wide);
  void add_group(int dimension, int tag, const std::string& name);
};

void Reader::add_group(int dimension, int tag, const std::string& name) {
  for (auto& g : mesh.groups)
    if (g.dimension == dimension && g.tag == tag) {
      if (!name.empty()) g.name = name;
      return;
    }
  mesh.groups.push_back({dimension, tag, name});
}

void Reader::format() {
  if (scan.at_end()) scan.fail("the file is empty; $MeshFormat expected");
  scan.expect("$MeshFormat");
  const auto version = scan.word();
  version2 = version == "2.2";
  if (version != "4.1" && !version2)
    scan.fail("format version 2.2 or 4.1 expected, found '" + std::string(version.substr(0, 24)) +
              "' (gmsh writes it with -format msh41)");
  const int binary = scan.integer("the file type");
  if (binary != 0 && binary != 1)
    scan.fail("file type " + std::to_string(binary) + ", allowed 0 (text), 1 (binary)");
  const int bytes = scan.integer("the size of a number");
  if (bytes != 8) scan.fail("numbers of " + std::to_string(bytes) + " bytes, allowed 8");
  if (binary == 1) {
    static_assert(std::endian::native == std::endian::little);
    scan.set_binary(true);
    scan.begin_data();
    if (scan.integer("the mark of the byte order") != 1)
      scan.fail("the bytes are in big-endian order, which is not read");
    scan.set_binary(false);
    scan.expect("$EndMeshFormat");
    scan.set_binary(true);
  } else {
    scan.expect("$EndMeshFormat");
  }
}

void Reader::names() {
  const bool binary = scan.binary();
  scan.set_binary(false);  // names are text in both forms
  const auto count = scan.count("the number of physical names", 5);
  for (std::int64_t k = 0; k < count; ++k) {
    const int dimension = scan.integer("the dimension of a physical group");
    if (dimension < 0 || dimension > 3)
      scan.fail("dimension " + std::to_string(dimension) + " of a physical group, allowed 0 .. 3");
    const int tag = scan.integer("the tag of a physical group");
    add_group(dimension, tag, std::string(scan.quoted()));
  }
  scan.set_binary(binary);
}

void Reader::entities() {
  scan.begin_data();
  has_entities = true;
  std::int64_t counts[4];
  for (auto& c : counts) c = scan.count("the number of entities", 6);
  for (int dimension = 0; dimension < 4; ++dimension)
    for (std::int64_t k = 0; k < counts[dimension]; ++k) {
      const int tag = scan.integer("the tag of an entity");
      for (int c = 0; c < (dimension == 0 ? 3 : 6); ++c) scan.real("the extent of an entity");
      auto& groups = groups_of[{dimension, tag}];
      const auto physical = scan.count("the number of physical tags", 2);
      for (std::int64_t p = 0; p < physical; ++p) {
        const int group = std::abs(scan.integer("a physical tag"));  // the sign is an orientation
        groups.push_back(group);
        add_group(dimension, group, "");
      }
      if (dimension == 0) continue;
      const auto bounding = scan.count("the number of bounding entities", 2);
      for (std::int64_t b = 0; b < bounding; ++b) scan.integer("the tag of a bounding entity");
    }
}

void Reader::nodes() {
  scan.begin_data();
  if (!mesh.nodes.empty()) scan.fail("a second section $Nodes");
  const auto blocks = scan.count("the number of node blocks", 8);
  const auto announced = scan.count("the number of nodes", 6);
  scan.size("the lowest node tag");
  scan.size("the highest node tag");
  mesh.nodes.reserve(static_cast<std::size_t>(announced));
  for (std::int64_t b = 0; b < blocks; ++b) {
    const int dimension = scan.integer("the dimension of an entity");
    if (dimension < 0 || dimension > 3)
      scan.fail("dimension " + std::to_string(dimension) + ", allowed 0 .. 3");
    scan.integer("the tag of an entity");
    const int parametric = scan.integer("the mark of parametric nodes");
    const auto here = scan.count("the number of nodes in a block", 6);
    const std::size_t first = mesh.nodes.size();
    if (static_cast<std::int64_t>(first) + here > announced)
      scan.fail("more nodes than the " + std::to_string(announced) + " announced");
    for (std::int64_t k = 0; k < here; ++k) {
      const auto tag = scan.size("a node tag");
      if (!index_of.emplace(tag, static_cast<int>(first + static_cast<std::size_t>(k))).second)
        scan.fail("node " + std::to_string(tag) + " appears twice");
    }
    for (std::int64_t k = 0; k < here; ++k) {
      auto& node = mesh.nodes.emplace_back();
      for (double& x : node) x = scan.real("a coordinate");
      for (int p = 0; parametric != 0 && p < dimension; ++p) scan.real("a parametric coordinate");
    }
  }
  if (static_cast<std::int64_t>(mesh.nodes.size()) != announced)
    scan.fail(std::to_string(announced) + " nodes announced, " + std::to_string(mesh.nodes.size()) +
              " given");
}

const ElementKind& Reader::kind_of(int type) const {
  const auto* kind = std::find_if(std::begin(element_kinds), std::end(element_kinds),
                                  [&](const ElementKind& k) { return k.type == type; });
  if (kind == std::end(element_kinds))
    scan.fail("element type " + std::to_string(type) +
              "; read are points, lines, triangles, quadrangles, tetrahedra and hexahedra of order 1 and 2");
  return *kind;
}

/// The nodes of one element; `wide`: tags of 8 bytes in binary data.
void Reader::take_nodes(MshBlock& block, std::int64_t tag, bool wide) {
  const auto first = block.nodes.end() - block.nodes.begin();
  for (int k = 0; k < block.nodes_per_element; ++k) {
    const std::int64_t node = wide ? scan.size("a node tag") : scan.integer("a node tag");
    const auto found = index_of.find(node);
    if (found == index_of.end())
      scan.fail("element " + std::to_string(tag) + " names node " + std::to_string(node) +
                ", which does not exist");
    if (std::find(block.nodes.begin() + first, block.nodes.end(), found->second) != block.nodes.end())
      scan.fail("element " + std::to_string(tag) + " names node " + std::to_string(node) + " twice");
    block.nodes.push_back(found->second);
  }
}

void Reader::element_block(std::int64_t& left) {
  const int dimension = scan.integer("the dimension of an entity");
  const int entity = scan.integer("the tag of an entity");
  const int type = scan.integer("an element type");
  const auto* kind = &kind_of(type);
  if (msh_dimension(kind->shape) != dimension)
    scan.fail("element type " + std::to_string(type) + " on an entity of dimension " +
              std::to_string(dimension));
  MshBlock block{kind->shape, kind->order, entity, {}, kind->nodes, {}};
  if (has_entities) {
    const auto found = groups_of.find({dimension, entity});
    if (found == groups_of.end())
      scan.fail("entity " + std::to_string(entity) + " of dimension " + std::to_string(dimension) +
                " is not in $Entities");
    block.groups = found->second;
  }
  const auto here = scan.count("the number of elements in a block", 2 * kind->nodes);
  if (here > left) scan.fail("more elements than announced");
  left -= here;
  block.nodes.reserve(static_cast<std::size_t>(here * kind->nodes));
  for (std::int64_t e = 0; e < here; ++e) {
    const auto tag = scan.size("an element tag");
    take_nodes(block, tag, true);
  }
  if (here > 0) mesh.blocks.push_back(std::move(block));
}

void Reader::elements() {
  if (mesh.nodes.empty()) scan.fail("$Elements before $Nodes");
  scan.begin_data();
  const auto blocks = scan.count("the number of element blocks", 8);
  auto left = scan.count("the number of elements", 4);
  scan.size("the lowest element tag");
  scan.size("the highest element tag");
  for (std::int64_t b = 0; b < blocks; ++b) element_block(left);
  if (left != 0) scan.fail(std::to_string(left) + " elements fewer than announced");
}

/// Version 2.2: the count is text in both forms, a node is its tag and three coordinates.
void Reader::nodes2() {
  const bool binary = scan.binary();
  scan.set_binary(false);
  if (!mesh.nodes.empty()) scan.fail("a second section $Nodes");
  const auto announced = scan.count("the number of nodes", 7);
  scan.set_binary(binary);
  scan.begin_data();
  mesh.nodes.reserve(static_cast<std::size_t>(announced));
  for (std::int64_t k = 0; k < announced; ++k) {
    const int tag = scan.integer("a node tag");
    if (!index_of.emplace(tag, static_cast<int>(k)).second)
      scan.fail("node " + std::to_string(tag) + " appears twice");
    auto& node = mesh.nodes.emplace_back();
    for (double& x : node) x = scan.real("a coordinate");
  }
}

/// Version 2.2: an element names its physical group and its entity itself; in binary data runs of one type have a head.
void Reader::elements2() {
  const bool binary = scan.binary();
  if (mesh.nodes.empty()) scan.fail("$Elements before $Nodes");
  scan.set_binary(false);
  auto left = scan.count("the number of elements", 5);
  scan.set_binary(binary);
  scan.begin_data();
  std::map<std::array<int, 3>, std::size_t> block_of;  // type, entity, physical group
  for (int type = 0, run = 0, tags = 0; left > 0; --left, --run) {
    int element = 0;
    if (binary && run == 0) {
      type = scan.integer("an element type");
      run = scan.integer("the number of elements of a type");
      tags = scan.integer("the number of tags");
      if (run < 1 || run > left) scan.fail("more elements than announced");
    }
    element = scan.integer("an element tag");
    if (!binary) {
      type = scan.integer("an element type");
      tags = scan.integer("the number of tags");
    }
    const ElementKind& kind = kind_of(type);
    if (tags < 2 || tags > 1000) scan.fail(std::to_string(tags) + " tags of an element, allowed from 2 on");
    const int group = std::abs(scan.integer("a physical tag"));
    const int entity = scan.integer("the tag of an entity");
    for (int k = 2; k < tags; ++k) scan.integer("a tag");
    const auto [at, added] = block_of.try_emplace({type, entity, group}, mesh.blocks.size());
    if (added) {
      mesh.blocks.push_back({kind.shape, kind.order, entity, {}, kind.nodes, {}});
      if (group != 0) {
        mesh.blocks.back().groups = {group};
        add_group(msh_dimension(kind.shape), group, "");
      }
    }
    take_nodes(mesh.blocks[at->second], element, false);
  }
}

}  // namespace

int msh_dimension(MshShape shape) {
  constexpr int dimensions[] = {0, 1, 2, 2, 3, 3};
  return dimensions[static_cast<int>(shape)];
}

const MshGroup* MshMesh::group(std::string_view name, int dimension) const {
  for (const auto& g : groups)
    if (g.dimension == dimension && g.name == name) return &g;
  return nullptr;
}

MshMesh read_msh(std::string_view content) {
  Reader reader(content);
  reader.format();
  auto& scan = reader.scan;
  const bool binary = scan.binary();
  bool any_elements = false;
  while (!scan.at_end()) {
    scan.set_binary(false);
    const std::string name(scan.word());
    if (name.size() < 2 || name[0] != '$')
      scan.fail("a section ($...) expected, found '" + name.substr(0, 24) + "'");
    scan.set_binary(binary);
    const std::string end = "$End" + name.substr(1);
    if (name == "$PhysicalNames")
      reader.names();
    else if (name == "$Entities")
      reader.entities();
    else if (name == "$Nodes")
      reader.version2 ? reader.nodes2() : reader.nodes();
    else if (name == "$Elements")
      reader.version2 ? reader.elements2() : reader.elements(), any_elements = true;
    else {
      scan.set_binary(false);
      scan.skip_past(end);
      continue;
    }
    scan.set_binary(false);
    scan.expect(end);
  }
  if (reader.mesh.nodes.empty()) scan.fail("the file has no section $Nodes");
  if (!any_elements) scan.fail("the file has no section $Elements");
  return std::move(reader.mesh);
}

}  // namespace powbench::sim
