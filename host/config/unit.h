#pragma once

#include <string>
#include <string_view>

/// Units of configuration keys. The unit is the suffix of the key (`gap_mm`); this is the only place where
/// configuration changes between that unit and SI.

namespace powbench::host {

/// si = (value * factor) * 10^decimal + offset. Powers of ten are applied to the decimal text of the value, so
/// that 2.51 mm is the same double as 2.51e-3.
struct Unit {
  std::string_view suffix;  ///< as in the key, without the underscore
  std::string_view text;    ///< for people
  int decimal = 0;
  double factor = 1.0;
  double offset = 0.0;
};

/// The unit that the key's longest known suffix names; a unit without suffix when there is none.
const Unit& unit_of_key(std::string_view key);

/// Value in SI.
double to_si(double value, const Unit&);

/// The shortest decimal text whose to_si is `si` bit for bit (for `si` that came from at most 15 digits; else within
/// one unit in the last place).
std::string from_si(double si, const Unit&);

/// Shortest text that reads back as the same double; TOML spelling of nan and inf.
std::string number_text(double);

}  // namespace powbench::host
