#include "host/import/field_mesh.h"

#include <fmt/format.h>
#include <fmt/ranges.h>

#include <algorithm>
#include <array>
#include <map>

#include "host/config/bad_input.h"
#include "sim/magnetics/plane/import_mesh.h"

namespace powbench::host {
namespace {

enum Region : int { air, coil_out, coil_in, steel, armature, first_builtin };

/// Regions by name.
std::map<std::string, int> materials() {
  std::map<std::string, int> out{
      {"air", air}, {"coil+", coil_out}, {"coil-", coil_in}, {"steel", steel}, {"armature", armature}};
  int next = first_builtin;
  for (const auto& name : sim::builtin_steel_names()) out[name] = next++;
  return out;
}

struct Groups {
  std::map<int, int> region;  ///< by tag of the surface group
  std::vector<int> zero;      ///< tags of the line groups
};

Groups sort_groups(const sim::MshMesh& msh, const std::string& where, std::vector<std::string>& errors) {
  const auto known = materials();
  Groups out;
  for (const auto& g : msh.groups) {
    if (g.dimension == 1 && g.name == "A=0") out.zero.push_back(g.tag);
    if (g.dimension != 2) continue;
    if (const auto found = known.find(g.name); found != known.end()) {
      out.region[g.tag] = found->second;
      continue;
    }
    std::vector<std::string> names;
    for (const auto& [name, region] : known) names.push_back(name);
    errors.push_back(fmt::format("{}: physical surface {} = '{}' names no material; allowed {}", where, g.tag,
                                 g.name, fmt::join(names, ", ")));
  }
  if (out.zero.empty())
    errors.push_back(where + ": no physical line 'A=0'; the edge that no flux leaves through needs one");
  if (std::none_of(out.region.begin(), out.region.end(), [](const auto& r) { return r.second == coil_out; }))
    errors.push_back(where + ": no physical surface 'coil+'; nothing drives the field");
  return out;
}

void check_extent(const sim::Mesh& m, const std::string& where) {
  const auto [x0, x1] = std::minmax_element(m.x.begin(), m.x.end());
  const auto [y0, y1] = std::minmax_element(m.y.begin(), m.y.end());
  const double extent = std::max(*x1 - *x0, *y1 - *y0);
  if (extent >= 5e-3 && extent <= 5) return;
  throw BadInput(
      {fmt::format("{}: the mesh is {:.6g} mm wide or high, allowed 5 .. 5000; is --mesh-unit right?", where,
                   extent * 1e3)});
}

/// 1 on the armature. The force is taken in the layer of triangles around it, which must not be steel.
std::vector<double> armature_weight(const sim::Mesh& m, const std::string& where) {
  std::vector<double> weight(m.x.size(), 0);
  const auto visit = [&](const auto& each) {
    for (std::size_t t = 0; t < m.triangle.size(); ++t)
      for (const int v : m.triangle[t]) each(m.region[t], weight[static_cast<std::size_t>(v)]);
  };
  visit([](int region, double& w) {
    if (region == armature) w = 1;
  });
  visit([&](int region, double w) {
    if (region != armature && region >= steel && w > 0)
      throw BadInput({where + ": steel touches the armature; a layer of air between them is needed, "
                              "as thin as the residual gap"});
  });
  if (std::all_of(weight.begin(), weight.end(), [](double w) { return w == 0; })) weight.clear();
  return weight;
}

}  // namespace

FieldMesh read_field_mesh(std::string_view content, const std::string& where, const FieldMeshOptions& o) {
  FieldMesh out;
  std::vector<std::string> errors;
  try {
    const auto msh = sim::read_msh(content);
    const auto groups = sort_groups(msh, where, errors);
    if (!errors.empty()) throw BadInput(errors);
    out.mesh = sim::import_plane_mesh(msh, o.metres, groups.region, groups.zero);
  } catch (const std::invalid_argument& error) {
    throw BadInput({where + ": " + error.what()});
  }
  check_extent(out.mesh, where);
  out.armature = armature_weight(out.mesh, where);
  auto& s = out.setup;
  s.depth = o.depth;
  s.steels = {o.steel};
  s.steel_of_region = {-1, -1, -1, 0, 0};
  for (const auto& name : sim::builtin_steel_names()) {
    s.steel_of_region.push_back(static_cast<int>(s.steels.size()));
    s.steels.push_back(sim::builtin_steel(name));
  }
  s.windings = {{{{coil_out, o.turns}}}};
  if (sim::region_area(out.mesh, coil_in) > 0) s.windings[0].parts.push_back({coil_in, -o.turns});
  return out;
}

}  // namespace powbench::host
