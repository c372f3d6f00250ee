#include <fmt/format.h>

#include <filesystem>
#include <fstream>

#include "host/cli/scene.h"
#include "host/cli/scenes.h"
#include "host/cli/verbs.h"
#include "host/paper/simulator.h"
#include "host/paper/table_output.h"
#include "host/study/held_out.h"

namespace powbench::host {

Exit show_tables(const TablesArgs& args) {
  const sim::Specimen specimen =
      args.specimen_file.empty() ? sim::Specimen{} : read_specimen(args.specimen_file);
  ClosingProvider held_out;
  if (!args.fit_file.empty()) {
    std::ifstream in(args.fit_file, std::ios::binary);
    if (!in) throw BadInput({args.fit_file + ": cannot be read"});
    const std::string text{std::istreambuf_iterator<char>(in), std::istreambuf_iterator<char>()};
    held_out = held_out_provider(parse_fit_file(text, args.fit_file));
  }
  const auto rows = evaluate_tables(simulator_provider(specimen), held_out);
  fmt::print("{}", args.json ? tables_json(rows) + "\n" : tables_text(rows));
  return Exit::pass;
}

Exit demo(const DemoArgs& args) {
  namespace fs = std::filesystem;
  const fs::path folder(args.folder);
  fs::create_directories(folder);
  for (const auto& [file, text] : demo_scenes) {
    std::ofstream out(folder / file, std::ios::binary);
    out << text;
    out.close();
    if (!out)
      throw StoreError((folder / file).string() + ": cannot be written; choose another folder with -o");
  }
  const std::string plan = (folder / "demo.plan.toml").string();
  const std::string database = (folder / "demo.db").string();
  // a simulated rig that is not told otherwise is the one of the demo
  const bool bare = rigs::is_simulated(args.rig) && args.rig.ends_with(':');
  const std::string rig = bare ? args.rig + (folder / "demo.rig.toml").string() : args.rig;
  for (const char* ending : {"", "-wal", "-shm"}) fs::remove(database + ending);

  RunArgs run;
  run.plan = plan;
  run.rig = rig;
  run.database = database;
  run.progress = args.progress;
  const Exit acquired = run_plan(run);
  if (acquired != Exit::pass && acquired != Exit::outside_limits) return acquired;
  SimArgs sim;
  sim.plan = plan;
  sim.rig_file = (folder / "demo.rig.toml").string();
  sim.database = database;
  sim.progress = args.progress;
  const Exit simulated = simulate_plan(sim);
  if (simulated != Exit::pass) return simulated;
  ReportArgs report;
  report.database = database;
  report.folder = args.folder;
  write_report(report);
  fmt::print("{}\n", (folder / "report.html").string());
  return acquired;
}

}  // namespace powbench::host
