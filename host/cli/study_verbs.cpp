#include <fmt/format.h>

#include <cmath>
#include <filesystem>
#include <fstream>
#include <set>

#include "host/cli/demo_end.h"
#include "host/cli/scenes.h"
#include "host/cli/verbs.h"
#include "host/export/write_file.h"
#include "host/gather/scene.h"
#include "host/paper/contact_pressure.h"
#include "host/paper/simulator.h"
#include "host/paper/table_output.h"
#include "host/study/bounce_text.h"
#include "host/study/held_out.h"

namespace powbench::host {

namespace {

/// Closing angles at which the two specimens show the printed trains: the paper prints none.
constexpr double level_deg = 112, tilted_deg = 180;

/// A scene of the demo; a file that somebody has changed stays, and is used.
void lay_out(const std::filesystem::path& file, std::string_view text) {
  if (!std::filesystem::exists(file)) return write_file(file, std::string(text));
  std::ifstream in(file, std::ios::binary);
  const std::string there{std::istreambuf_iterator<char>(in), {}};
  if (there != text)
    fmt::print(stderr, "{} is not as the demo writes it: kept and used; delete it for the demo's own\n",
               file.string());
}

}  // namespace

Exit show_tables(const TablesArgs& args) {
  if (args.pressure) {
    const PressurePage page{
        parse_specimen(std::string(contact_pressure_specimen), "contact-pressure.specimen.toml"),
        parse_specimen(std::string(contact_pressure_tilted_specimen),
                       "contact-pressure-tilted.specimen.toml"),
        level_deg, tilted_deg};
    fmt::print("{}", args.json ? pressure_json(page) + "\n" : pressure_text(page));
    return Exit::pass;
  }
  const sim::Specimen specimen =
      args.specimen_file.empty() ? parse_specimen(std::string(published_specimen), "published.specimen.toml")
                                 : read_specimen(args.specimen_file);
  ClosingProvider held_out;
  if (args.specimen_file.empty() && args.fit_file.empty())
    held_out = held_out_provider(parse_fit_file(std::string(published_fit), "published.fit.json"));
  if (!args.fit_file.empty()) held_out = held_out_provider(load_fit_file(args.fit_file));
  const auto rows = evaluate_tables(simulator_provider(specimen), held_out);
  if (args.json) {
    fmt::print("{}\n", tables_json(rows));
    return Exit::pass;
  }
  std::set<double> angles;
  for (const auto& row : rows)
    if (std::isfinite(row.published.theta_deg)) angles.insert(row.published.theta_deg);
  std::vector<BounceRow> bounces;
  for (const double theta : angles)
    bounces.push_back({fmt::format("{:g} degrees", theta), published_bounces(specimen, theta)});
  fmt::print("{}\n{}", tables_text(rows), bounce_text(bounces, published_bounce_options()));
  return Exit::pass;
}

Exit demo(const DemoArgs& args) {
  namespace fs = std::filesystem;
  const fs::path folder(args.folder);
  std::error_code ignored;  // the first file says it
  fs::create_directories(folder, ignored);
  for (const auto& [file, text] : demo_scenes) lay_out(folder / file, text);
  const std::string plan = (folder / "demo.plan.toml").string();
  const std::string database = (folder / "demo.db").string();
  // a simulated rig that is not told otherwise is the one of the demo
  const bool bare = rigs::is_simulated(args.rig) && args.rig.ends_with(':');
  const std::string rig = bare ? args.rig + (folder / "demo.rig.toml").string() : args.rig;

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
  const Exit ended = write_report(report);
  const std::string page = (folder / "report.html").string();
  fmt::print("{}\n", page);
  std::fflush(stdout);  // the sentences come last, also where both streams are one
  const Store store(database, Store::Mode::read_only);
  fmt::print(stderr, "{}", three_sentences(store, store.campaign(), page));
  return ended;
}

}  // namespace powbench::host
