#pragma once

#include <filesystem>
#include <functional>
#include <string>
#include <string_view>

#include "sim/models/fields.h"

/// The rungs of fields by name, from a specimen; tables are built once and kept on disk by what they depend on.

namespace powbench::host {

struct FieldCache {
  std::filesystem::path folder = "field";
  std::function<void(const std::string&)> say;  ///< told before something takes long
  double accuracy = 0.01;                       ///< of tables, share of current and pull
};

/// circuit  the specimen's lumped circuit
/// table    plane finite elements of its shape, with the ring, in a table
/// solved   the same elements solved at every step
/// ends     the table, plus what the ends of stack, winding and ring add: the difference of two tables in three
///          dimensions, with ends and without, on the same cells
/// Throws BadInput for an unknown name and a shape that cannot be or is not known; StoreError for a damaged table.
sim::FieldRung obtain_field(std::string_view name, const sim::Specimen&, const FieldCache&);

}  // namespace powbench::host
