// What it takes to predict a bounce: synthetic devices over the catalogue's bounds, by a model that is not the
// one that is fitted and by the fitted one; campaigns of 5 to 48 angles with several channels; the fit's
// prediction of bounce at other angles beside rules without a model, and the floor that the scatter of bounce
// itself sets.
//   bench_bounce_evidence [--devices N] [--samples N] [--sets 1..5] [--model other|fitted] [--seed S]
//       [--threads N] [--json PATH]
// --samples 0: rules alone, 4 s a device in place of 20.

#include <algorithm>
#include <cmath>
#include <cstdio>
#include <cstdlib>
#include <cstring>
#include <fstream>
#include <nlohmann/json.hpp>
#include <string>

#include "bench/study/evidence_device.h"
#include "core/cpu_time.h"
#include "sim/team.h"

namespace {

using namespace powbench;
using namespace powbench::bench;

using Json = nlohmann::ordered_json;

/// Over the devices.
struct Mean {
  double value = 0, error = 0;
  explicit Mean(const std::vector<double>& list) {
    double squares = 0, n = 0;
    for (const double v : list)
      if (std::isfinite(v)) value += v, squares += v * v, n += 1;
    value = n > 0 ? value / n : std::nan("");
    error = n > 1 ? std::sqrt(std::max(0.0, (squares / n - value * value) / (n - 1))) : std::nan("");
  }
  std::string percent() const {
    char text[64];
    std::snprintf(text, sizeof text, "%.1f(%.1f)", 100 * value, 100 * error);
    return text;
  }
};

using Table = std::vector<EvidenceRow> DeviceResult::*;

Json print_rows(const char* title, const std::vector<std::string>& columns,
                const std::vector<DeviceResult>& devices, Table table) {
  Json json = Json::array();
  if ((devices.front().*table).empty()) return json;
  std::printf("\n%s\n%-20s %-6s", title, "channels", "angles");
  for (const auto& c : columns) std::printf(" %10s", c.c_str());
  std::printf("\n");
  for (std::size_t r = 0; r < (devices.front().*table).size(); ++r) {
    const auto& first = (devices.front().*table)[r];
    Json row{{"channels", first.channels}, {"angles", first.angles}};
    std::printf("%-20s %-6s", first.channels.c_str(), first.angles.c_str());
    for (std::size_t c = 0; c < columns.size(); ++c) {
      std::vector<double> list;
      for (const auto& d : devices) list.push_back((d.*table)[r].cells[c]);
      const Mean mean(list);
      std::printf(" %10s", mean.percent().c_str());
      row[columns[c]] = {mean.value, mean.error};
    }
    std::printf("\n");
    json.push_back(row);
  }
  return json;
}

Json print_tables(const std::vector<DeviceResult>& list) {
  Json json;
  json["rules"] = print_rows("rules without a model", rule_columns(), list, &DeviceResult::rules);
  json["fits"] = print_rows("fits", fit_columns(), list, &DeviceResult::fits);
  json["seen"] = print_rows("the held-out closing is seen but for its bounce: line on", seen_columns(), list,
                            &DeviceResult::seen);
  return json;
}

}  // namespace

int main(int argc, char** argv) {
  EvidenceOptions options;
  int devices = 20, threads = 1;
  std::string path;
  for (int i = 1; i + 1 < argc; i += 2) {
    const auto is = [&](const char* name) { return std::strcmp(argv[i], name) == 0; };
    if (is("--devices")) devices = std::max(2, std::atoi(argv[i + 1]));
    if (is("--samples")) options.samples = std::max(0, std::atoi(argv[i + 1]));
    if (is("--sets")) options.sets = static_cast<std::size_t>(std::clamp(std::atoi(argv[i + 1]), 1, 5));
    if (is("--json")) path = argv[i + 1];
    if (is("--seed")) options.seed = std::strtoull(argv[i + 1], nullptr, 10);
    if (is("--threads")) threads = std::max(1, std::atoi(argv[i + 1]));
    if (is("--model")) options.model = std::strcmp(argv[i + 1], "fitted") == 0 ? Model::fitted : Model::other;
  }
  std::vector<DeviceResult> results(static_cast<std::size_t>(devices));
  sim::Team team(threads);
  sim::for_each_index(team, devices, [&](int k) {
    const double before = thread_cpu_seconds();
    auto& result = results[static_cast<std::size_t>(k)];
    result = study_device(options, k);
    result.cpu = thread_cpu_seconds() - before;
  });
  long tried = 0;
  double cpu = 0;
  std::vector<double> spread, bounce;
  for (const auto& r : results) {
    tried += r.tried;
    cpu += r.cpu;
    spread.push_back(r.spread);
    bounce.push_back(r.bounce * 10);  // ms, through a text in per cent
  }
  std::printf(
      "%d devices of the %s model, seed %llu, %ld drawn for them, %d posterior samples, %.0f s CPU\n"
      "median bounce of a device %s ms; its spread over the angle %s %% (rms of ln)\n"
      "Held-out bounce: mean |predicted - measured| / measured in %%, 100 at most; in brackets: standard "
      "error over "
      "the devices\n"
      "process: smooth over the angle, no model; fit: as `powbench fit` predicts; samples: without the plain "
      "median\n"
      "blend: process and median sample by posterior weight; less proc.: its error less that of the process; "
      "share: of the model in it\n"
      "band: bounces within 16 .. 84 %% of the prediction before; floor: median of the other shots at the "
      "very angle\n",
      devices, options.model == Model::other ? "other" : "fitted",
      static_cast<unsigned long long>(options.seed), tried, options.samples, cpu,
      Mean(bounce).percent().c_str(), Mean(spread).percent().c_str());
  Json json{{"devices", devices}, {"all", print_tables(results)}};
  std::sort(results.begin(), results.end(),
            [](const DeviceResult& a, const DeviceResult& b) { return a.spread < b.spread; });
  results.resize(results.size() / 2);
  std::printf("\n--- the half of the devices whose bounce differs least over the angle: up to %.1f %%\n",
              100 * results.back().spread);
  json["half"] = print_tables(results);
  if (!path.empty()) std::ofstream(path) << json.dump(1) << "\n";
  return 0;
}
