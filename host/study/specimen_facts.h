#pragma once

#include <string>
#include <vector>

#include "core/conditions.h"
#include "sim/specimen/specimen.h"

/// What the numbers of a specimen make together, beside what catalogues print: the first look at a file of one's own.

namespace powbench::host {

/// One derived number. NaN: it does not exist, and `note` says why. Ranges are those of three-pole AC contactors of the
/// 25 .. 40 A frame; NaN: catalogues print none.
struct SpecimenFact {
  std::string name;  ///< for people, with the unit
  std::string key;   ///< for programs, with the unit
  double value = 0;
  double low = 0, high = 0;
  std::string note;
};

/// Inrush and holding power, pick-up and drop-out voltage, pull against load, natural frequencies (each body on its
/// own spring, others at rest), time scales and rebounds; then the keys of the file that lie outside the bounds of
/// `catalogue_parameters`, in their own unit. Takes some tens of closings: a fraction of a second.
std::vector<SpecimenFact> specimen_facts(const sim::Specimen&, const Conditions& rated);

std::string facts_text(const sim::Specimen&, const Conditions& rated, const std::vector<SpecimenFact>&);
std::string facts_json(const sim::Specimen&, const std::vector<SpecimenFact>&);

}  // namespace powbench::host
