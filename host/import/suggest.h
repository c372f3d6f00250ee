#pragma once

#include <optional>
#include <string>
#include <vector>

#include "core/channels.h"
#include "host/config/csv_table.h"

/// Which column of a foreign file may be which channel. A suggestion is for a person to confirm; nothing is imported
/// by it.

namespace powbench::host {

/// What the choice rests on, the surest first.
enum class Ground {
  name,  ///< the column's name says it
  shape,  ///< only this channel looks so: mains, switched mains, a contact voltage that falls, a travel that arrives, a
  ///< current with inrush or one that slows down to its end
  unit,   ///< the unit leaves this channel, and the names' order decides between two
  guess,  ///< what was left over
};
std::string_view name(Ground);

/// How much may be trusted, by what it rests on and by how clearly a shape shows.
enum class Sureness { sure, likely, unsure };
std::string_view name(Sureness);

struct Suggestion {
  std::size_t column = 0;          ///< of the table
  std::optional<Channel> channel;  ///< nothing: none fits, or all that fit are taken
  Ground ground = Ground::guess;
  Sureness sure = Sureness::unsure;
  std::string why;  ///< half a sentence
};

struct Suggested {
  std::vector<Suggestion> columns;  ///< one for each column but the time
  std::string time;                 ///< header of the time column; "" = none was found
  std::string time_why;             ///< half a sentence
  std::optional<double> switch_on;  ///< s, where the coil voltage begins
  std::optional<double> hold;  ///< s, from there, or else from time 0, to where coil voltage or current ends
  std::string hold_why;        ///< what ends there
};

Suggested suggest_columns(const CsvTable&);

/// The calibration file that the suggestion makes: [columns], and for each column in volts its gain as a comment: what
/// is missing, or for a voltage the factor of a probe.
std::string suggested_file(const CsvTable&, const Suggested&, const std::string& waveform);

}  // namespace powbench::host
