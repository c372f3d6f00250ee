#pragma once

#include <array>
#include <filesystem>
#include <limits>
#include <string>
#include <vector>

#include "core/channels.h"
#include "core/record.h"
#include "host/import/column.h"

/// The calibration file: what a waveform's numbers cannot say by themselves. TOML, beside the waveform: the same name
/// with the ending `.toml`. Owner: whoever recorded the waveform.

namespace powbench::host {

struct WaveformChannel {
  double gain =
      std::numeric_limits<double>::quiet_NaN();  ///< SI unit of the channel per volt; NaN = not given
  std::string certificate;    ///< file of a digital calibration certificate that gives the gain; "" = none
  double corner_hertz = 0.0;  ///< low corner of the charge amplifier; 0 = DC
  double delay = 0.0;         ///< s
  double step =
      std::numeric_limits<double>::quiet_NaN();  ///< unit of the column for one count; NaN = not known
  double crosstalk = 0.0;  ///< film channels: share of the other film's force that this one shows
  double clip_low = std::numeric_limits<double>::quiet_NaN();  ///< unit of the column; at or below: saturated
  double clip_high =
      std::numeric_limits<double>::quiet_NaN();  ///< unit of the column; at or above: saturated
};

struct Calibration {
  std::string id;           ///< of the calibration in force; "" = none
  std::string valid_until;  ///< last day, `2030-12-31`; "" = not stated
  std::string recorded;     ///< day of the record; "" = today
  std::string source;       ///< what made the record; "" = not given
  double switch_on = 0.0;   ///< s, on the time column
  double hold_time = std::numeric_limits<double>::
      quiet_NaN();  ///< s; NaN = to the switch-off that the coil shows, else to the end of the record
  double sample_rate = std::numeric_limits<double>::quiet_NaN();    ///< Hz, instead of the time column
  double mains_hertz = std::numeric_limits<double>::quiet_NaN();    ///< nominal; NaN = not given
  double closing_angle = std::numeric_limits<double>::quiet_NaN();  ///< rad, commanded
  std::array<WaveformChannel, channel_count> channels{};
  ForeignColumns columns;
  std::vector<std::string> notes;  ///< what was taken from certificates, a sentence each

  const WaveformChannel& of(Channel c) const { return channels[index(c)]; }
};

/// `shot.csv` -> `shot.toml`.
std::filesystem::path calibration_path(const std::filesystem::path& waveform);

/// With the gains of the certificates that it names, which lie beside it (host/import/dcc.h): where [channel]
/// certificate is given, the gain is the certificate's. Where `calibration` is not given, it is the identifier of the
/// certificates. Throws BadInput with all mistakes.
Calibration read_calibration(const std::filesystem::path&);
Calibration parse_calibration(std::string text, std::string file);

/// Commented file with every key.
std::string calibration_template();

/// The file that goes with a waveform exported from a record of that source: parse_calibration reads it back.
std::string calibration_of(const Record&, const std::string& source);

/// The calibration counts: it has a name and its last day is not before the day of the record (`today` when that is not
/// given), all as `YYYY-MM-DD`.
bool in_force(const Calibration&, const std::string& today);

}  // namespace powbench::host
