#include "host/config/drawing_file.h"

#include <fmt/format.h>
#include <fmt/ranges.h>

#include <algorithm>
#include <cmath>
#include <map>
#include <optional>

#include "core/units.h"
#include "host/config/drawing_parts.h"
#include "host/config/file_reader.h"
#include "sim/magnetics/plane/import_mesh.h"

namespace powbench::host {
namespace {

namespace fs = std::filesystem;

/// The named groups of surfaces and lines; those without a name go by their number.
std::vector<DrawnGroup> groups_of(const sim::MshMesh& msh) {
  std::vector<DrawnGroup> out;
  for (const auto& g : msh.groups) {
    if (g.dimension != 1 && g.dimension != 2) continue;
    DrawnGroup group;
    group.name = g.name.empty() ? std::to_string(g.tag) : g.name;
    group.dimension = g.dimension;
    group.tag = g.tag;
    for (const auto& b : msh.blocks)
      if (sim::msh_dimension(b.shape) == g.dimension && std::ranges::find(b.groups, g.tag) != b.groups.end())
        group.filled = true;
    out.push_back(group);
  }
  return out;
}

/// Checks that go across keys, and the drawing that comes of them.
class Assembly {
 public:
  Assembly(FileReader& reader, const DrawingDraft& draft, const fs::path& folder, const sim::MshMesh& msh)
      : reader_(reader), d_(draft), msh_(msh), steels_(reader, folder) {}

  std::shared_ptr<const sim::DrawnMagnet> run(const std::string& name) {
    out_->name = name;
    out_->axisymmetric = d_.kind == DrawnKind::axisymmetric;
    out_->depth = d_.depth;
    out_->copies = d_.symmetry == DrawnSymmetry::whole ? 1 : d_.symmetry == DrawnSymmetry::half ? 2 : 4;
    out_->drawn_gap = d_.drawn_gap;
    out_->residual_gap = d_.residual_gap;
    out_->travel = d_.travel;
    out_->ring_resistance = d_.ring_resistance;
    out_->largest_flux = d_.largest_flux;
    check_kind();
    for (const auto& g : d_.groups)
      if (g.dimension == 2) add_part(g);
    check_windings();
    if (zero_.empty()) find_zero();
    reader_.finish();
    import();
    check_size();
    reader_.finish();
    move();
    reader_.finish();
    return out_;
  }

 private:
  void check_kind() {
    if (out_->axisymmetric) {
      for (const char* key : {"depth_mm", "stack_factor"})
        if (reader_.good("", key)) reader_.fail("", key, "is of a stack: leave it out around an axis");
      if (d_.symmetry != DrawnSymmetry::whole)
        reader_.fail("", "symmetry", "around an axis all is drawn", "whole");
      if (d_.opening != DrawnOpening::up && d_.opening != DrawnOpening::down)
        reader_.fail("", "opening", "is across the axis", "+y, -y");
    } else if (!reader_.good("", "depth_mm") && !reader_.bad("", "depth_mm")) {
      reader_.fail("", "depth_mm", "is missing: a plane magnet has a depth", "0.1..1000 mm");
    }
  }

  void add_part(const DrawnGroup& g) {
    using sim::DrawnRole;
    const auto section = g.section();
    if (!reader_.good(section, "role")) return;
    if (g.role == DrawnRole::fixed && d_.symmetry == DrawnSymmetry::quarter)
      reader_.fail(section, "role", "in a quarter the fixed iron is the image of the armature",
                   "armature, coil, ring, air, stretch");
    if (!g.filled) reader_.fail(section, "role", "the group has no triangle in the mesh: it has no area");
    sim::DrawnPart part{g.name, g.role, -1, 0};
    const bool iron = g.role == DrawnRole::fixed || g.role == DrawnRole::armature;
    const bool wound = g.role == DrawnRole::coil || g.role == DrawnRole::ring;
    if (!iron && reader_.good(section, "steel"))
      reader_.fail(section, "steel", "belongs to iron: role = \"fixed\" or \"armature\"");
    if (!wound && reader_.good(section, "turns"))
      reader_.fail(section, "turns", "belongs to role = \"coil\" or \"ring\"");
    if (iron)
      part.steel = steels_.index(section, g.steel, out_->axisymmetric ? 1.0 : d_.stack_factor, out_->steels);
    if (wound && !reader_.bad(section, "turns")) {
      part.turns = g.turns;
      if (g.turns == 0)
        reader_.fail(section, "turns", reader_.good(section, "turns") ? "carry no current" : "is missing",
                     g.role == DrawnRole::coil ? "1..1e6, below 0 into the plane" : "1 or -1");
      else if (g.role == DrawnRole::ring && std::fabs(g.turns) != 1)
        reader_.fail(section, "turns", "a ring is one turn", "1 or -1");
    }
    region_[g.tag] = static_cast<int>(out_->parts.size());
    out_->parts.push_back(part);
  }

  const sim::DrawnPart* first_of(sim::DrawnRole role) const {
    const auto found = std::ranges::find(out_->parts, role, &sim::DrawnPart::role);
    return found == out_->parts.end() ? nullptr : &*found;
  }

  void check_windings() {
    if (first_of(sim::DrawnRole::coil) == nullptr) {
      const bool open = std::ranges::any_of(d_.groups, [&](const DrawnGroup& g) {
        return g.dimension == 2 && !reader_.good(g.section(), "role");
      });
      if (!open) reader_.fail("", "mesh", "no group has the role coil: nothing drives the field");
      return;
    }
    if (first_of(sim::DrawnRole::ring) == nullptr && reader_.good("", "ring_resistance_ohm"))
      reader_.fail("", "ring_resistance_ohm", "no group has the role ring");
    if (out_->axisymmetric || d_.symmetry != DrawnSymmetry::whole) return;
    for (const auto role : {sim::DrawnRole::coil, sim::DrawnRole::ring}) {
      double sum = 0, most = 0;
      for (const auto& p : out_->parts) {
        if (p.role != role) continue;
        sum += p.turns;
        most = std::max(most, std::fabs(p.turns));
      }
      if (most > 0 && std::fabs(sum) > 1e-9 * most)
        reader_.fail(
            "group." + first_of(role)->name, "turns",
            fmt::format(
                "the turns of all groups with this role leave {:g} over: what goes out of the plane has to "
                "come back into it, or symmetry is half",
                sum));
    }
  }

  void find_zero() {
    std::vector<std::string> lines;
    for (const auto& g : d_.groups) {
      if (g.dimension != 1) continue;
      lines.push_back(g.name);
      if (g.line == DrawnLine::zero && g.filled) zero_.push_back(g.tag);
    }
    if (zero_.empty())
      reader_.fail("", "mesh",
                   lines.empty()
                       ? std::string("has no physical line: the outer edge needs one, with role = \"A=0\"")
                       : fmt::format("no line has the role A=0, and the outer edge needs it; lines: {}",
                                     fmt::join(lines, ", ")));
  }

  void import() {
    try {
      out_->mesh = sim::import_plane_mesh(msh_, drawn_metres[static_cast<int>(d_.unit)], region_, zero_);
    } catch (const std::invalid_argument& error) {
      reader_.fail("", "mesh", error.what());
      reader_.finish();
    }
    if (const auto hole = sim::unmeshed_place(out_->mesh))
      reader_.fail(
          "", "mesh",
          fmt::format("nothing is meshed around x = {:.4g}, y = {:.4g} mm: is a part without Physical "
                      "Surface?",
                      hole->first * 1e3, hole->second * 1e3));
    reader_.finish();
    turn();
    if (out_->axisymmetric) find_axis();
    reader_.finish();
    check_edges();
  }

  void check_edges() {
    if (const auto open = sim::open_edge(out_->mesh, out_->copies == 4)) {
      const auto [x, y] = drawn(open->first, open->second);
      reader_.fail("", "mesh",
                   fmt::format("the outer edge at x = {:.4g}, y = {:.4g} mm belongs to no line with role = "
                               "\"A=0\": flux would leave the drawing there",
                               x * 1e3, y * 1e3));
    }
    constexpr double least = 0.1 * pi / 180;
    const auto sharp = sim::sharpest_triangle(*out_);
    if (sharp.angle >= least) return;
    const auto [x, y] = drawn(sharp.x, sharp.y);
    reader_.fail(
        "group." + out_->parts[static_cast<std::size_t>(sharp.part)].name, "role",
        fmt::format("a triangle at x = {:.4g}, y = {:.4g} mm has an angle of {:.2g} deg: is the part "
                    "drawn too thin, or the mesh there far too long?",
                    x * 1e3, y * 1e3, sharp.angle * 180 / pi),
        "0.1 deg and above");
  }

  void find_axis() {
    auto& m = out_->mesh;
    const double reach = *std::max_element(m.x.begin(), m.x.end());
    for (std::size_t v = 0; v < m.x.size(); ++v) {
      if (m.x[v] < -1e-9 * reach) {
        reader_.fail("", "kind", fmt::format("a vertex has the radius {:g} mm", m.x[v] * 1e3),
                     "x of 0 and above");
        break;
      }
      if (m.x[v] <= 1e-9 * reach) m.x[v] = 0, m.zero[v] = 1;
    }
  }

  /// A place of the turned mesh as it was drawn.
  std::pair<double, double> drawn(double x, double y) const {
    if (d_.opening == DrawnOpening::down) return {out_->axisymmetric ? x : -x, -y};
    if (d_.opening == DrawnOpening::right) return {y, -x};
    if (d_.opening == DrawnOpening::left) return {-y, x};
    return {x, y};
  }

  /// The mesh turned, or around an axis mirrored, so that the armature opens towards +y.
  void turn() {
    auto& m = out_->mesh;
    for (std::size_t v = 0; v < m.x.size(); ++v) {
      const double x = m.x[v], y = m.y[v];
      if (d_.opening == DrawnOpening::down) {
        m.x[v] = out_->axisymmetric ? x : -x;
        m.y[v] = -y;
      } else if (d_.opening == DrawnOpening::right || d_.opening == DrawnOpening::left) {
        const double sign = d_.opening == DrawnOpening::right ? 1 : -1;
        m.x[v] = -sign * y;
        m.y[v] = sign * x;
      }
    }
    sim::check_mesh(m);
  }

  void check_size() {
    const auto& m = out_->mesh;
    const auto [x0, x1] = std::minmax_element(m.x.begin(), m.x.end());
    const auto [y0, y1] = std::minmax_element(m.y.begin(), m.y.end());
    const double extent = std::max(*x1 - *x0, *y1 - *y0);
    check_drawn_size(reader_, d_.unit, extent, sim::measured_gap(*out_), d_.drawn_gap);
  }

  void move() {
    try {
      out_->motion = sim::drawn_motion(*out_);
    } catch (const std::invalid_argument& error) {
      reader_.fail("", "mesh", error.what());
      return;
    }
    const auto [from, to] = sim::usable_gaps(*out_);
    check_drawn_reach(reader_, from, to, d_.residual_gap, d_.travel);
  }

  FileReader& reader_;
  const DrawingDraft& d_;
  const sim::MshMesh& msh_;
  std::shared_ptr<sim::DrawnMagnet> out_ = std::make_shared<sim::DrawnMagnet>();
  std::map<int, int> region_;
  std::vector<int> zero_;
  DrawnSteels steels_;
};

}  // namespace

bool names_drawing(const fs::path& path) {
  return path.filename().string().ends_with(".magnet.toml");
}

std::shared_ptr<const sim::DrawnMagnet> read_drawing(const fs::path& path) {
  FileReader reader = FileReader::open(path);
  const fs::path folder = path.parent_path();
  DrawingDraft draft;
  FileReader first = reader;  // what else stands there can be judged only with the groups of the mesh
  first.read(mesh_key(draft));
  sim::MshMesh msh;
  if (first.good("", "mesh")) {
    msh = mesh_of_drawing(path, draft.mesh);
    draft.groups = groups_of(msh);
  }
  reader.read(drawing_keys(draft));
  if (!first.good("", "mesh")) reader.finish();
  for (const auto& g : draft.groups)
    if (g.dimension == 2 && !reader.good(g.section(), "role") && !reader.bad(g.section(), "role"))
      reader.fail(g.section(), "role", "is missing: the mesh has this surface",
                  fmt::format("{}", fmt::join(drawn_roles, ", ")));
  std::string name = path.filename().string();
  if (names_drawing(path)) name = name.substr(0, name.size() - std::string_view(".magnet.toml").size());
  return Assembly(reader, draft, folder, msh).run(name);
}

}  // namespace powbench::host
