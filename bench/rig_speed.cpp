#include <fmt/format.h>
#include <iio.h>

#include <algorithm>
#include <chrono>
#include <cmath>
#include <fstream>
#include <nlohmann/json.hpp>
#include <string>
#include <vector>

#include "core/cpu_time.h"
#include "core/phase.h"
#include "dsp/events/extract.h"
#include "rigs/iiod_server.h"
#include "rigs/registry.h"
#include "rigs/simulated_record.h"

/// How fast the path from a fired shot to its events is: simulation, shots through libiio, attribute round trip, refill
/// rate at several refill sizes, extraction. Medians over repeats; the machine's noise shows in the quartiles.
/// Usage: bench_rig_speed [--json PATH]

namespace {

using namespace powbench;

double wall() {
  return std::chrono::duration<double>(std::chrono::steady_clock::now().time_since_epoch()).count();
}
struct Row {
  std::string what, unit, goal;
  double median, low, high;
};

template <class F>
std::vector<double> repeat(int n, F&& once) {
  std::vector<double> values;
  for (int i = 0; i < n; ++i) values.push_back(once(i));
  std::sort(values.begin(), values.end());
  return values;
}

Row row(std::string what, std::string unit, std::string goal, const std::vector<double>& v) {
  return {std::move(what), std::move(unit), std::move(goal),
          v[v.size() / 2], v[v.size() / 4], v[v.size() * 3 / 4]};
}

Conditions conditions(int i) {
  Conditions c;
  c.closing_angle = radians(30.0 * (i % 7));
  c.seed = static_cast<std::uint64_t>(i) + 1;
  return c;
}

/// Bytes per second of reading the whole record in refills of `scans`, over the wire.
double refill_rate(const std::string& uri, std::size_t scans) {
  std::string copy = uri;
  iio_context* context = iio_create_context_from_uri(copy.data());
  iio_device* daq = iio_context_find_device(context, "contactor-daq");
  for (std::size_t c = 0; c < channel_count; ++c)
    iio_channel_enable(iio_device_find_channel(daq, std::string(channel_table[c].iio_id).c_str(), false));
  iio_buffer* buffer = iio_device_create_buffer(daq, scans, false);
  const double start = wall();
  double bytes = 0;
  for (std::size_t done = 0; done + scans <= 14'000; done += scans) {
    const auto n = iio_buffer_refill(buffer);
    if (n <= 0) break;
    bytes += static_cast<double>(n);
  }
  const double seconds = wall() - start;
  iio_buffer_destroy(buffer);
  iio_context_destroy(context);
  return bytes / seconds;
}

std::vector<double> attribute_round_trips(const std::string& uri) {
  std::string copy = uri;
  iio_context* context = iio_create_context_from_uri(copy.data());
  iio_device* control = iio_context_find_device(context, "contactor-ctl");
  char text[64];
  auto times = repeat(2000, [&](int) {
    const double start = wall();
    iio_device_attr_read(control, "state", text, sizeof text);
    return 1e6 * (wall() - start);
  });
  iio_context_destroy(context);
  return times;
}

void print(const std::vector<Row>& rows, const std::string& json) {
  fmt::print("{:<46} {:>10} {:>10} {:>10}  {:<8} {}\n", "", "median", "quartile", "quartile", "unit", "goal");
  auto list = nlohmann::ordered_json::array();
  for (const Row& r : rows) {
    fmt::print("{:<46} {:>10.4g} {:>10.4g} {:>10.4g}  {:<8} {}\n", r.what, r.median, r.low, r.high, r.unit,
               r.goal);
    list.push_back({{"what", r.what},
                    {"unit", r.unit},
                    {"goal", r.goal},
                    {"median", r.median},
                    {"low", r.low},
                    {"high", r.high}});
  }
  if (!json.empty()) std::ofstream(json) << list.dump(2) << "\n";
}

}  // namespace

int main(int argc, char** argv) {
  const std::string json = argc == 3 && std::string(argv[1]) == "--json" ? argv[2] : "";
  const rigs::SimRigConfig config;
  const sim::Specimen specimen;
  std::vector<Row> rows;

  // the simulator alone, as the goal states it: 60 ms of closing
  rows.push_back(row("simulated closing of 60 ms, plant alone, CPU", "ms", "<= 10", repeat(35, [&](int i) {
                       const double start = process_cpu_seconds();
                       sim::simulate(specimen, conditions(i), 0.060, 0.0);
                       return 1e3 * (process_cpu_seconds() - start);
                     })));
  // record of 140 ms through the virtual sensors
  rows.push_back(row("record of 140 ms with sensors, real-time factor", "x", "", repeat(35, [&](int i) {
                       const double start = process_cpu_seconds();
                       rigs::simulate_record(specimen, conditions(i), config);
                       return 0.140 / (process_cpu_seconds() - start);
                     })));

  rigs::LocalRig server(config, specimen);
  const std::string uri = "ip:" + server.address();
  const auto rig = rigs::open(uri, config, specimen);
  Record record;
  rows.push_back(row("shots through libiio, end to end", "1/s", ">= 10", repeat(70, [&](int i) {
                       const double start = wall();
                       record = rig->fire(conditions(i), std::chrono::seconds(10)).record;
                       return 1.0 / (wall() - start);
                     })));
  rows.push_back(row("shots through libiio and their events", "1/s", ">= 10", repeat(70, [&](int i) {
                       const double start = wall();
                       dsp::extract_events(rig->fire(conditions(i), std::chrono::seconds(10)).record);
                       return 1.0 / (wall() - start);
                     })));
  rows.push_back(row("events of one record, CPU", "ms", "<= 50", repeat(35, [&](int) {
                       const double start = process_cpu_seconds();
                       dsp::extract_events(record);
                       return 1e3 * (process_cpu_seconds() - start);
                     })));
  rows.push_back(row("attribute round trip", "us", "", attribute_round_trips(uri)));
  for (const std::size_t scans : {64U, 256U, 1000U, 3500U, 14000U})
    rows.push_back(row(fmt::format("refill rate, {} scans of 16 B", scans), "MB/s",
                       scans == 256 ? "> 1.6" : "",
                       repeat(15, [&](int) { return 1e-6 * refill_rate(uri, scans); })));
  print(rows, json);
  return 0;
}
