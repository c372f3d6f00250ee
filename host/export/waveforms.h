#pragma once

#include <string>
#include <utility>
#include <vector>

#include "core/record.h"
#include "host/export/event_table.h"

/// A record for other programs. Time is seconds after switch-on on the sampling clock, value = (count + offset) scale
/// in SI; sensor delays are not applied, droop is not undone, a lost sample is unknown. Written and read back, times
/// and values are the same doubles.

namespace powbench::host {

using About = std::vector<std::pair<std::string, std::string>>;  ///< whose record this is: key and text

/// How much earlier the values of each channel show their quantity, in us: a table has one column of time for all.
About delays_of(const Record&);

/// Columns `time_s`, `pvdf_a_N`, ... of the record.
Table waveform_table(const Record&);

/// This program was built with HDF5.
bool can_write_netcdf();

/// HDF5 in the layout of netCDF-4: dimension and coordinate `time` (units "s"), a variable for each channel as
/// float64 with units, long_name, scale, offset, delay_s, corner_hertz, and its counts as NAME_counts (int16);
/// attributes of the file: those of `about` below 60 kB. xarray.open_dataset reads it. Throws BadInput where the file
/// cannot be written or the program was built without HDF5.
void write_netcdf(const Record&, const About&, const std::string& path);

struct ComtradeText {
  std::string configuration, data;  ///< x.cfg, x.dat
};
/// COMTRADE of 2013 (IEC 60255-24): BINARY counts, or BINARY32 where a channel holds the code of BINARY for a lost
/// sample; a = scale, b = offset scale; the trigger is the switch-on, to the nanosecond. The skew is minus the delay.
/// `station` names the recording.
ComtradeText to_comtrade(const Record&, const std::string& station);

}  // namespace powbench::host
