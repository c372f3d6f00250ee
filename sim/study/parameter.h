#pragma once

#include <span>
#include <string>
#include <string_view>
#include <vector>

#include "sim/specimen/specimen_fields.h"

/// Numbers of a specimen as coordinates of a search: each between two bounds, mapped to 0 .. 1.

namespace powbench::sim {

/// One free number. Bounds in SI; a logarithmic one needs low > 0.
struct Parameter {
  const SpecimenField* field = nullptr;
  double low = 0;
  double high = 1;
  bool logarithmic = false;

  /// `section.key` of the specimen file, e.g. `bridges.gap_mm`.
  std::string name() const { return std::string(field->section) + '.' + std::string(field->key); }
  double value_at(double coordinate) const;  ///< SI; coordinate in [0, 1]
  double coordinate_of(double value) const;  ///< clamped to [0, 1]
};

/// Field of a specimen by `section.key`. Throws std::invalid_argument naming the nearest sections otherwise.
const SpecimenField& specimen_field(std::string_view name);

/// The same, with bounds in the unit of the key. Throws std::invalid_argument when the bounds are not ascending, lie
/// outside the range of the field, or are not above 0 for a logarithmic one.
Parameter parameter(std::string_view name, double low, double high, bool logarithmic = false);

/// `base` with the numbers at `point` put in; sizes equal.
Specimen specimen_at(const Specimen& base, std::span<const Parameter>, std::span<const double> point);
std::vector<double> point_of(const Specimen&, std::span<const Parameter>);

/// What a three-pole contactor of the 25 .. 40 A frame may have: bounds from catalogues, from the papers' statements
/// and from plausibility where nothing is printed. `buffered`: the static core as a mass of its own on buffer springs
/// too.
std::vector<Parameter> catalogue_parameters(bool buffered = false);

/// The same for a posterior (sim/study/posterior.h), whose motion is fitted first: base and leakage may be smaller.
/// The compliance under the pull need not belong to the mass that vibrates after the impact; before the impact a base
/// is little more than its spring.
std::vector<Parameter> posterior_parameters();

}  // namespace powbench::sim
