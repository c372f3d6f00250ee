#include <fmt/format.h>

#include <filesystem>
#include <fstream>

#include "host/cli/verbs.h"
#include "host/config/bad_input.h"
#include "host/config/specimen_file.h"
#include "host/export/closing_film.h"
#include "host/export/write_file.h"
#include "host/gather/gather.h"
#include "host/store/store.h"
#include "sim/models/solid_closing.h"
#include "sim/specimen/specimen_potential.h"

namespace powbench::host {
namespace {

namespace fs = std::filesystem;

void check(const ExportArgs& args) {
  std::vector<std::string> wrong;
  if (!(args.cell_mm >= 0.5 && args.cell_mm <= 10))
    wrong.push_back(fmt::format("--cell-mm = {}, allowed 0.5 .. 10", args.cell_mm));
  if (args.scale_masses_ns && !(*args.scale_masses_ns > 0 && *args.scale_masses_ns <= 1e6))
    wrong.push_back(fmt::format("--scale-masses-ns = {}, allowed above 0 .. the median own step of the cells",
                                *args.scale_masses_ns));
  if (!(args.end_ms > 0 && args.end_ms <= 100))
    wrong.push_back(fmt::format("--end-ms = {}, allowed above 0 .. 100", args.end_ms));
  if (!wrong.empty()) throw BadInput(wrong);
}

}  // namespace

Exit export_closing(const ExportArgs& args) {
  check(args);
  const Store store(args.database, Store::Mode::read_only);
  const StoredShot shot = store.shot(args.shot);
  const sim::Specimen specimen = stored_specimen(store.campaign(shot.campaign));
  const fs::path folder = args.file.empty() ? "closing" : args.file;
  std::error_code error;
  fs::create_directories(folder, error);
  const auto write = [&](const std::string& name, const std::string& content) {
    write_file(folder / name, content);
  };
  const bool vtu = args.to == "vtu";
  ClosingFilm film(vtu ? ClosingFilm::Format::vtu : ClosingFilm::Format::gltf, write);
  sim::SolidClosingOptions options;
  options.cell = args.cell_mm * 1e-3;
  options.end = args.end_ms * 1e-3;
  if (args.scale_masses_ns) options.solid.scale_masses_to = *args.scale_masses_ns * 1e-9;
  options.workers = 2;
  options.sample = vtu ? 50e-6 : 5e-6;
  const sim::SpecimenPotential field(specimen);
  try {
    const auto r = sim::solid_closing(specimen, shot.conditions, field, options, std::ref(film));
    film.finish();
    fmt::print(
        stderr,
        "{} cells, {} states in {}: touch {:.3f} ms, seat {:.3f} ms, {} openings, energy residual {:.1e}\n",
        r.cells, film.states(), folder.string(), 1e3 * r.first_touch, 1e3 * r.core_seat, r.openings,
        r.residual);
    if (args.scale_masses_ns)
      fmt::print(stderr,
                 "inertia against deformation added to {} thin cells: {:.3g} % of the mass, {} steps\n",
                 r.scaled_cells, 100 * r.added_inertia, r.deformed_steps);
    return Exit::pass;
  } catch (const std::invalid_argument& wrong) {
    throw BadInput({std::string("export: ") + wrong.what()});
  } catch (const sim::SolidStop& stop) {  // the state it stopped in is the last one
    film.finish();
    fmt::print(stderr, "stopped: {}; the states up to there are in {}\n", stop.what(), folder.string());
    return Exit::outside_limits;
  }
}

}  // namespace powbench::host
