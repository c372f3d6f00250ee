#pragma once

#include <cstdio>
#include <nlohmann/json.hpp>
#include <string>

/// The table of the three-dimensional fields: one row a quantity beside its reference.

namespace powbench::bench {

struct Row {
  std::string name, unit;
  double value = 0, reference = 0;
  int unknowns = 0, iterations = 0;
  double cpu = 0;
  std::string kind;  ///< of reference: exact, measured
};

class Table {
 public:
  void add(const Row& r) {
    const double error = 100 * (r.value / r.reference - 1);
    std::printf("%-34s %9d %4d %8.2f %14.6g %14.6g %-5s %8.3f  %s\n", r.name.c_str(), r.unknowns,
                r.iterations, r.cpu, r.value, r.reference, r.unit.c_str(), error, r.kind.c_str());
    std::fflush(stdout);
    rows_.push_back({{"case", r.name},
                     {"unknowns", r.unknowns},
                     {"iterations", r.iterations},
                     {"cpu_s", r.cpu},
                     {"value", r.value},
                     {"reference", r.reference},
                     {"unit", r.unit},
                     {"error_percent", error},
                     {"reference_kind", r.kind}});
  }
  static void head() {
    std::printf("%-34s %9s %4s %8s %14s %14s %-5s %8s  %s\n", "case", "unknowns", "its", "CPU s", "value",
                "reference", "unit", "error %", "reference is");
  }
  nlohmann::ordered_json rows() const { return rows_; }

 private:
  nlohmann::ordered_json rows_ = nlohmann::ordered_json::array();
};

}  // namespace powbench::bench
