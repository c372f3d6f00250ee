#pragma once

#include <string>
#include <string_view>

#include "host/config/csv_table.h"

/// Waveforms of Yokogawa's ScopeCorders and oscilloscopes: a text, x.HDR, beside the samples, x.WVF.

namespace powbench::host {

/// Columns `time [s]`, `CH1 [V]`, ... of all groups, which must have one clock and one length; data in traces or in
/// blocks, of either byte order; value = VResolution x sample + VOffset. Names stand in messages. Throws BadInput,
/// one sentence.
CsvTable parse_wvf(std::string_view header, std::string_view data, const std::string& header_file,
                   const std::string& data_file);

}  // namespace powbench::host
