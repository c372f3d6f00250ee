#pragma once

#include <filesystem>
#include <string>
#include <string_view>

#include "host/config/csv_table.h"

/// LVM, the text file of LabVIEW's measurements, with or without its headers.

namespace powbench::host {

/// Columns `time [s]`, then one a channel with its label and unit: `Force [N]`, `ch2 [V]`. Times from the first
/// column, or from X0 and Delta_X where the file has no such column. One segment; comments behind the channels are
/// passed over. Throws BadInput naming file, line, value and what is allowed.
CsvTable parse_lvm(std::string_view text, const std::string& file);

/// By its ending.
bool is_lvm(const std::filesystem::path&);

}  // namespace powbench::host
