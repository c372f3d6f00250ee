#pragma once

#include <cstdint>
#include <optional>
#include <string>

#include "core/outcome.h"

/// The verbs of the command line. Each takes its arguments as a struct and returns the exit code; what goes wrong is
/// thrown and turned into a sentence by main. Data goes to stdout, talk to stderr.

namespace powbench::host {

struct InfoArgs {
  std::string uri;
  bool json = false;
};
Exit list_rigs(bool json);
Exit show_rig(const InfoArgs&);

struct ServeArgs {
  std::string rig_file;         ///< "" = built-in defaults
  std::string specimen_file;    ///< "" = the rig file's
  std::string address;          ///< "" = the rig file's
  std::uint64_t boot_seed = 0;  ///< of the boot_id; 0: another one at every start
  bool emulated = false;        ///< firmware on an emulated board
};
Exit serve_rig(const ServeArgs&);

struct BridgeArgs {
  std::string port;
  unsigned baud = 2'000'000;
  std::string address = "127.0.0.9";
};
Exit serve_bridge(const BridgeArgs&);

struct PlanArgs {
  std::string file;
  bool json = false;
};
Exit check_plan(const PlanArgs&);
Exit show_plan(const PlanArgs&);
Exit print_template(const std::string& kind);

struct RunArgs {
  std::string plan;
  std::string rig = "sim:";
  std::string database = "powbench.db";
  bool resume = false;
  bool dry_run = false;
  bool json = false;
  std::optional<std::uint64_t> seed;
  int max_failures = 5;
  std::string progress = "auto";
};
Exit run_plan(const RunArgs&);

struct SimArgs {
  std::string plan;
  std::string rig_file;  ///< sensors to simulate through; "" = built-in
  std::string database = "powbench.db";
  int threads = 0;  ///< 0 = all cores
  bool json = false;
  std::string progress = "auto";
};
Exit simulate_plan(const SimArgs&);

struct ResultArgs {
  std::string database = "powbench.db";
  std::optional<std::int64_t> campaign;
  bool json = false;
};
Exit list_campaigns(const ResultArgs&);
Exit compare_campaign(const ResultArgs&);

struct EventsArgs : ResultArgs {
  std::string shot;         ///< id of a stored shot, or a waveform file
  std::string calibration;  ///< of a waveform file; "" = the one beside it
};
Exit show_events(const EventsArgs&);
Exit show_file_events(const EventsArgs&);

struct ImportArgs {
  std::string file;
  std::string calibration;  ///< "" = the one beside it
  std::string database = "powbench.db";
  bool json = false;
};
Exit import_waveform_file(const ImportArgs&);

struct ReportArgs : ResultArgs {
  std::string folder = "out";
};
Exit write_report(const ReportArgs&);

struct ExportArgs : ResultArgs {
  std::int64_t shot = 0;
  std::string to = "csv";
  std::string file;  ///< "" = stdout
};
Exit export_shot(const ExportArgs&);

struct TablesArgs {
  std::string specimen_file;
  std::string fit_file;  ///< of `powbench fit`: held-out predictions; "" = the reference's own
  bool json = false;
};
Exit show_tables(const TablesArgs&);

struct DemoArgs {
  std::string folder = "powbench-demo";
  std::string rig = "sim:";
  std::string progress = "auto";
};
Exit demo(const DemoArgs&);

}  // namespace powbench::host
