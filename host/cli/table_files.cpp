#include "host/cli/table_files.h"

#include <fmt/format.h>

#include <filesystem>

#include "host/config/bad_input.h"
#include "host/export/actuator_table.h"
#include "host/export/write_file.h"

namespace powbench::host {

namespace fs = std::filesystem;

void check_tables(const FieldArgs& args) {
  for (const auto& file : args.tables) {
    const std::string ending = fs::path(file).extension().string();
    if (ending != ".csv" && ending != ".mat" && ending != ".txt")
      throw BadInput({"--out " + file + ": ending '" + ending + "', allowed .csv, .mat, .txt"});
  }
  if (args.tables.empty()) return;
  if (args.ring)
    throw BadInput(
        {"--out and --ring: current and position determine the flux only with the ring at rest; allowed one "
         "of them"});
  if (!args.mesh_file.empty())
    throw BadInput({"--out and --mesh: one state is no table; allowed one of them"});
}

void write_tables(const FieldArgs& args, const sim::TablePotential& table, double travel,
                  const std::string& title) {
  if (args.tables.empty()) return;
  const double end = table.at({table.table().psi.back(), 0, travel}).current;
  constexpr double spare = 2;
  if (args.largest_current > spare * end)
    throw BadInput(
        {fmt::format("--largest-current = {:g}, allowed up to {:.3g} A: twice that of the open magnet at the "
                     "end of the table",
                     args.largest_current, spare * end)});
  const double most = args.largest_current > 0 ? args.largest_current : end;
  const ActuatorTable t = actuator_table(table, most, travel);
  for (const auto& file : args.tables) {
    const auto ending = fs::path(file).extension();
    write_file(file, ending == ".csv"   ? actuator_csv(t)
                     : ending == ".mat" ? actuator_mat(t)
                                        : actuator_modelica(t, title));
  }
  fmt::print(
      stderr,
      "{} currents up to {:.3g} A, {} positions up to {:.3g} mm; linear interpolation errs by up to {:.2g} % "
      "of the "
      "largest flux linkage and {:.2g} % of the largest force; {:.2g} % of the states are extrapolated\n",
      t.current.size(), most, t.position.size(), travel * 1e3, 100 * t.linear_error_linkage,
      100 * t.linear_error_force, 100 * t.beyond);
}

}  // namespace powbench::host
