#pragma once

#include <span>
#include <string_view>

#include "sim/specimen/specimen.h"

/// Every number of a specimen once: its place in the specimen file, its unit there, its range and how to reach it.
/// The reader of specimen files, the validation and reports derive from this table.

namespace powbench::sim {

struct SpecimenField {
  std::string_view section;              ///< coil, magnet, core, bridges, base, shape
  std::string_view key;                  ///< with the unit in its name, e.g. gap_mm
  double si_per_unit;                    ///< factor from the unit of the key to SI
  double low, high;                      ///< allowed, in the unit of the key
  bool whole;                            ///< a whole number
  double (*get)(const Specimen&);        ///< SI
  void (*set)(Specimen&, double value);  ///< SI
  std::string_view meaning;              ///< one line for people, with the symbol
};

/// In file order. The ranges hold any contactor of about 6 A to 1000 A, and catch a slip of unit.
std::span<const SpecimenField> specimen_fields();

}  // namespace powbench::sim
