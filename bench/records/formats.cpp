#include <fmt/format.h>
#include <unistd.h>

#include <algorithm>
#include <filesystem>
#include <fstream>
#include <functional>
#include <nlohmann/json.hpp>

#include "bench/dsp_rig_truth.h"
#include "bench/records/foreign_samples.h"
#include "core/cpu_time.h"
#include "core/units.h"
#include "host/export/csv.h"
#include "host/export/event_table.h"
#include "host/export/waveforms.h"
#include "host/import/foreign_table.h"
#include "host/import/wvf.h"
#include "host/store/store.h"

/// Every format's rate, read and write, in MB of the file a CPU second, beside a plain copy of a file of that size;
/// and samples a second. Files stand in memory (/dev/shm) where the machine has that.
/// Usage: bench_formats [--json PATH]

namespace {

using namespace powbench;
using namespace powbench::host;
namespace fs = std::filesystem;

template <class F>
double cost(F&& call) {
  std::vector<double> s;
  for (int i = 0; i < 5; ++i) {
    const double from = thread_cpu_seconds();
    call();
    s.push_back(thread_cpu_seconds() - from);
  }
  std::nth_element(s.begin(), s.begin() + 2, s.end());
  return s[2];
}

void write_file(const fs::path& path, const std::string& bytes) {
  std::ofstream(path, std::ios::binary).write(bytes.data(), static_cast<std::streamsize>(bytes.size()));
}

struct Rows {
  fs::path folder;
  nlohmann::ordered_json json = nlohmann::ordered_json::array();

  /// `samples` in the file; `act` reads or writes it.
  void add(const std::string& what, const std::string& way, const fs::path& file, double samples,
           const std::function<void()>& act) {
    const double seconds = cost(act);
    const auto size = static_cast<double>(fs::file_size(file));
    const fs::path copy = folder / "copy";
    const double plain = cost([&] { fs::remove(copy), write_file(copy, whole_file(file)); });
    fmt::print("{:<36} {:<6} {:>8.2f} {:>9.1f} {:>12.1f} {:>10.1f}\n", what, way, size / 1e6,
               size / seconds / 1e6, samples / seconds / 1e6, seconds / plain);
    json.push_back({{"format", what},
                    {"way", way},
                    {"MB", size / 1e6},
                    {"MB_per_s", size / seconds / 1e6},
                    {"Msamples_per_s", samples / seconds / 1e6},
                    {"over_copy", seconds / plain}});
  }
};

/// A store of one shot after the other; read back.
void bench_store(Rows& rows, const Record& r, double samples) {
  // the file beside which it is measured: the bare samples
  const fs::path file = rows.folder / "bare";
  write_file(file, std::string(2 * static_cast<std::size_t>(samples), 'x'));
  Store store((rows.folder / "x.db").string());
  StoredShot shot;
  shot.campaign = store.create_campaign({});
  shot.outcome = Outcome::pass;
  rows.add("store, a shot (transaction and flush)", "write", file, samples, [&] {
    shot.number += 1;
    store.store_shot(shot, &r, nullptr, {});
  });
  rows.add("store, a shot (hash checked)", "read", file, samples, [&] { store.load_record(1); });
}

}  // namespace

int main(int argc, char** argv) {
  const fs::path memory = fs::is_directory("/dev/shm") ? fs::path("/dev/shm") : fs::temp_directory_path();
  Rows rows{memory / fmt::format("bench-formats-{}", getpid()), {}};
  rows.json = nlohmann::ordered_json::array();
  fs::create_directories(rows.folder);
  fmt::print("{:<36} {:<6} {:>8} {:>9} {:>12} {:>10}\n", "format", "", "MB", "MB/s", "Msamples/s",
             "time/copy");
  const Record r = bench::rig_record(100e3, radians(30.0), 50.0, 1).record;
  const double samples = static_cast<double>(r.samples() * r.channels.size());
  const auto in = [&](const char* name) { return rows.folder / name; };
  rows.add("CSV, 8 channels", "write", (write_file(in("x.csv"), to_csv(r)), in("x.csv")), samples,
           [&] { write_file(in("x.csv"), to_csv(r)); });
  rows.add("CSV, 8 channels", "read", in("x.csv"), samples, [&] { read_table(in("x.csv")); });
  const auto comtrade = [&] {
    const ComtradeText t = to_comtrade(r, "bench");
    write_file(in("x.cfg"), t.configuration), write_file(in("x.dat"), t.data);
  };
  comtrade();
  rows.add("COMTRADE, 8 channels", "write", in("x.dat"), samples, comtrade);
  rows.add("COMTRADE, 8 channels", "read", in("x.dat"), samples, [&] { read_table(in("x.cfg")); });
  if (can_write_netcdf()) {
    write_netcdf(r, {}, in("x.nc"));
    rows.add("netCDF-4, 8 channels and counts", "write", in("x.nc"), samples,
             [&] { write_netcdf(r, {}, in("x.nc")); });
  }
  const auto xlsx = [&] { write_file(in("x.xlsx"), to_xlsx({{"record", waveform_table(r)}})); };
  xlsx();
  rows.add("xlsx, 8 channels", "write", in("x.xlsx"), samples, xlsx);
  const auto arrow = [&] { write_file(in("x.arrow"), to_arrow(waveform_table(r))); };
  arrow();
  rows.add("Arrow IPC, 8 columns", "write", in("x.arrow"), samples, arrow);
  bench_store(rows, r, samples);

  const Waves w = waves(1, 200'000);
  for (const auto& list : {scope_texts(w), binary_files(w), logger_files(w)})
    for (const Foreign& f : list) {
      const fs::path file = in(f.file.c_str());
      write_file(file, f.bytes);
      if (!f.header.empty()) write_file(in("x.hdr"), f.header);
      rows.add(f.name, "read", file, f.channels * 200e3, [&] { read_table(file); });
      fs::remove(file);
    }
  fs::remove_all(rows.folder);
  if (argc == 3 && std::string(argv[1]) == "--json")
    std::ofstream(argv[2]) << nlohmann::ordered_json{{"rows", rows.json}}.dump(2) << '\n';
  return 0;
}
