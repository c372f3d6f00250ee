#include "host/study/scene_fields.h"

#include <fmt/format.h>

#include <algorithm>
#include <memory>

#include "host/config/bad_input.h"
#include "host/store/field_table.h"
#include "sim/magnetics/plane/drawn_magnet.h"
#include "sim/models/mechanics.h"

namespace powbench::host {
namespace {

namespace fs = std::filesystem;

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

/// Tables that are kept in the folder of the cache.
class KeptTables final : public sim::FieldTables {
 public:
  explicit KeptTables(const FieldCache& cache) : cache_(cache) {}
  sim::TableOptions options(const sim::Specimen& s) const override { return options_of(s, cache_); }
  std::shared_ptr<const sim::TablePotential> drawn_or_plane(const sim::Specimen& s) override {
    return s.in_space ? space_table(s, cache_) : plane_table(s, cache_);
  }
  std::shared_ptr<const sim::TablePotential> with_ends(const sim::Specimen& s) override {
    return end_table(s, cache_);
  }

 private:
  const FieldCache& cache_;
};

}  // namespace

sim::FieldRung obtain_field(std::string_view name, const sim::Specimen& s, const FieldCache& cache) {
  const auto kinds = sim::all_fields();
  const std::size_t k = sim::place_of_fields(name);
  if (k == kinds.size())
    throw BadInput({fmt::format("fields = {}, allowed {}", name, sim::names_of(kinds, ", "))});
  try {
    if (const std::string why = kinds[k].unknown(s); !why.empty()) throw std::invalid_argument(why);
    KeptTables tables(cache);
    return kinds[k].rung(s, tables);
  } catch (const std::invalid_argument& error) {
    throw BadInput({fmt::format("{}fields = {}: {}", s.magnet.drawing.empty() ? "" : s.magnet.drawing + ": ",
                                name, error.what())});
  }
}

}  // namespace powbench::host
