#pragma once

#include <filesystem>
#include <string>
#include <string_view>
#include <vector>

#include "host/config/csv_table.h"

/// COMTRADE, the exchange format of fault recorders and relays (IEEE C37.111 of 1991, 1999 and 2013, IEC 60255-24).

namespace powbench::host {

/// Analogue channels of a recording; the status channels are passed over.
struct Comtrade {
  struct Channel {
    std::string name, unit;
    double skew = 0.0;  ///< s: sampled so much later than the time of the row says
    std::vector<double>
        value;  ///< a x + b in `unit`, as the file states it; NaN where it says that nothing was sampled
  };

  std::string station;
  int revision = 1991;
  double line_hertz = 0.0;
  std::vector<double> time;  ///< s, 0 at the trigger
  std::vector<Channel> channels;
};

/// From the text of the configuration and the bytes of the data: ASCII, BINARY, BINARY32 or FLOAT32; any number of
/// sampling rates, or time stamps (in us, or ns where the start has more than six decimals, times the multiplier).
/// The names stand in messages. Throws BadInput naming file, line or row, value and what is allowed.
Comtrade parse_comtrade(std::string_view configuration, std::string_view data,
                        const std::string& configuration_file, const std::string& data_file);

/// `x.cfg` with `x.dat` beside it (or the other way round; upper case too), or a single `x.cff`.
Comtrade read_comtrade(const std::filesystem::path&);

/// By its ending.
bool is_comtrade(const std::filesystem::path&);

/// Columns `time [s]`, then one a channel, `Ua [V]`, with its skew taken for a negative delay.
CsvTable to_table(const Comtrade&);

}  // namespace powbench::host
