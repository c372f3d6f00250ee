#include "host/cli/commands.h"
#include "host/cli/verbs.h"

namespace powbench::host {
namespace {

void add_bridge_verb(CLI::App& app) {
  auto bridge = std::make_shared<BridgeArgs>();
  CLI::App* serve = verb(app, "bridge", "Serve a board on a serial line to any IIO client until interrupted",
                         bridge, serve_bridge);
  serve->add_option("port", bridge->port, "serial port, such as /dev/ttyACM0")->required();
  serve->add_option("--baud", bridge->baud, "baud rate of the line, 8n1")
      ->check(CLI::Range(1200, 4'000'000))
      ->capture_default_str();
  serve->add_option("--listen", bridge->address, "loopback address to serve on; the port is always 30431")
      ->capture_default_str();
  serve->add_flag(
      "--open-to-network", bridge->to_network,
      "serve on an address reachable by others: anyone may read and stop the rig, firing needs the secret in "
      "POWBENCH_RIG_SECRET");
}

}  // namespace

void add_rig_verbs(CLI::App& app) {
  auto rigs_json = std::make_shared<bool>(false);
  CLI::App* rigs = app.add_subcommand("rigs", "List the kinds of rig and how to name each");
  rigs->add_flag("--json", *rigs_json, "JSON to stdout");
  rigs->callback([rigs_json] { chosen() = [rigs_json] { return list_rigs(*rigs_json); }; });

  auto info = std::make_shared<InfoArgs>();
  CLI::App* show = verb(app, "info", "Print the identity and the capabilities of a rig", info, show_rig);
  show->add_option("rig", info->uri, "rig, such as ip:127.0.0.7 or sim:")->required();
  show->add_flag("--json", info->json, "JSON to stdout");

  auto stopped = std::make_shared<InfoArgs>();
  CLI::App* stop = verb(app, "stop", "Switch the coil of a rig off, whoever owns it", stopped, stop_rig);
  stop->add_option("rig", stopped->uri, "rig, such as ip:127.0.0.7, usb: or serial:PORT,BAUD")->required();
  stop->add_flag("--json", stopped->json, "JSON to stdout");
  stop->footer(
      "Exit code 0 only if the rig has confirmed that its coil is off. Neither lease nor secret is needed.");

  auto args = std::make_shared<CalibrateArgs>();
  CLI::App* walk =
      verb(app, "calibrate", "Calibrate the inputs of a rig step by step and store the result in it", args,
           calibrate);
  walk->add_option("rig", args->rig, "rig, such as ip:127.0.0.7, serial:/dev/ttyACM0 or, to rehearse, sim:")
      ->required();
  walk->add_option("--id", args->id, "name of the certificate, up to 32 characters")->required();
  walk->add_option("--expires", args->expires, "last day of validity, such as 2030-12-31")->required();
  walk->add_option("--date", args->date, "day of the calibration; today if left out");
  walk->add_option("--by", args->by, "name of the operator")->capture_default_str();
  walk->add_option("-o,--output", args->output, "certificate to write (TOML)")->capture_default_str();
  walk->add_flag("--overwrite", args->overwrite, "replace a certificate that is there already");

  auto serve = std::make_shared<ServeArgs>();
  CLI::App* rig =
      verb(app, "rig", "Serve the simulated rig to any IIO client until interrupted", serve, serve_rig);
  rig->add_option("file", serve->rig_file, "rig file (TOML); built-in defaults if left out");
  rig->add_option("--specimen", serve->specimen_file, "specimen file (TOML) of the contactor on the rig");
  rig->add_option("--boot-seed", serve->boot_seed, "seed that gives the same boot_id at every start");
  rig->add_flag("--emulated", serve->emulated,
                "run the firmware on an emulated Cortex-M4F, like a `qemu:` rig, instead of in this program");
  rig->add_option(
      "--listen", serve->address,
      "loopback address instead of the rig file's (127.0.0.7 without one); the port is always 30431");
  rig->add_flag(
      "--open-to-network", serve->to_network,
      "serve on an address reachable by others: anyone may read and stop the rig, firing needs the secret in "
      "POWBENCH_RIG_SECRET");
  add_bridge_verb(app);
}

void add_live_verb(CLI::App& app) {
  auto live = std::make_shared<LiveArgs>();
  CLI::App* served =
      verb(app, "serve", "The live bench: fire, look and stop in a browser", live, serve_bench);
  served->add_option("--rig", live->rig, "rig: ip:ADDRESS, sim: or sim:RIG.toml, serial:PORT,BAUD, usb:...");
  served->add_option("--plan", live->plan, "plan (TOML) to begin with: volts, hold time, specimen, limits");
  served->add_option("--db", live->database, "store to write; made if missing")->capture_default_str();
  served->add_option("--listen", live->listen, "address and port; others than loopback need --token-file")
      ->capture_default_str();
  served->add_option("--token-file", live->token_file, "lines 'fire TOKEN' or 'read TOKEN'");
  served->footer(
      "Open the printed address in a browser. STOP is on every page, needs no token and has the key Esc.");
}

}  // namespace powbench::host
