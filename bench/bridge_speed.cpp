#include <fmt/format.h>
#include <iio.h>

#include <algorithm>
#include <atomic>
#include <chrono>
#include <fstream>
#include <nlohmann/json.hpp>
#include <stdexcept>
#include <string>
#include <thread>
#include <vector>

#include "bench/uart_board.h"
#include "core/phase.h"
#include "rigs/bridge/bridge.h"
#include "rigs/registry.h"

/// A whole shot over a paced serial line: how long it takes beside what the line alone needs for the record
/// (10 bits a byte), and how long a second client waits for an attribute, on an idle line and while a record
/// is on it.
/// Usage: bench_bridge_speed [--json PATH]

namespace {

using namespace powbench;
using Clock = std::chrono::steady_clock;

double seconds_since(Clock::time_point start) {
  return std::chrono::duration<double>(Clock::now() - start).count();
}

double median(std::vector<double> v) {
  std::sort(v.begin(), v.end());
  return v.empty() ? 0.0 : v[v.size() / 2];
}

struct Row {
  unsigned baud;
  double line, shot, least, most;  // s
  double idle, loaded, worst;      // s
};

Conditions conditions(int i) {
  Conditions c;
  c.closing_angle = radians(45.0 * i);
  c.seed = static_cast<std::uint64_t>(i) + 1;
  return c;
}

/// Time of a shot through `rig`, s: commands, virtual closing and upload.
double shot_time(rigs::Rig& rig, int i) {
  const auto start = Clock::now();
  const rigs::Shot shot = rig.fire(conditions(i), std::chrono::seconds(60));
  if (shot.outcome != Outcome::pass) throw std::runtime_error("no record: " + shot.reason);
  return seconds_since(start);
}

/// A second client that does nothing but ask for the state, as a display would.
class Asker {
 public:
  explicit Asker(std::string uri) : context_(iio_create_context_from_uri(uri.data())) {
    if (context_) control_ = iio_context_find_device(context_, "contactor-ctl");
    if (!control_) throw std::runtime_error("no second client");
  }
  ~Asker() { iio_context_destroy(context_); }
  Asker(const Asker&) = delete;
  Asker& operator=(const Asker&) = delete;

  /// Round trips, s, until `enough`.
  template <class F>
  std::vector<double> ask_until(F&& enough) {
    std::vector<double> times;
    char text[64];
    while (!enough(times.size())) {
      const auto start = Clock::now();
      iio_device_attr_read(control_, "state", text, sizeof text);
      times.push_back(seconds_since(start));
      std::this_thread::sleep_for(std::chrono::milliseconds(50));
    }
    return times;
  }

 private:
  iio_context* context_;
  iio_device* control_ = nullptr;
};

Row measure(unsigned baud, int repeats) {
  const rigs::SimRigConfig config;  // 140 ms of eight channels: 224 000 bytes
  bench::UartBoard board(config, {}, baud);
  rigs::BridgeOptions options;
  options.port = board.port();
  options.baud = baud;
  rigs::LocalBridge bridge(options);
  const std::string uri = "ip:" + bridge.address();
  const auto rig = rigs::open(uri, config, {});
  std::vector<double> times;
  for (int i = 0; i < repeats; ++i) times.push_back(shot_time(*rig, i));

  Asker asker(uri);
  const auto idle = asker.ask_until([](std::size_t n) { return n == 20; });
  std::atomic<bool> done = false;
  std::vector<double> loaded;
  std::thread display([&] { loaded = asker.ask_until([&](std::size_t) { return done.load(); }); });
  shot_time(*rig, 0);
  done = true;
  display.join();

  const double bytes = config.record_length * config.sample_rate * 2 * channel_count;
  std::sort(times.begin(), times.end());
  return {baud,         10.0 * bytes / baud, median(times),  times.front(),
          times.back(), median(idle),        median(loaded), *std::max_element(loaded.begin(), loaded.end())};
}

}  // namespace

int main(int argc, char** argv) {
  const std::string json = argc == 3 && std::string(argv[1]) == "--json" ? argv[2] : "";
  auto list = nlohmann::ordered_json::array();
  const auto direct = rigs::open("sim:", {}, {});
  std::vector<double> times;
  for (int i = 0; i < 15; ++i) times.push_back(shot_time(*direct, i));
  fmt::print("a shot with a record of 224 000 bytes; without a line it takes {:.3f} s\n", median(times));
  fmt::print("{:>9} {:>8} {:>8} {:>8} {:>8} {:>10} {:>8} {:>9} {:>8}\n", "", "line", "shot", "least", "most",
             "shot/line", "idle", "uploading", "worst");
  fmt::print("{:>9} {:>8} {:>8} {:>8} {:>8} {:>10} {:>8} {:>9} {:>8}\n", "baud", "s", "s", "s", "s", "", "ms",
             "ms", "ms");
  for (const unsigned baud : {115'200U, 921'600U, 2'000'000U}) {
    const Row r = measure(baud, baud < 500'000 ? 1 : 7);
    fmt::print("{:>9} {:>8.3f} {:>8.3f} {:>8.3f} {:>8.3f} {:>10.3f} {:>8.2f} {:>9.1f} {:>8.1f}\n", r.baud,
               r.line, r.shot, r.least, r.most, r.shot / r.line, 1e3 * r.idle, 1e3 * r.loaded, 1e3 * r.worst);
    list.push_back({{"baud", r.baud},
                    {"line_s", r.line},
                    {"shot_s", r.shot},
                    {"least_s", r.least},
                    {"most_s", r.most},
                    {"attribute_idle_ms", 1e3 * r.idle},
                    {"attribute_uploading_ms", 1e3 * r.loaded},
                    {"attribute_worst_ms", 1e3 * r.worst}});
  }
  fmt::print("idle, uploading, worst: an attribute asked for by a second client (median, median, longest)\n");
  if (!json.empty()) std::ofstream(json) << list.dump(2) << "\n";
  return 0;
}
