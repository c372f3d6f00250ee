#pragma once

#include <string>
#include <string_view>

/// Names and units as instruments write them.

namespace powbench::host {

struct ScopeUnit {
  std::string
      unit;  ///< as in read_header (s, V, A, N, m, ...); "" = none stated; another's own word where it is not known
  double factor = 1.0;  ///< value in `unit` per value in the file
};
/// From `Volt`, `volts`, `V`, `(mV)`, `second`, `ns`, ...
ScopeUnit scope_unit(std::string_view text);

/// A cell in a line of units: a unit, in parentheses or not, or `Sequence`.
bool is_unit_word(std::string_view cell);

struct ScopeColumn {
  std::string name, unit;
};
/// `CH1(V)`, `CH1 (V)`, `CH1 [V]`, `CH1 / V`, `C1 in V`, `in s` (the time), and `CH1V` where `unit_behind`.
ScopeColumn scope_column(std::string_view cell, bool unit_behind);

/// A name with its unit in one of these ways; `t0 = ...` too.
bool is_scope_name(std::string_view cell);

/// `Time`, `t`, `X`, `x-axis`, `second`, ...
bool is_time_name(std::string_view name);

}  // namespace powbench::host
