#pragma once

#include <cmath>
#include <limits>
#include <string>
#include <vector>

/// The figures printed in the two papers, carried with the program, and their relative errors recomputed.

namespace powbench::host {

inline constexpr double unknown = std::numeric_limits<double>::quiet_NaN();  ///< a value nobody gave

inline constexpr const char* paper_closing =
    "Full Simulation of AC Contactor in the Dynamic Process Based on Finite Element Method";
inline constexpr const char* paper_pressure =
    "Simulation Study of AC Contactor Dynamic Contacts Contact Pressure Based on ADAMS";

/// One printed quantity. `unit` is that of the print (ms, mA, mm, N). NaN = not printed.
struct PublishedRow {
  std::string paper;             ///< title
  int table = 0;                 ///< number of the table; 0 = a statement in the text
  double theta_deg = unknown;    ///< closing angle; NaN = not stated
  std::string quantity;          ///< symbol of the print
  std::string unit;              ///< as intended
  double simulation = unknown;   ///< the paper's own simulation
  double measurement = unknown;  ///< the paper's measurement
  double printed_error_percent = unknown;
  double recomputed_error_percent = unknown;  ///< 100 |simulation - measurement| / |measurement| of the print
  std::string note;                           ///< what to know about the row; empty = nothing
  bool excluded = false;                      ///< the print cannot serve as a reference; `note` says why

  /// The printed error is not the rounded recomputed one (two decimals).
  bool misprinted() const {
    return std::isfinite(printed_error_percent) &&
           !(std::fabs(printed_error_percent - recomputed_error_percent) <= 0.005);
  }
};

/// Relative error in percent of the reference, on magnitudes: 100 |value - reference| / |reference|. Both zero: 0;
/// reference zero only, or either unknown: NaN.
double relative_error_percent(double value, double reference);

/// All rows: the 54 of tables 1 and 2, then the statements on bounce. Parsed once. Throws std::logic_error when the
/// embedded data is damaged.
const std::vector<PublishedRow>& published_rows();

/// Row of the closing tables, or nullptr.
const PublishedRow* find_published(const std::string& quantity, double theta_deg);

/// Factor from a printed unit to SI: ms 1e-3, mA 1e-3, mm 1e-3, N 1. Throws std::invalid_argument for another unit.
double si_per(const std::string& unit);

}  // namespace powbench::host
