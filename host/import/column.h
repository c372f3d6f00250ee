#pragma once

#include <optional>
#include <string>
#include <vector>

#include "core/channels.h"

/// What the header of a waveform file says about its columns.

namespace powbench::host {

/// What a column's numbers are before any calibration.
enum class Kind { seconds, newtons, volts, metres, amperes };

struct Column {
  std::string title;               ///< the header cell as written
  std::optional<Channel> channel;  ///< nothing: the time column
  Kind kind = Kind::volts;
  double factor = 1.0;  ///< SI unit of `kind` per unit of the column
  bool calibrated =
      true;  ///< in the channel's own quantity; else volts that need a gain from the calibration file
};

/// Header cells `name [unit]`; names in any case: `time` and those of the channel table. Units, in their own case:
/// s ms us, N mN, V mV, m mm um, A mA. The time column may stand anywhere. Throws BadInput naming every mistake,
/// with the nearest known name. Without `clock` (the calibration file gives the sample rate) the time column may be absent.
std::vector<Column> read_header(const std::vector<std::string>& cells, const std::string& file, int line,
                                bool clock = true);

/// The names a column may have, for messages: `time, pvdf_a, ...`.
std::string known_columns();

}  // namespace powbench::host
