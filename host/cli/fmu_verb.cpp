#include "host/cli/fmu_verb.h"

#include <fmt/format.h>

#include <nlohmann/json.hpp>

#include "fmu/variables.h"
#include "host/config/specimen_file.h"
#include "host/export/fmu.h"
#include "host/export/write_file.h"

namespace powbench::host {

Exit make_fmu(const FmuArgs& args) {
  const sim::Specimen specimen =
      args.specimen_file.empty() ? sim::Specimen{} : read_specimen(args.specimen_file);
  const auto fmi = args.fmi == 3 ? fmu::Fmi::three : fmu::Fmi::two;
  const std::string bytes = to_fmu(specimen, resolved_text(specimen), fmi);
  write_file(args.output, bytes);
  std::size_t inputs = 0, outputs = 0, parameters = 0;
  for (const auto& v : fmu::variables(specimen, fmi)) {
    inputs += v.causality == fmu::Variable::Causality::input;
    outputs += v.causality == fmu::Variable::Causality::output;
    parameters += v.causality == fmu::Variable::Causality::parameter;
  }
  if (args.json) {
    fmt::print("{}\n", nlohmann::ordered_json{{"file", args.output},
                                              {"fmi", args.fmi},
                                              {"bytes", bytes.size()},
                                              {"inputs", inputs},
                                              {"outputs", outputs},
                                              {"parameters", parameters}}
                           .dump(2));
    return Exit::pass;
  }
  fmt::print("{}\n", args.output);
  fmt::print(stderr, "{} as FMI {}.0, {}: {} inputs, {} outputs, {} parameters, {:.0f} kB\n", specimen.name,
             args.fmi, args.fmi == 2 ? "model exchange and co-simulation" : "co-simulation", inputs, outputs,
             parameters, static_cast<double>(bytes.size()) / 1e3);
  return Exit::pass;
}

}  // namespace powbench::host
