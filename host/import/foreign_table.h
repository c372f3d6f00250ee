#pragma once

#include <filesystem>
#include <string>
#include <string_view>

#include "host/config/csv_table.h"

/// Any waveform file as columns of numbers, whatever wrote it.

namespace powbench::host {

/// By the bytes, then by the ending of `file`: TDMS, MAT 5, WAV, LVM, CSV of an oscilloscope, CSV with a header line.
/// Not those that need a second file. Throws BadInput.
CsvTable parse_table(std::string_view bytes, const std::string& file);

/// Also COMTRADE (x.cfg, x.dat, x.cff) and Yokogawa (x.hdr, x.wvf), with the file beside. Throws BadInput.
CsvTable read_table(const std::filesystem::path&);

/// All bytes of a file; throws BadInput where it cannot be read.
std::string whole_file(const std::filesystem::path&);

}  // namespace powbench::host
