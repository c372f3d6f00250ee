#include <algorithm>
#include <cstdlib>
#include <fstream>
#include <iostream>
#include <nlohmann/json.hpp>
#include <string>

#include "bench/fault_cases.h"

/// Every fault at every phase of the mains in every state of a shot: worst reaction time against its limit.
/// Usage: bench_fault_matrix [--json PATH] [--step DEGREES]

using namespace powbench;
using namespace powbench::bench;

int main(int argc, char** argv) {
  std::string json_path;
  int step = 1;
  for (int i = 1; i + 1 < argc; i += 2) {
    if (std::string(argv[i]) == "--json") json_path = argv[i + 1];
    if (std::string(argv[i]) == "--step") step = std::clamp(std::atoi(argv[i + 1]), 1, 360);
  }
  FaultCases cases;
  nlohmann::json rows = nlohmann::json::array();
  int failures = 0, total = 0;
  std::cout << "| fault | idle | armed | scheduled | energised | limit |\n|---|---|---|---|---|---|\n";
  for (const auto& row : firmware::fault_table) {
    nlohmann::json out{
        {"number", static_cast<int>(row.fault)}, {"fault", row.name}, {"limit_us", row.limit_us}};
    std::cout << "| " << static_cast<int>(row.fault) << " " << row.name;
    for (const Start start : {Start::idle, Start::armed, Start::scheduled, Start::energised}) {
      double worst = 0;
      int failed = 0;
      std::string why;
      for (int phase = 0; phase < 360; phase += step) {
        const CaseResult r = cases.run(row.fault, start, phase);
        ++total;
        worst = std::max(worst, r.reaction_us);
        if (r.passed) continue;
        if (failed++ == 0) why = " at " + std::to_string(phase) + " deg: " + r.why;
      }
      failures += failed;
      std::cout << " | " << worst;
      if (failed > 0) std::cout << " (" << failed << " FAILED," << why << ")";
      out[std::string(start_names[static_cast<std::size_t>(start)])] = {{"worst_us", worst},
                                                                        {"failed", failed}};
    }
    std::cout << " | " << row.limit_us << " |\n" << std::flush;
    rows.push_back(out);
  }
  std::cout << "\nWorst reaction in us from the cause, over " << 360 / step << " phases of the mains; "
            << total << " cases, " << failures << " failed.\n";
  if (!json_path.empty())
    std::ofstream(json_path) << nlohmann::json{{"cases", total}, {"failed", failures}, {"faults", rows}}.dump(
                                    1)
                             << "\n";
  return failures == 0 ? 0 : 1;
}
