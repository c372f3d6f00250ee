#pragma once

#include <string_view>
#include <vector>

/// The rules of the house as data: which folder may include which, and where a third-party header may appear.
/// docs/explain/architecture.md explains them; this table is what the tests enforce.

namespace powbench::architecture {

/// A top-level folder with C++ sources. `may_include` lists other folders; a folder may always include
/// itself.
struct Folder {
  std::string_view name;
  std::vector<std::string_view> may_include;
  bool pure = false;         ///< no files, no streams, no operating system
  bool third_party = false;  ///< any third-party header is welcome (tests and benchmarks with their peers)
};

/// Where the headers of one library may be included: in files whose path starts with `where`. The path of a
/// single file names that file alone.
struct Allowance {
  std::string_view header;   ///< beginning of the name between the angle brackets
  std::string_view where;    ///< beginning of the path of the including file
  bool sources_only;         ///< in .cpp files only
  std::string_view library;  ///< name in docs/reference/dependencies.md
};

inline const std::vector<Folder>& folders() {
  static const std::vector<Folder> table{
      {"core", {}, true, false},
      {"firmware", {"core"}, true, false},
      {"dsp", {"core"}, true, false},
      {"sim", {"core"}, true, false},
      {"fmu", {"core", "sim"}, false, false},
      {"rigs", {"core", "sim", "firmware"}, false, false},
      {"host", {"core", "dsp", "sim", "fmu", "rigs"}, false, false},
      {"python", {"core", "dsp", "sim", "rigs", "host"}, false, false},
      {"bench", {"core", "firmware", "dsp", "sim", "rigs", "host"}, false, true},
      {"tests", {"core", "firmware", "dsp", "sim", "fmu", "rigs", "host", "bench"}, false, true},
  };
  return table;
}

inline const std::vector<Allowance>& allowances() {
  static const std::vector<Allowance> table{
      {"Eigen/", "dsp/", true, "Eigen"},
      {"Eigen/", "sim/", true, "Eigen"},
      {"thread", "sim/team.cpp", true, "standard library"},
      {"cholmod.h", "sim/magnetics/plane/cholmod.h", false, "SuiteSparse"},
      {"dlfcn.h", "core/late_library.h", false, "standard library"},
      {"malloc.h", "core/memory.h", false, "standard library"},
      {"fftw3.h", "dsp/signal/fft.cpp", true, "FFTW"},
      {"iio.h", "rigs/iio_link.cpp", true, "libiio"},
      {"boost/asio", "rigs/iiod_server.cpp", true, "Boost.Asio"},
      {"boost/asio", "rigs/bridge/", false, "Boost.Asio"},
      {"boost/asio", "host/serve/http.cpp", true, "Boost.Asio"},
      {"boost/beast", "host/serve/http.cpp", true, "Boost.Beast"},
      {"boost/math", "core/normal.h", false, "Boost.Math"},
      {"boost/math", "host/compare/student.cpp", true, "Boost.Math"},
      {"sqlite3.h", "host/store/", false, "SQLite"},
      {"libpq-fe.h", "host/store/central/pq.h", false, "libpq"},
      {"pugixml.hpp", "host/import/dcc.cpp", true, "pugixml"},
      {"zlib.h", "host/import/mat5.cpp", true, "zlib"},
      {"zlib.h", "host/export/zip.cpp", true, "zlib"},
      {"hdf5", "host/export/hdf5.h", false, "HDF5"},
      {"toml++/", "host/config/", true, "toml++"},
      {"CLI/", "host/", true, "CLI11"},
      {"CLI/", "host/cli/commands.h", false, "CLI11"},
      {"nlohmann/", "host/", true, "nlohmann-json"},
      {"fmt/", "host/", true, "fmt"},
      {"openssl/", "host/", true, "OpenSSL"},
      {"pybind11/", "python/", true, "pybind11"},
  };
  return table;
}

/// Standard headers that bring the heap, exceptions or the operating system: out of reach of the firmware,
/// also through the core headers it includes.
inline const std::vector<std::string_view>& hosted_headers() {
  static const std::vector<std::string_view> table{
      "string", "vector", "map",        "set",      "unordered_map", "unordered_set", "deque",  "list",
      "memory", "thread", "stdexcept",  "iostream", "sstream",       "fstream",       "future", "filesystem",
      "mutex",  "chrono", "functional", "regex",    "format",        "cstdio",        "any",    "locale"};
  return table;
}

/// Standard headers a pure folder does without.
inline const std::vector<std::string_view>& file_headers() {
  static const std::vector<std::string_view> table{"fstream", "iostream", "filesystem",
                                                   "thread",  "future",   "chrono"};
  return table;
}

/// Headers that the build makes from other files; they are included like any other.
inline const std::vector<std::string_view>& generated_headers() {
  static const std::vector<std::string_view> table{"host/store/migrations.h",
                                                   "host/store/central/migrations.h", "host/cli/scenes.h",
                                                   "host/report/closer_assets.h", "host/serve/page_assets.h"};
  return table;
}

/// What a test may not use: its outcome would depend on how fast the machine is. A test waits for what it is about,
/// with the one helper that may read a clock.
inline const std::vector<std::string_view>& clock_words() {
  static const std::vector<std::string_view> table{"sleep_for",     "sleep_until",           "usleep",
                                                   "nanosleep",     "steady_clock",          "system_clock",
                                                   "wait_for",      "clock_gettime",         "gettimeofday",
                                                   "machine_clock", "high_resolution_clock", "std::time",
                                                   "time(nullptr)"};
  return table;
}
inline constexpr std::string_view waiting_helper = "tests/waiting.h";

/// The portable part of the firmware: everything but the ports.
inline constexpr std::string_view portable_firmware = "firmware/";
inline constexpr std::string_view firmware_ports = "firmware/port/";

/// A rule that stands in one file of the product: its text, and where.
struct SaidOnce {
  std::string_view text, where;
};
inline const std::vector<SaidOnce>& said_once() {
  static const std::vector<SaidOnce> table{{"polarity < 0", "core/commanded_phase.h"}};
  return table;
}

/// Functions that no product source names: start-up code in assembler or a macro at the beginning of a line calls them.
inline const std::vector<std::string_view>& called_from_outside() {
  static const std::vector<std::string_view> table{"hold_gate_low", "POWBENCH_CELL_KERNEL",
                                                   "POWBENCH_CONTACT_KERNEL"};
  return table;
}

/// What tests and benchmarks alone reach. The lists may only become shorter: a new name fails a test, and so does one
/// that is gone or has found a use.
inline const std::vector<std::string_view>& unreached_files() {
  static const std::vector<std::string_view> table{};
  return table;
}
inline const std::vector<std::string_view>& unreached_functions() {
  static const std::vector<std::string_view> table{"add_box",
                                                   "ask_energies",
                                                   "can_write_netcdf",
                                                   "cholesky",
                                                   "coherence",
                                                   "design_zpk",
                                                   "fix",
                                                   "follow_depths",
                                                   "forward_frames",
                                                   "held_samples",
                                                   "import_waveform",
                                                   "limit_pages",
                                                   "line_errors",
                                                   "map_nodes",
                                                   "node_pressure",
                                                   "parse_calibration",
                                                   "restore",
                                                   "run_until",
                                                   "scheduled",
                                                   "send_raw",
                                                   "set_velocity",
                                                   "steady_current",
                                                   "store_events",
                                                   "twin_condition",
                                                   "zero_phase_frames"};
  return table;
}

/// Folders in an order: a file may include none of a later one.
inline const std::vector<std::string_view>& dsp_order() {
  static const std::vector<std::string_view> table{"dsp/signal", "dsp/filter", "dsp/vibration",
                                                   "dsp/contacts", "dsp/events"};
  return table;
}

inline const std::vector<std::string_view>& sim_order() {
  static const std::vector<std::string_view> table{"sim/magnetics/circuit",
                                                   "sim/magnetics/table",
                                                   "sim/magnetics/plane",
                                                   "sim/magnetics/space",
                                                   "sim/specimen",
                                                   "sim/supply",
                                                   "sim/mechanics",
                                                   "sim/solid",
                                                   "sim/models",
                                                   "sim/study"};
  return table;
}

inline constexpr int longest_file = 400;  ///< lines
inline constexpr int widest_line = 120;   ///< characters

}  // namespace powbench::architecture
