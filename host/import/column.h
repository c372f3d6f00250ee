#pragma once

#include <array>
#include <optional>
#include <string>
#include <vector>

#include "core/channels.h"

/// What the header of a waveform file says about its columns.

namespace powbench::host {

/// Header cells of a foreign file, by what they stand for: [0] the time column, [1 + i] channel i. Each as `name` or
/// `name [unit]`; "" = under its own name. With any of them given, columns that neither they nor the channel table
/// name are passed over.
using ForeignColumns = std::array<std::string, 1 + channel_count>;

/// What a column's numbers are before any calibration.
enum class Kind { seconds, newtons, volts, metres, amperes };

struct Column {
  std::string title;               ///< the header cell as written
  std::optional<Channel> channel;  ///< nothing: the time column
  bool passed_over = false;        ///< neither: a column of a foreign file that nothing asks for
  Kind kind = Kind::volts;
  double factor = 1.0;  ///< SI unit of `kind` per unit of the column
  bool calibrated =
      true;  ///< in the channel's own quantity; else volts that need a gain from the calibration file
};

/// Header cells `name [unit]`; names in any case: `time` and those of the channel table. Units, in their own case:
/// s ms us, N mN, V mV, m mm um, A mA. The time column may stand anywhere. Throws BadInput naming every mistake,
/// with the nearest known name. Without `clock` (the calibration file gives the sample rate) the time column may be
/// absent. `foreign`: a cell is found by its whole text or by what stands before its brackets; the unit is the
/// entry's, else the cell's own. An entry that no cell answers to is a mistake, and so is one that two answer to.
std::vector<Column> read_header(const std::vector<std::string>& cells, const std::string& file, int line,
                                bool clock = true, const ForeignColumns& foreign = {});

/// The names a column may have, for messages: `time, pvdf_a, ...`.
std::string known_columns();

}  // namespace powbench::host
