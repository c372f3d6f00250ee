#pragma once

#include <filesystem>
#include <string>
#include <string_view>

#include "host/config/csv_table.h"

/// WAV, as sound cards and mains recorders write it (RIFF: PCM of 8 to 32 bits, IEEE float of 32 or 64).

namespace powbench::host {

/// Columns `time [s]` from 0, then `ch1 [V]`, `ch2 [V]` ...: full scale is 1 V. Throws BadInput naming file, what is
/// wrong and what is allowed; a file that ends before its data is refused.
CsvTable parse_wav(std::string_view bytes, const std::string& file);

/// By its ending.
bool is_wav(const std::filesystem::path&);

}  // namespace powbench::host
