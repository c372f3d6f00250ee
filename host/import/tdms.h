#pragma once

#include <string>
#include <string_view>

#include "host/config/csv_table.h"

/// TDMS, the measurement files of LabVIEW and of what NI sells.

namespace powbench::host {

/// Columns `time [s]`, `NAME [UNIT]` of the channels that hold waveforms (property wf_increment) or, with no such, of
/// all channels of equal length beside one called time. Any number of segments, contiguous or interleaved, either
/// byte order; a file that was not closed is read up to its last whole chunk. Linear scalings (NI_Scale, of type
/// Linear) are applied. Throws BadInput, one sentence: raw data of DAQmx, channels of unequal length or clock, a cut
/// or damaged file.
CsvTable parse_tdms(std::string_view bytes, const std::string& file);

}  // namespace powbench::host
