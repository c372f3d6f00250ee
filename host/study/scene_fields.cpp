#include "host/study/scene_fields.h"

#include <fmt/format.h>

#include <algorithm>
#include <memory>

#include "host/config/bad_input.h"
#include "host/store/field_table.h"
#include "sim/field3d/ladder3.h"
#include "sim/fields/drawn_magnet.h"
#include "sim/specimen_potential.h"

namespace powbench::host {
namespace {

namespace fs = std::filesystem;
using Potential = std::shared_ptr<const sim::MagneticPotential>;

sim::TableOptions options_of(const sim::Specimen& s, const FieldCache& cache) {
  sim::TableOptions o;
  o.accuracy = cache.accuracy;
  o.largest_gap = std::max(1.5 * s.core.travel, 0.2e-3);
  return o;
}

void say(const FieldCache& cache, const std::string& text) {
  if (cache.say) cache.say(text);
}

std::shared_ptr<const sim::TablePotential> plane_table(const sim::Specimen& s, const FieldCache& cache) {
  say(cache,
      (s.drawn ? "field table of the drawing: from " : "field table of the shape, plane, with ring: from ") +
          cache.folder.string() + ", or built there");
  sim::Team team(2);
  if (s.drawn)
    return std::make_shared<sim::TablePotential>(
        obtain_field_table(cache.folder, s.drawn, options_of(s, cache), team).table);
  return std::make_shared<sim::TablePotential>(
      obtain_field_table(cache.folder, sim::magnet_design(s), options_of(s, cache), team).table);
}

/// Nodes and cells of the tables whose difference is the ends' share: that is smooth, so both are coarse.
sim::TableOptions end_options(const sim::Specimen& s, const FieldCache& cache) {
  sim::TableOptions o = options_of(s, cache);
  o.ring = false;
  o.psi_nodes = 12;
  o.gap_nodes = 8;
  return o;
}

Potential solid_table(const sim::Specimen& s, const FieldCache& cache, bool ends) {
  const auto design = sim::magnet_design(s);
  const auto options = end_options(s, cache);
  sim::CoreMeshSizes3 sizes = sim::CoreMeshSizes3{}.scaled(2);
  sizes.ends = ends;
  const fs::path file = cache.folder / fmt::format("field3d-{:016x}-{}.table",
                                                   sim::table_hash(design, options), ends ? "ends" : "plane");
  if (fs::exists(file)) return std::make_shared<sim::TablePotential>(load_field_table(file));
  say(cache, fmt::format("building {}", file.string()));
  fs::create_directories(cache.folder);
  const auto table = sim::build_table3(design, sizes, options);
  save_field_table(file, table);
  return std::make_shared<sim::TablePotential>(table);
}

}  // namespace

sim::FieldRung obtain_field(std::string_view name, const sim::Specimen& s, const FieldCache& cache) {
  try {
    if (name == "circuit") {
      sim::require_circuit(s);
      return sim::circuit_field();
    }
    if (!s.drawn && !s.magnet.drawing.empty())
      throw std::invalid_argument("the drawing '" + s.magnet.drawing + "' of the stored specimen '" + s.name +
                                  "' is not at hand; name its specimen file");
    if (s.drawn && name == "field2d") return sim::live_field(s.drawn, {});
    if (s.drawn && name == "field3d")
      throw std::invalid_argument("allowed table, field2d: the drawing of specimen '" + s.name +
                                  "' is no magnet in three dimensions");
    if (!s.shaped && !s.drawn && std::ranges::find(sim::field_names, name) != sim::field_names.end())
      throw std::invalid_argument("allowed circuit, for specimen '" + s.name +
                                  "' has no [shape]: whose magnet the fields are is not known");
    if (name == "table") {
      const auto table = plane_table(s, cache);
      return sim::pure_field("table", table->table().description, table);
    }
    if (name == "field2d")
      return sim::live_field(sim::magnet_design(s),
                             sim::plan_table(sim::magnet_design(s), options_of(s, cache)).field);
    if (name == "field3d")
      return sim::pure_field("field3d",
                             "plane table with the ends of stack and winding from three dimensions",
                             sim::corrected_potential(plane_table(s, cache), solid_table(s, cache, true),
                                                      solid_table(s, cache, false)));
  } catch (const std::invalid_argument& error) {
    throw BadInput({fmt::format("fields = {}: {}", name, error.what())});
  }
  std::string known;
  for (const auto n : sim::field_names) known += (known.empty() ? "" : ", ") + std::string(n);
  throw BadInput({fmt::format("fields = {}, allowed {}", name, known)});
}

}  // namespace powbench::host
