#pragma once

#include <cstdint>
#include <optional>
#include <string>
#include <vector>

#include "core/outcome.h"
#include "core/record.h"
#include "dsp/options.h"
#include "host/cli/shard.h"

/// The verbs of the command line. Each takes its arguments as a struct and returns the exit code; what goes wrong is
/// thrown and turned into a sentence by main. Data goes to stdout, talk to stderr.

namespace powbench::host {

struct InfoArgs {
  std::string uri;
  bool json = false;
};
Exit list_rigs(bool json);
/// Coil off, whoever owns the rig; pass only when the rig has confirmed it, within 2 s.
Exit stop_rig(const InfoArgs&);
Exit show_rig(const InfoArgs&);

struct CalibrateArgs {
  std::string rig, id, expires;
  std::string date;  ///< "" = today
  std::string by = "unnamed";
  std::string output = "calibration.toml";
  bool overwrite = false;
};
Exit calibrate(const CalibrateArgs&);

struct ServeArgs {
  std::string rig_file;         ///< "" = built-in defaults
  std::string specimen_file;    ///< "" = the rig file's
  std::string address;          ///< "" = the rig file's
  std::uint64_t boot_seed = 0;  ///< of the boot_id; 0: another one at every start
  bool emulated = false;        ///< firmware on an emulated board
  bool to_network = false;      ///< an address that others reach is meant
};
Exit serve_rig(const ServeArgs&);

struct BridgeArgs {
  std::string port;
  unsigned baud = 2'000'000;
  std::string address = "127.0.0.9";
  bool to_network = false;  ///< an address that others reach is meant
};
Exit serve_bridge(const BridgeArgs&);

struct LiveArgs {
  std::string rig, plan;
  std::string database = "powbench.db";
  std::string listen = "127.0.0.1:8080";
  std::string token_file;  ///< "" = loopback only, with a token made at the start
};
/// The live bench.
Exit serve_bench(const LiveArgs&);

struct PlanArgs {
  std::string file;
  bool json = false;
};
Exit check_plan(const PlanArgs&);
Exit show_plan(const PlanArgs&);
Exit print_template(const std::string& kind);

struct RunArgs {
  std::string plan;
  std::string rig;
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
  int threads = 0;                ///< 0 = all cores
  std::string fields, mechanics;  ///< by name or auto; "" = the plan's
  std::string accuracy;           ///< of the touch time, "1%" or "0.01"; "" = the plan's
  std::string cache = "field";    ///< folder of field tables
  std::optional<double> volts, hertz, coil_degC, hold_ms, duration_ms;  ///< of a solenoid; none: the default
  std::string output;    ///< of a solenoid: CSV or SVG; "" = none
  bool nominal = false;  ///< as the plan asks, whatever was measured
  ShardArgs shards;      ///< of closings
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

struct AnnotateArgs : ResultArgs {
  std::string key, text;  ///< both empty: list what is there
};
Exit annotate(const AnnotateArgs&);
Exit list_shots(const ResultArgs&);

struct ShotArgs : ResultArgs {
  std::int64_t shot = 0;
  std::string file;  ///< picture to write: .svg or .html
};
Exit show_shot(const ShotArgs&);
Exit plot_shot(const ShotArgs&);

struct CompareArgs : ResultArgs {
  std::vector<std::int64_t> pair;  ///< none: measured beside simulated; two campaigns: before and after
};
Exit compare_campaigns(const CompareArgs&);

struct EventsArgs : ResultArgs {
  std::string shot;                       ///< id of a stored shot, or a waveform file
  std::string calibration;                ///< of a waveform file; "" = the one beside it
  std::optional<double> force_percent;    ///< lab rule: closed above this share of the settled force
  std::optional<double> voltage_percent;  ///< of the open-circuit voltage: open above it
  std::optional<double> min_opening_us;   ///< shorter openings count as closed
  std::string filter, phase,
      band;             ///< of the force channels, see host/config/filter_text.h; "" = none wanted
  std::string picture;  ///< .svg to write: the force before and after, in time and frequency
  bool stream = false;  ///< events as they come, with their latency
};
Exit show_events(const EventsArgs&);
Exit show_file_events(const EventsArgs&);
/// The record as it would come in, events as soon as they are known. Refuses what needs the whole record.
Exit stream_events(const Record&, const dsp::ExtractOptions&, const EventsArgs&);

struct ImportArgs {
  std::string file;
  bool suggest = false;     ///< store nothing: write the calibration file that the columns suggest
  std::string output;       ///< of that; "" = stdout
  bool overwrite = false;   ///< `output`
  std::string calibration;  ///< "" = the one beside it
  std::string database = "powbench.db";
  bool json = false;
};
Exit import_waveform_file(const ImportArgs&);

struct ReportArgs : ResultArgs {
  std::string folder = "out";
  bool pdf = false;  ///< printed by a browser, where one is installed
};
Exit write_report(const ReportArgs&);

struct ExportArgs : ResultArgs {
  std::int64_t shot = 0;                  ///< 0: the events of the campaign
  std::string to;                         ///< "": as the extension of the file says, else csv
  std::string file;                       ///< "" = stdout; for vtu and gltf a folder, "" = closing
  double cell_mm = 4;                     ///< of the bodies in vtu and gltf
  std::optional<double> scale_masses_ns;  ///< selective mass scaling of thin cells; none unless given
  double end_ms = 24;
};
Exit export_shot(const ExportArgs&);
/// The shot's closing once more, with deforming parts: motion and stress as VTU and PVD, or a film as glTF.
Exit export_closing(const ExportArgs&);

struct TablesArgs {
  std::string specimen_file;
  std::string
      fit_file;  ///< of `powbench fit`: held-out predictions; "" = those of the built-in specimen, none for another
  bool pressure = false;  ///< the statements on contact pressure instead
  bool json = false;
};
Exit show_tables(const TablesArgs&);

struct FieldArgs {
  std::string specimen_file;  ///< "" = the reference contactor
  std::string folder = "field";
  std::string accuracy = "0.5%";
  std::string steel;      ///< built-in steel or a B-H sheet; "" = the specimen's
  bool ring = false;      ///< the shading ring as a third variable
  std::string mesh_file;  ///< a plane mesh (MSH 4.1) in place of the specimen's shape; "" = none
  std::string mesh_unit = "mm";
  std::optional<double> current;    ///< A, with a mesh or of a solenoid; left out: 0.3
  bool symmetric = false;           ///< the mesh is one half of a symmetric device
  bool ends = false;                ///< with what three dimensions add at the ends of stack, coil and ring
  std::vector<std::string> tables;  ///< files for other simulators; their endings say how
  double largest_current = 0;       ///< A, of these; 0: from the table
  int threads = 0;                  ///< 0 = all cores
  ShardArgs shards;                 ///< of gaps
  bool json = false;
};
Exit show_field(const FieldArgs&);

struct SteelArgs {
  std::string steel;    ///< built-in name or a B-H sheet; "" = list what is built in
  std::string picture;  ///< SVG; "" = the steel's name in the working folder
  bool json = false;
};
Exit show_steel(const SteelArgs&);

struct DemoArgs {
  std::string folder = "powbench-demo";
  std::string rig = "sim:";
  std::string progress = "auto";
};
Exit demo(const DemoArgs&);

}  // namespace powbench::host
