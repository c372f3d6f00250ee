#pragma once

/// The two data files of this folder, embedded by the build so that the program needs no file at run time.

namespace powbench::host {

extern const char* const closing_tables_csv;
extern const char* const contact_pressure_csv;

}  // namespace powbench::host
