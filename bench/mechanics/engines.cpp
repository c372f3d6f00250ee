// The two rigid engines on the same closings of the reference specimen, 60 ms: error against CPU time. Errors are
// median and largest of 120 angles against the plant at 1e-13: where steps happen to fall makes one error ten times
// another. CPU is the median of the repeats, each time of six angles, the rows by turns. `sampled`: with a sample
// every 20 us, as the simulated rig asks for.
//   bench_mechanics_engines [--json PATH] [--repeats N]

#include <algorithm>
#include <cmath>
#include <cstdio>
#include <cstdlib>
#include <cstring>
#include <ctime>
#include <fstream>
#include <functional>
#include <nlohmann/json.hpp>
#include <vector>

#include "sim/models/rigid_closing.h"

namespace {

using powbench::Conditions;
namespace sim = powbench::sim;

constexpr double duration = 0.06;
constexpr double sample_dt = 20e-6;

struct Row {
  const char* engine;
  double tolerance = 0;
  std::function<sim::Trajectory(const Conditions&, double dt)> run;
  std::vector<double> touch{}, settled{};  ///< s, errors
  double evaluations = 0;
  std::vector<double> plain{}, sampled{};  ///< ms
};

std::vector<Conditions> shots(int count) {
  std::vector<Conditions> all;
  for (int k = 1; k <= count; ++k) {
    Conditions c;
    c.closing_angle = powbench::radians(180.0 * k / count);
    all.push_back(c);
  }
  return all;
}

double cpu_ms(const Row& row, double dt) {
  const std::clock_t start = std::clock();
  constexpr int timed = 6;
  for (const auto& c : shots(timed)) row.run(c, dt);
  return 1e3 * static_cast<double>(std::clock() - start) / CLOCKS_PER_SEC / timed;
}

double median(std::vector<double> v) {
  std::nth_element(v.begin(), v.begin() + static_cast<std::ptrdiff_t>(v.size() / 2), v.end());
  return v[v.size() / 2];
}

std::vector<Row> rows() {
  std::vector<Row> all;
  for (const double tol : {1e-6, 1e-7, 1e-8})
    all.push_back({"plant", tol,
                   [=](const Conditions& c, double dt) { return sim::simulate({}, c, duration, dt, tol); }});
  for (const bool ledger : {false, true})
    for (const double tol : {1e-6, 1e-7, 1e-8})
      all.push_back({ledger ? "rigid, ledger" : "rigid", tol, [=](const Conditions& c, double dt) {
                       return sim::simulate_rigid({}, c, duration, dt, tol, ledger);
                     }});
  return all;
}

}  // namespace

int main(int argc, char** argv) {
  const char* json = nullptr;
  int repeats = 9;
  for (int i = 1; i + 1 < argc; i += 2) {
    if (std::strcmp(argv[i], "--json") == 0) json = argv[i + 1];
    if (std::strcmp(argv[i], "--repeats") == 0) repeats = std::max(1, std::atoi(argv[i + 1]));
  }
  auto all = rows();
  constexpr int judged = 120;
  for (const auto& c : shots(judged)) {
    const auto truth = sim::simulate({}, c, duration, 0, 1e-13).truth;
    for (auto& row : all) {
      const auto r = row.run(c, 0);
      row.touch.push_back(1e6 * std::fabs(*r.truth.touch - *truth.touch));
      row.settled.push_back(1e6 * std::fabs(*r.truth.settled - *truth.settled));
      row.evaluations += static_cast<double>(r.evaluations) / judged;
    }
  }
  for (int r = 0; r < repeats; ++r)
    for (auto& row : all) {
      row.plain.push_back(cpu_ms(row, 0));
      row.sampled.push_back(cpu_ms(row, sample_dt));
    }
  std::printf(
      "engine         tolerance   touch us: median, largest   settled us             rhs   CPU ms  sampled "
      "ms\n");
  auto list = nlohmann::ordered_json::array();
  for (const auto& row : all) {
    const double worst[] = {*std::max_element(row.touch.begin(), row.touch.end()),
                            *std::max_element(row.settled.begin(), row.settled.end())};
    std::printf("%-14s %9.0e   %7.1e  %7.1e            %7.1e  %7.1e  %6.0f  %7.3f  %10.3f\n", row.engine,
                row.tolerance, median(row.touch), worst[0], median(row.settled), worst[1], row.evaluations,
                median(row.plain), median(row.sampled));
    list.push_back({{"engine", row.engine},
                    {"tolerance", row.tolerance},
                    {"touch_us", {median(row.touch), worst[0]}},
                    {"settled_us", {median(row.settled), worst[1]}},
                    {"rhs", row.evaluations},
                    {"cpu_ms", median(row.plain)},
                    {"sampled_cpu_ms", median(row.sampled)}});
  }
  if (json != nullptr) std::ofstream(json) << nlohmann::ordered_json{{"rows", list}}.dump(2) << '\n';
  return 0;
}
