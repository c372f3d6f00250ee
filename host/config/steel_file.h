#pragma once

#include <filesystem>
#include <string>
#include <string_view>
#include <vector>

#include "sim/magnetics/steel_rows.h"

/// A measured B-H curve from a CSV file: the steel of a lab.

namespace powbench::host {

/// One file, read and made fit for use.
struct SteelSheet {
  std::string name;                  ///< of the file, without folder and ending
  std::vector<sim::BhRow> measured;  ///< T, A/m, as in the file
  sim::FittedRows fitted;
  std::vector<std::string> notes;  ///< columns and cells passed over, for people
};

/// A header line names the columns and their units, then one row a line, in any order of columns and of H:
///   H in A/m, kA/m, A/cm or Oe; B in T, mT, G or kG, or J, the polarisation B - mu0 H, in the same units
///   written as `H (A/m)`, `H [A/m]`, `H / (A/m)`, `H / A/m`, `H_A_per_m` or `H in A/m`; `B (T)` and
///   so on. Other columns are passed over.
/// Throws BadInput with file, line and reason: what read_csv refuses, a column that is missing, there twice or
/// without unit, numbers that cannot be those of a soft magnetic material in these units (sim::doubt_units), and what
/// sim::fit_rows refuses.
SteelSheet parse_steel(std::string_view text, const std::string& file);
SteelSheet read_steel(const std::filesystem::path&);

/// True if `text` names a file rather than a built-in steel: it has a dot or a slash.
bool names_steel_file(std::string_view text);

}  // namespace powbench::host
