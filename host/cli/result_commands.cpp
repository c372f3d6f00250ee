#include <fmt/format.h>

#include <CLI/CLI.hpp>

#include "host/cli/commands.h"
#include "host/cli/verbs.h"

/// Words to arguments of what reads a store or a record.

namespace powbench::host {
namespace {

constexpr const char* import_footer = R"(
A waveform file has one header line and one line a sample:
  time [s],pvdf_a [N],pvdf_b [V],laser [mm]
  -0.0200,0.013,0.0021,0.0004
  -0.0199,0.011,0.0019,
Columns, in any order and number: time [s ms us]; pvdf_a, pvdf_b [N mN V mV]; laser [m mm um V mV]; coil_current
[A mA V mV]; coil_voltage, mains_voltage, contact_a, aux [V mV]. Time zero is switch-on. Stamps may be uneven but must
increase. An empty cell or nan is a lost sample. With semicolons or tabs as separators the decimal sign may be a
comma. Lines that begin with # are skipped.

A force sensor, laser or current clamp in volts needs a calibration file, shot.toml next to shot.csv:
  calibration = "sensors 2026-03"
  valid_until = "2027-03-01"
  [pvdf_b]
  gain_N_per_V = 10
  corner_hertz = 0.5
All its keys: powbench plan template calibration

Files of oscilloscopes are read without changes. [columns] of the calibration file assigns columns to channels, and
--suggest writes it:
  powbench import scope.csv --suggest -o scope.toml

Try:  powbench events shot.csv             contacts at once, without a store; --json for programs
      powbench import shot.csv --db lab.db  then events, export, report from there
)";

void add_result_options(CLI::App* app, ResultArgs& args) {
  app->add_option("--db", args.database, "store to read")->capture_default_str();
  app->add_option("--campaign", args.campaign, "campaign id; the newest if left out");
  app->add_flag("--json", args.json, "JSON to stdout");
}

}  // namespace

void add_result_verbs(CLI::App& app) {
  auto list = std::make_shared<ResultArgs>();
  add_result_options(verb(app, "campaigns", "List the campaigns in a store", list, list_campaigns), *list);
  auto shots = std::make_shared<ResultArgs>();
  add_result_options(verb(app, "shots", "List the shots of a campaign: angle reached, touch, bounce, outcome",
                          shots, list_shots),
                     *shots);
  auto shown = std::make_shared<ShotArgs>();
  CLI::App* one =
      verb(app, "show", "Print one shot: requested conditions, rig and firmware, results", shown, show_shot);
  one->add_option("shot", shown->shot, "shot id, as `powbench shots` lists it")->required();
  add_result_options(one, *shown);
  auto drawn = std::make_shared<ShotArgs>();
  CLI::App* plot =
      verb(app, "plot", "Plot the channels of a shot, with the simulation at its angle", drawn, plot_shot);
  plot->add_option("shot", drawn->shot, "shot id, as `powbench shots` lists it")->required();
  plot->add_option("-o,--output", drawn->file, "picture to write, .svg or .html; shot-ID.svg if left out");
  add_result_options(plot, *drawn);
  auto note = std::make_shared<AnnotateArgs>();
  CLI::App* annotated =
      verb(app, "annotate", "Add to the test record of a campaign; without KEY, list the additions", note,
           annotate);
  annotated->add_option(
      "key", note->key,
      "customer, order, device, serial, rating, standard, operator, recorded, source, remarks or instrument");
  annotated->add_option("text", note->text,
                        "text of the entry; for an instrument \"NAME; CERTIFICATE; LAST DAY\", the day as "
                        "2030-12-31 or left out");
  add_result_options(annotated, *note);
  auto events = std::make_shared<EventsArgs>();
  CLI::App* show =
      verb(app, "events", "Extract the events of a stored shot or of a waveform file", events, show_events);
  show->add_option(
          "shot", events->shot,
          "shot id, as `powbench campaigns --json` and the report list it; or a CSV file, see `powbench "
          "import --help`")
      ->required();
  show->add_option("--calibration", events->calibration, "calibration file of a CSV file");
  show->add_option(
          "--force-percent", events->force_percent,
          "lab rule: closed above this share of the settled force, instead of where the force leaves zero")
      ->check(CLI::Range(0.1, 99.0));
  show->add_option("--voltage-percent", events->voltage_percent,
                   "lab rule: open above this share of the open-circuit contact voltage (50)")
      ->check(CLI::Range(1.0, 99.0));
  show->add_option("--min-opening-us", events->min_opening_us, "lab rule: shorter openings count as closed")
      ->check(CLI::Range(0.0, 1e5));
  show->add_option(
      "--filter", events->filter,
      "filter of the force before the extraction: none, plain (low-pass at the end of the contact band, "
      "if the vibration permits one), lowpass:2kHz or bandstop:3.1kHz..3.6kHz");
  show->add_option(
      "--phase", events->phase,
      "phase of the filter: zero (forward and backward) or causal (times are corrected for its delay)");
  show->add_option(
      "--band", events->band,
      "band in which core vibration is searched and modelled, such as 800Hz..18kHz (the default)");
  show->add_flag("--stream", events->stream,
                 "print each touch, release and seat as soon as its samples are available, with the latency");
  show->add_option("--picture", events->picture,
                   "SVG to write: the force as recorded and as used for the events, in time and frequency");
  show->footer(
      "Without --filter the vibration is removed by a model fitted to the record, and no filter is "
      "applied. A "
      "filter moves "
      "edges: the added uncertainty, the remaining vibration and the energy lost by the shortest contact "
      "are printed "
      "with the events. A filter that removes more than -20 dB (a hundredth) of that energy is refused.\n"
      "  powbench events 7 --filter bandstop:14kHz..16kHz --phase causal");
  add_result_options(show, *events);
  auto comparison = std::make_shared<CompareArgs>();
  CLI::App* compared =
      verb(app, "compare", "Compare measured, simulated and published values, or two campaigns", comparison,
           compare_campaigns);
  compared
      ->add_option("campaigns", comparison->pair, "two campaign ids: the second is compared with the first")
      ->expected(2);
  add_result_options(compared, *comparison);
  auto report = std::make_shared<ReportArgs>();
  CLI::App* write =
      verb(app, "report", "Write report (HTML, PDF) and JUnit XML of a campaign", report, write_report);
  add_result_options(write, *report);
  write->add_option("-o,--output", report->folder, "folder to write into; made if missing")
      ->capture_default_str();
  write->add_flag("--pdf", report->pdf, "print report.pdf too, with an installed Chromium");
  auto exported = std::make_shared<ExportArgs>();
  CLI::App* out =
      verb(app, "export", "Write shots for other programs: waveforms of one, events of a campaign", exported,
           export_shot);
  out->add_option("shot", exported->shot, "shot id; left out for the events of a campaign (arrow, xlsx)");
  add_result_options(out, *exported);
  out->add_option("--to", exported->to, "format; if left out, that of the file's extension, otherwise csv")
      ->check(CLI::IsMember({"csv", "nc", "comtrade", "xlsx", "arrow", "vtu", "gltf"}));
  out->add_option("-o,--output", exported->file, "file; stdout if left out (csv). vtu, gltf: folder");
  out->footer(
      "csv        waveforms as text, with a calibration file: powbench import reads both back\n"
      "nc         waveforms as netCDF-4 (HDF5): xarray.open_dataset\n"
      "comtrade   waveforms as x.cfg and x.dat, for relay test sets and fault recorders\n"
      "xlsx       waveforms and contacts of a shot, or without a shot the events and contacts of a campaign\n"
      "arrow      events of a campaign as Arrow IPC: polars.read_ipc, pyarrow, apache-arrow of npm\n"
      "vtu, gltf  motion and stress of the shot's closing, simulated once more");
  out->add_option("--cell-mm", exported->cell_mm, "vtu, gltf: largest size of a cell, mm")
      ->capture_default_str();
  out->add_option("--scale-masses-ns", exported->scale_masses_ns,
                  "vtu, gltf: selective mass scaling of thin cells to this time step, ns");
  out->add_option("--end-ms", exported->end_ms, "vtu, gltf: end of the simulation, ms")
      ->capture_default_str();
}

void add_import_verb(CLI::App& app) {
  auto args = std::make_shared<ImportArgs>();
  CLI::App* in =
      verb(app, "import", "Store a waveform of any instrument as a shot", args, import_waveform_file);
  in->add_option("file", args->file,
                 "waveform file: CSV of an oscilloscope or logger, .lvm, .tdms, .mat, .wvf or .hdr, COMTRADE "
                 "(.cfg, .cff), .wav")
      ->required();
  in->add_flag("--suggest", args->suggest,
               "store nothing; print a proposed calibration file, with the reason for each column");
  in->add_option("-o,--output", args->output, "with --suggest: file to write it to");
  in->add_flag("--overwrite", args->overwrite, "with --suggest: replace a file that is there already");
  in->add_option("--calibration", args->calibration,
                 "calibration file (TOML); FILE.toml beside FILE.csv if left out");
  in->add_option("--db", args->database, "store to write; made if missing")->capture_default_str();
  in->add_flag("--json", args->json, "JSON to stdout");
  in->footer(import_footer);
}

}  // namespace powbench::host
