#pragma once

#include <string>
#include <string_view>

#include "host/config/csv_table.h"

/// MAT-files of level 5, as MATLAB (-v6, -v7), Octave, scipy and oscilloscopes write them.

namespace powbench::host {

/// Columns `time [s]`, `NAME [V]`, ... from the real numeric vectors that are as long as the longest one; the columns
/// of a matrix are NAME_1, NAME_2, ... Fields of 1 x 1 structures count as variables `STRUCT.FIELD`. The time is the
/// vector called time, t, x, ...; else the scalars Tinterval (dt, Ts, or fs, Fs) and Tstart (t0). MAT states no
/// units: V, unless the name ends in one (`force_N`). Throws BadInput, one sentence: HDF5 (-v7.3), level 4, no
/// vectors, no clock, a cut or damaged file.
CsvTable parse_mat(std::string_view bytes, const std::string& file);

}  // namespace powbench::host
