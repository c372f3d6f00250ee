#include "host/config/space_file.h"

#include <fmt/format.h>
#include <fmt/ranges.h>

#include <algorithm>
#include <array>
#include <cmath>
#include <map>

#include "host/config/drawing_parts.h"
#include "sim/magnetics/space/import.h"

namespace powbench::host {
namespace {

namespace fs = std::filesystem;
using sim::DrawnRole;
using sim::Vec3;

const std::vector<std::string> openings{"+x", "-x", "+y", "-y", "+z", "-z"};
const std::vector<std::string> mirrors{"none", "x", "y", "z", "xy", "xz", "yz"};
const std::vector<std::string> axis_words{"x", "y", "z"};
const std::vector<std::string> sheet_words{"none", "x", "y", "z"};

/// One physical volume with what the file says about it.
struct SpaceGroup {
  std::string name;
  int tag = 0;
  DrawnRole role = DrawnRole::air;
  std::string steel;
  double turns = 0, width = 0, corner = 0;
  int axis = 2;
  std::string section() const { return "group." + name; }
};

struct SpaceDraft {
  DrawingDraft plain;  ///< what it has in common with the plane
  int opening = 4, mirror = 0, sheets = 0;
  std::vector<SpaceGroup> groups;
};

/// A word of a list, by its number.
Field& word(FileKind& kind, const char* key, int& target, const std::vector<std::string>& words,
            const char* meaning) {
  return kind.choice(key, target, words, meaning);
}

FileKind space_keys(SpaceDraft& s) {
  auto& d = s.plain;
  FileKind kind = mesh_key(d);
  kind.choice("unit", d.unit, drawn_units, "of the mesh's coordinates");
  kind.choice("kind", d.kind, {"plane", "axisymmetric", "space"}, "space: a mesh of tetrahedra");
  word(kind, "opening", s.opening, openings, "where the armature goes when it opens");
  word(kind, "mirror", s.mirror, mirrors,
       "planes through 0 at which the device is mirrored, by their normals");
  word(kind, "sheets", s.sheets, sheet_words, "normal of the sheets of all iron; none: solid");
  kind.number("stack_factor", d.stack_factor, {0.5, 1}, "share of iron in the sheets");
  motion_keys(kind, d);
  for (auto& g : s.groups) {
    kind.section(g.section(), "a physical volume of the mesh");
    kind.choice("role", g.role, drawn_roles, "what the volume is");
    kind.text("steel", g.steel,
              "of fixed, armature, and stretch in a closed leg: built-in name or B-H sheet");
    kind.number("turns", g.turns, {-1e6, 1e6},
                "of coil and ring; above 0: counter-clockwise, seen along -axis");
    word(kind, "axis", g.axis, axis_words, "of coil and ring: the direction of its axis");
    kind.number("width_mm", g.width, {0.01, 1000},
                "of coil and ring: thickness of the winding across its axis");
    kind.number("corner_mm", g.corner, {0, 1000}, "of coil and ring: radius of its corners inside");
  }
  return kind;
}

/// Turns the mesh so that the armature opens towards +z: new coordinate i is sign[i] times the old number from[i].
struct Turn {
  std::array<std::size_t, 3> from;
  std::array<double, 3> sign;

  explicit Turn(int opening) {
    constexpr std::array<std::array<std::size_t, 3>, 6> places{
        {{1, 2, 0}, {1, 2, 0}, {2, 0, 1}, {2, 0, 1}, {0, 1, 2}, {0, 1, 2}}};
    from = places[static_cast<std::size_t>(opening)];
    sign = {1, 1, 1};
    if (opening % 2 == 1) sign = {1, -1, -1};  // still no mirror image
  }
  Vec3 operator()(const Vec3& p) const {
    return {sign[0] * p[from[0]], sign[1] * p[from[1]], sign[2] * p[from[2]]};
  }
  /// The old place of a new one.
  Vec3 back(const Vec3& p) const {
    Vec3 old{};
    for (std::size_t k = 0; k < 3; ++k) old[from[k]] = sign[k] * p[k];
    return old;
  }
  /// Where an old axis has gone.
  std::size_t axis(std::size_t old) const {
    return static_cast<std::size_t>(std::ranges::find(from, old) - from.begin());
  }
};

/// Checks that go across keys, and the drawing that comes of them.
class SpaceAssembly {
 public:
  SpaceAssembly(FileReader& reader, const SpaceDraft& draft, const fs::path& folder, const sim::MshMesh& msh)
      : reader_(reader),
        s_(draft),
        d_(draft.plain),
        msh_(msh),
        turn_(draft.opening),
        steels_(reader, folder) {}

  std::shared_ptr<const sim::SpaceMagnet> run(const std::string& name) {
    out_->name = name;
    out_->stack_factor = d_.stack_factor;
    out_->drawn_gap = d_.drawn_gap;
    out_->residual_gap = d_.residual_gap;
    out_->travel = d_.travel;
    out_->ring_resistance = d_.ring_resistance;
    out_->largest_flux = d_.largest_flux;
    if (s_.sheets > 0) out_->sheets = static_cast<int>(turn_.axis(static_cast<std::size_t>(s_.sheets - 1)));
    if (s_.sheets == 0 && reader_.good("", "stack_factor"))
      reader_.fail("", "stack_factor", "is of sheets: state their normal, sheets = \"y\"");
    for (const auto& g : s_.groups) add_part(g);
    check_roles();
    reader_.finish();
    import();
    check_mirrors();
    reader_.finish();
    check_size();
    for (std::size_t k = 0; k < s_.groups.size(); ++k) place_winding(k);
    reader_.finish();
    check_filled();
    reader_.finish();
    move();
    reader_.finish();
    return out_;
  }

 private:
  static bool wound(DrawnRole role) { return role == DrawnRole::coil || role == DrawnRole::ring; }

  void add_part(const SpaceGroup& g) {
    const auto section = g.section();
    sim::SpacePart part{g.name, g.role, -1, {}};
    region_[g.tag] = static_cast<int>(out_->parts.size());
    const bool iron = g.role == DrawnRole::fixed || g.role == DrawnRole::armature;
    const bool named = reader_.good(section, "steel");
    if (!iron && g.role != DrawnRole::stretch && named)
      reader_.fail(section, "steel", "belongs to iron: role = \"fixed\", \"armature\" or \"stretch\"");
    else if (iron || named)
      part.steel = steels_.index(section, g.steel, 1.0, out_->steels);
    for (const char* key : {"turns", "axis", "width_mm", "corner_mm"})
      if (!wound(g.role) && reader_.good(section, key))
        reader_.fail(section, key, "belongs to role = \"coil\" or \"ring\"");
    if (wound(g.role)) check_winding(g);
    out_->parts.push_back(part);
  }

  void check_winding(const SpaceGroup& g) {
    const auto section = g.section();
    if (!reader_.bad(section, "turns")) {
      if (g.turns == 0)
        reader_.fail(section, "turns", reader_.good(section, "turns") ? "carry no current" : "is missing",
                     g.role == DrawnRole::coil ? "1..1e6, below 0 the other way round" : "1 or -1");
      else if (g.role == DrawnRole::ring && std::fabs(g.turns) != 1)
        reader_.fail(section, "turns", "a ring is one turn", "1 or -1");
    }
    if (g.width == 0 && !reader_.bad(section, "width_mm"))
      reader_.fail(section, "width_mm", "is missing: how thick the winding is across its axis",
                   "0.01..1000 mm");
    if (s_.mirror > 0 && mirrored(static_cast<std::size_t>(g.axis)))
      reader_.fail(section, "axis", "stands on a plane of symmetry, through which no flux goes");
  }

  /// Whether the device is mirrored at the plane across an axis of the mesh.
  bool mirrored(std::size_t axis) const {
    return s_.mirror > 0 &&
           mirrors[static_cast<std::size_t>(s_.mirror)].find("xyz"[axis]) != std::string::npos;
  }

  void check_roles() {
    const auto has = [&](DrawnRole role) {
      return std::ranges::count(out_->parts, role, &sim::SpacePart::role) > 0;
    };
    const bool open = std::ranges::any_of(
        s_.groups, [&](const SpaceGroup& g) { return !reader_.good(g.section(), "role"); });
    if (!has(DrawnRole::coil) && !open)
      reader_.fail("", "mesh", "no group has the role coil: nothing drives the field");
    if (!has(DrawnRole::ring) && reader_.good("", "ring_resistance_ohm"))
      reader_.fail("", "ring_resistance_ohm", "no group has the role ring");
    if (mirrored(static_cast<std::size_t>(s_.opening / 2)))
      reader_.fail("", "mirror", "the armature moves across a plane of symmetry", "planes along the opening");
  }

  void import() {
    try {
      auto mesh = sim::space::import_mesh(msh_, drawn_metres[static_cast<int>(d_.unit)], region_);
      if (mesh.cell != sim::space::Cell::tet4 && mesh.cell != sim::space::Cell::tet10)
        throw std::invalid_argument("the mesh is of hexahedra, allowed tetrahedra of order 1 or 2");
      for (auto& n : mesh.nodes) n = turn_(n);
      out_->mesh = sim::space::straight_tetrahedra(mesh);
    } catch (const std::invalid_argument& error) {
      reader_.fail("", "mesh", error.what());
      reader_.finish();
    }
    for (const auto& n : out_->mesh.nodes)
      for (std::size_t k = 0; k < 3; ++k) {
        low_[k] = std::min(low_[k], n[k]);
        high_[k] = std::max(high_[k], n[k]);
      }
    extent_ = std::max({high_.x - low_.x, high_.y - low_.y, high_.z - low_.z});
  }

  void check_mirrors() {
    for (std::size_t old = 0; old < 3; ++old) {
      if (!mirrored(old)) continue;
      out_->copies *= 2;
      const auto k = turn_.axis(old);
      const double little = 1e-6 * extent_;
      if (std::fabs(low_[k]) > little && std::fabs(high_[k]) > little)
        reader_.fail(
            "", "mirror",
            fmt::format("the mesh goes from {0} = {1:.4g} to {2:.4g} mm, so that {0} = 0 is no end of it",
                        axis_words[old], turn_.sign[k] * low_[k] * 1e3, turn_.sign[k] * high_[k] * 1e3));
    }
  }

  void check_size() { check_drawn_size(reader_, d_.unit, extent_, sim::measured_gap(*out_), d_.drawn_gap); }

  /// T from the box around the group, its mirror images counted where it ends at their plane.
  void place_winding(std::size_t number) {
    const auto& g = s_.groups[number];
    if (!wound(g.role)) return;
    Vec3 low{1e300, 1e300, 1e300}, high = -1.0 * low;
    const auto& mesh = out_->mesh;
    for (std::size_t c = 0; c < mesh.region.size(); ++c) {
      if (mesh.region[c] != static_cast<int>(number)) continue;
      for (std::size_t n = 0; n < 4; ++n)
        for (std::size_t k = 0; k < 3; ++k) {
          const double x = mesh.nodes[static_cast<std::size_t>(mesh.cells[10 * c + n])][k];
          low[k] = std::min(low[k], x);
          high[k] = std::max(high[k], x);
        }
    }
    if (!(high.x > low.x)) {
      reader_.fail(g.section(), "role", "the group has no tetrahedron in the mesh: it has no volume");
      return;
    }
    for (std::size_t old = 0; old < 3; ++old) {
      const auto k = turn_.axis(old);
      if (!mirrored(old)) continue;
      if (std::min(std::fabs(low[k]), std::fabs(high[k])) > 1e-6 * extent_) {
        out_->parts[number].images *= 2;
        continue;
      }
      high[k] = std::max(std::fabs(low[k]), std::fabs(high[k]));
      low[k] = -high[k];
    }
    const auto a = turn_.axis(static_cast<std::size_t>(g.axis)), b = (a + 1) % 3, c = (a + 2) % 3;
    sim::space::BoxCoil coil;
    coil.axis = static_cast<int>(a);
    coil.x = 0.5 * (low[b] + high[b]);
    coil.y = 0.5 * (low[c] + high[c]);
    coil.half_x = 0.5 * (high[b] - low[b]) - g.width;
    coil.half_y = 0.5 * (high[c] - low[c]) - g.width;
    coil.width = g.width;
    coil.radius = g.corner;
    coil.low = low[a];
    coil.high = high[a];
    coil.turns = turn_.sign[a] * g.turns;
    const double most = std::min(coil.half_x, coil.half_y);
    if (!(most > 0))
      reader_.fail(g.section(), "width_mm", "leaves no opening in the group's box",
                   fmt::format("0.01..{:.4g} mm", (most + g.width) * 1e3));
    else if (g.corner > most)
      reader_.fail(g.section(), "corner_mm", "does not fit into the opening",
                   fmt::format("0..{:.4g} mm", most * 1e3));
    out_->parts[number].coil = coil;
  }

  void check_filled() {
    const auto hole = sim::unmeshed_place(*out_);
    if (!hole) return;
    const Vec3 at = 1e3 * turn_.back(hole->at);
    reader_.fail("", "mesh",
                 fmt::format("nothing is meshed {} x = {:.4g}, y = {:.4g}, z = {:.4g} mm: is a part without "
                             "Physical Volume?",
                             hole->where, at.x, at.y, at.z));
  }

  void move() {
    try {
      out_->motion = sim::space_motion(*out_);
    } catch (const std::invalid_argument& error) {
      reader_.fail("", "mesh", error.what());
      return;
    }
    const auto [from, to] = sim::usable_gaps(*out_);
    check_drawn_reach(reader_, from, to, d_.residual_gap, d_.travel);
    for (std::size_t k = 0; k < s_.groups.size(); ++k) {
      if (!wound(s_.groups[k].role)) continue;
      if (const auto error = sim::winding_error(*out_, k); !error.empty())
        reader_.fail(s_.groups[k].section(), "role", error);
    }
  }

  FileReader& reader_;
  const SpaceDraft& s_;
  const DrawingDraft& d_;
  const sim::MshMesh& msh_;
  Turn turn_;
  std::shared_ptr<sim::SpaceMagnet> out_ = std::make_shared<sim::SpaceMagnet>();
  std::map<int, int> region_;
  DrawnSteels steels_;
  Vec3 low_{1e300, 1e300, 1e300}, high_{-1e300, -1e300, -1e300};
  double extent_ = 0;
};

}  // namespace

bool is_space_drawing(const fs::path& path) {
  FileReader reader = FileReader::open(path);
  DrawingDraft draft;
  FileKind kind("drawing", "a magnet on a mesh");
  kind.choice("kind", draft.kind, {"plane", "axisymmetric", "space"}, "");
  reader.read(kind);
  return reader.good("", "kind") && draft.kind == DrawnKind::space;
}

std::shared_ptr<const sim::SpaceMagnet> read_space_drawing(const fs::path& path) {
  FileReader reader = FileReader::open(path);
  SpaceDraft draft;
  FileReader first = reader;  // what else stands there can be judged only with the groups of the mesh
  first.read(mesh_key(draft.plain));
  sim::MshMesh msh;
  if (first.good("", "mesh")) {
    msh = mesh_of_drawing(path, draft.plain.mesh);
    for (const auto& g : msh.groups)
      if (g.dimension == 3) {
        SpaceGroup& group = draft.groups.emplace_back();
        group.name = g.name.empty() ? std::to_string(g.tag) : g.name;
        group.tag = g.tag;
      }
  }
  reader.read(space_keys(draft));
  if (!first.good("", "mesh")) reader.finish();
  if (draft.groups.empty())
    reader.fail("", "mesh", "has no physical volume: kind = \"space\" needs tetrahedra");
  for (const auto& g : draft.groups)
    if (!reader.good(g.section(), "role") && !reader.bad(g.section(), "role"))
      reader.fail(g.section(), "role", "is missing: the mesh has this volume",
                  fmt::format("{}", fmt::join(drawn_roles, ", ")));
  std::string name = path.filename().string();
  if (const std::string_view end = ".magnet.toml"; name.ends_with(end)) name.resize(name.size() - end.size());
  return SpaceAssembly(reader, draft, path.parent_path(), msh).run(name);
}

}  // namespace powbench::host
