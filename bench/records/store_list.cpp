#include <fmt/format.h>
#include <unistd.h>

#include <algorithm>
#include <filesystem>
#include <fstream>
#include <nlohmann/json.hpp>

#include "bench/dsp_rig_truth.h"
#include "core/cpu_time.h"
#include "core/random.h"
#include "core/units.h"
#include "dsp/events/extract.h"
#include "host/store/store.h"

/// What a list, a query for one shot and its events cost in stores of many shots: CPU seconds with the opening of the
/// store, all seals checked. Events are whole, records short (a list reads none).
/// Usage: bench_store_list [--json PATH] [SHOTS...]   (1000, 20 000 and 100 000 if left out)

namespace {

using namespace powbench;
using namespace powbench::host;

void fill(const std::string& path, int shots) {
  Store store(path);
  CampaignInfo info;
  info.name = "list";
  info.origin = Origin::simulated_rig;
  const std::int64_t campaign = store.create_campaign(info);
  std::vector<std::pair<Record, Events>> made;
  for (int i = 0; i < 6; ++i) {
    Record r = bench::rig_record(100e3, radians(60.0 * i), 50.0, static_cast<std::uint64_t>(i)).record;
    Events e = dsp::extract_events(r, {});
    for (ChannelRecord& c : r.channels) c.raw.resize(64);
    made.emplace_back(std::move(r), std::move(e));
  }
  Random random(1);
  for (int i = 0; i < shots; ++i) {
    auto& [record, events] = made[static_cast<std::size_t>(i) % made.size()];
    StoredShot shot;
    shot.campaign = campaign;
    shot.number = i;
    shot.conditions = record.conditions;
    shot.angle_deg = 60.0 * (i % 6);
    shot.outcome = Outcome::pass;
    shot.started = "2026-01-01T00:00:00Z";
    Events moved = events;
    moved.contact_voltage.bounce_time.value += 20e-6 * random.normal();
    store.store_shot(shot, &record, &moved, {"p", "0"});
  }
}

template <class F>
double median_cost(F&& call) {
  std::vector<double> s;
  for (int i = 0; i < 7; ++i) {
    const double from = thread_cpu_seconds();
    call();
    s.push_back(thread_cpu_seconds() - from);
  }
  std::nth_element(s.begin(), s.begin() + 3, s.end());
  return s[3];
}

}  // namespace

int main(int argc, char** argv) {
  std::vector<int> sizes;
  std::string json;
  for (int i = 1; i < argc; ++i) {
    if (std::string(argv[i]) == "--json" && i + 1 < argc)
      json = argv[++i];
    else
      sizes.push_back(std::atoi(argv[i]));
  }
  if (sizes.empty()) sizes = {1000, 20'000, 100'000};
  fmt::print(
      "CPU seconds with the opening of the store, medians of 7; all seals of the rows read are checked\n\n");
  fmt::print("{:>8} {:>9} {:>8} {:>8} {:>14} {:>22}\n", "shots", "MB", "list", "one shot", "events of one",
             "events of all, by one");
  nlohmann::ordered_json rows = nlohmann::ordered_json::array();
  const std::string path =
      (std::filesystem::temp_directory_path() / fmt::format("bench-list-{}.db", getpid())).string();
  for (const int shots : sizes) {
    fill(path, shots);
    std::size_t listed = 0;
    const double list = median_cost([&] { listed = Store(path, Store::Mode::read_only).lines(1).size(); });
    if (listed != static_cast<std::size_t>(shots)) return 1;
    const double one = median_cost([&] { Store(path, Store::Mode::read_only).shot(shots / 2); });
    const double events = median_cost([&] { Store(path, Store::Mode::read_only).load_events(shots / 2); });
    const double from = thread_cpu_seconds();
    const Store store(path, Store::Mode::read_only);
    for (int i = 1; i <= shots; ++i) store.load_events(i);
    const double all = thread_cpu_seconds() - from;
    const double megabytes = static_cast<double>(std::filesystem::file_size(path)) / 1e6;
    fmt::print("{:>8} {:>9.0f} {:>8.3f} {:>8.3f} {:>14.3f} {:>22.1f}\n", shots, megabytes, list, one, events,
               all);
    rows.push_back({{"shots", shots},
                    {"MB", megabytes},
                    {"list_s", list},
                    {"shot_s", one},
                    {"events_s", events},
                    {"all_events_s", all}});
    std::filesystem::remove(path);
  }
  if (!json.empty()) std::ofstream(json) << nlohmann::ordered_json{{"rows", rows}}.dump(2) << '\n';
  return 0;
}
