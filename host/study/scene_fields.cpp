#include "host/study/scene_fields.h"

#include <fmt/format.h>

#include <algorithm>
#include <memory>

#include "host/config/bad_input.h"
#include "host/store/field_table.h"
#include "sim/magnetics/plane/drawn_magnet.h"
#include "sim/specimen/specimen_potential.h"

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

/// What a drawing's table errs by, once it is there.
std::shared_ptr<const sim::TablePotential> judged(const FieldCache& cache, sim::PotentialTable table) {
  const double nodes = table.worst_error();
  const double error = std::max(nodes, table.mesh_error);
  say(cache,
      fmt::format(
          "  expected error: mesh {:.2g} %, table {:.2g} %{}", 100 * table.mesh_error, 100 * nodes,
          error > cache.accuracy
              ? fmt::format("; above the {:.3g} % that it is made for, `powbench field` says what helps",
                            100 * cache.accuracy)
              : ""));
  return std::make_shared<sim::TablePotential>(std::move(table));
}

std::shared_ptr<const sim::TablePotential> plane_table(const sim::Specimen& s, const FieldCache& cache) {
  say(cache,
      (s.drawn ? "field table of the drawing: from " : "field table of the shape, plane, with ring: from ") +
          cache.folder.string() + ", or built there");
  sim::Team team(2);
  if (s.drawn)
    return judged(cache, obtain_field_table(cache.folder, s.drawn, options_of(s, cache), team).table);
  return std::make_shared<sim::TablePotential>(
      obtain_field_table(cache.folder, sim::magnet_design(s), options_of(s, cache), team).table);
}

/// The table of a drawing in space.
std::shared_ptr<const sim::TablePotential> space_table(const sim::Specimen& s, const FieldCache& cache) {
  say(cache,
      "field table of the drawing in space: from " + cache.folder.string() + ", or built there (minutes)");
  auto choice = obtain_field_table(cache.folder, *s.in_space, options_of(s, cache), [&](int done, int all) {
    say(cache, fmt::format("  {} of {} states in space", done, all));
  });
  return judged(cache, std::move(choice.table));
}

/// The plane table with the ends of three dimensions; the ring is a variable where the shape has one.
std::shared_ptr<const sim::TablePotential> end_table(const sim::Specimen& s, const FieldCache& cache) {
  const auto design = sim::magnet_design(s);
  say(cache,
      fmt::format("field table of the shape with the ends of three dimensions{}: from {}, or built there",
                  s.shape.ring_share > 0 ? ", with ring (minutes)" : "", cache.folder.string()));
  sim::EndTableOptions ends;
  ends.progress = [&cache](int done, int all) {
    say(cache, fmt::format("  {} of {} states in three dimensions", done, all));
  };
  sim::Team team(2);
  auto choice = obtain_end_table(cache.folder, design, options_of(s, cache), ends, team);
  if (!choice.reused) say(cache, fmt::format("  built in {:.0f} s of CPU", choice.cpu_seconds));
  return std::make_shared<sim::TablePotential>(std::move(choice.table));
}

}  // namespace

sim::FieldRung obtain_field(std::string_view name, const sim::Specimen& s, const FieldCache& cache) {
  try {
    if (name == "circuit") {
      sim::require_circuit(s);
      return sim::circuit_field();
    }
    if (!s.drawn && !s.in_space && !s.magnet.drawing.empty())
      throw std::invalid_argument("the drawing '" + s.magnet.drawing + "' of the stored specimen '" + s.name +
                                  "' is not at hand; name its specimen file");
    if (s.in_space && (name == "field2d" || name == "field3d"))
      throw std::invalid_argument("allowed table: that of the drawing in space of specimen '" + s.name +
                                  "' is of three dimensions");
    if (s.drawn && name == "field2d") return sim::live_field(s.drawn, {});
    if (s.drawn && name == "field3d")
      throw std::invalid_argument("allowed table, field2d: the drawing of specimen '" + s.name +
                                  "' is no magnet in three dimensions");
    if (!s.shaped && !s.drawn && !s.in_space &&
        std::ranges::find(sim::field_names, name) != sim::field_names.end())
      throw std::invalid_argument("allowed circuit, for specimen '" + s.name +
                                  "' has no [shape]: whose magnet the fields are is not known");
    if (name == "table") {
      const auto table = s.in_space ? space_table(s, cache) : plane_table(s, cache);
      return sim::pure_field("table", table->table().description, table);
    }
    if (name == "field2d")
      return sim::live_field(sim::magnet_design(s),
                             sim::plan_table(sim::magnet_design(s), options_of(s, cache)).field);
    if (name == "field3d") {
      const auto table = end_table(s, cache);
      return sim::pure_field("field3d", table->table().description, table);
    }
  } catch (const std::invalid_argument& error) {
    throw BadInput({fmt::format("{}fields = {}: {}", s.magnet.drawing.empty() ? "" : s.magnet.drawing + ": ",
                                name, error.what())});
  }
  std::string known;
  for (const auto n : sim::field_names) known += (known.empty() ? "" : ", ") + std::string(n);
  throw BadInput({fmt::format("fields = {}, allowed {}", name, known)});
}

}  // namespace powbench::host
