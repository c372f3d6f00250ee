#pragma once

#include <string>
#include <string_view>

#include "core/outcome.h"
#include "host/store/field_table.h"

/// What `powbench field` says of a table, whatever magnet it is of.

namespace powbench::host {

/// That mesh or table miss the accuracy asked for, by how much, and what helps; "" when they do not.
std::string missed_accuracy(const sim::PotentialTable&, double asked, std::string_view finer_mesh,
                            std::string_view finer_table);

/// Of a table that is written all the same: 1 where it misses the accuracy.
constexpr Exit exit_of_accuracy(std::string_view missed) {
  return missed.empty() ? Exit::pass : Exit::outside_limits;
}

/// File, nodes, expected errors, and what was missed: lines.
std::string table_head(const FieldTableChoice&, const std::string& missed);

/// The same as the first keys of the JSON.
template <class Json>
Json table_json(const FieldTableChoice& choice, double asked, const std::string& missed) {
  const sim::PotentialTable& t = choice.table;
  return {{"table", choice.file.string()},
          {"reused", choice.reused},
          {"description", t.description},
          {"mesh_error", t.mesh_error},
          {"worst_current_error", t.worst_current_error()},
          {"worst_pull_error", t.worst_pull_error()},
          {"accuracy", asked},
          {"accuracy_met", missed.empty()}};
}

/// How much of a table rests on extrapolated steel, in a few words.
std::string extrapolated_text(const sim::PotentialTable&, const sim::ExtrapolatedShare&);

}  // namespace powbench::host
