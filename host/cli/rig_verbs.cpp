#include <fmt/format.h>

#include <chrono>
#include <cstdlib>
#include <nlohmann/json.hpp>

#include "host/cli/verbs.h"
#include "host/gather/scene.h"
#include "rigs/boot_id.h"
#include "rigs/bridge/bridge.h"
#include "rigs/exposure.h"
#include "rigs/iiod_server.h"
#include "rigs/registry.h"

namespace powbench::host {

namespace {

/// Of a server on `address`; the secret is taken from the environment, where no list of programs shows it.
rigs::Exposure exposure_of(const std::string& address, bool to_network) {
  const char* secret = to_network ? std::getenv("POWBENCH_RIG_SECRET") : nullptr;
  rigs::Exposure exposure{to_network, secret ? secret : ""};
  rigs::check_exposure(address, exposure);
  return exposure;
}

}  // namespace

Exit list_rigs(bool json) {
  nlohmann::ordered_json list = nlohmann::ordered_json::array();
  for (const rigs::RigKind& kind : rigs::rig_kinds) {
    if (json)
      list.push_back({{"scheme", kind.scheme}, {"example", kind.example}, {"meaning", kind.meaning}});
    else
      fmt::print("{:<26} {}\n", kind.example, kind.meaning);
  }
  if (json) fmt::print("{}\n", list.dump(2));
  return Exit::pass;
}

Exit show_rig(const InfoArgs& args) {
  const auto rig = open_rig(args.uri, {});
  const rigs::RigInfo& info = rig->info();
  if (args.json) {
    nlohmann::ordered_json j = {{"uri", info.uri},
                                {"description", info.description},
                                {"model", info.model},
                                {"serial", info.serial},
                                {"firmware", info.firmware},
                                {"kind", info.kind},
                                {"programmable_source", info.programmable_source},
                                {"sample_rate_hz", info.sample_rate},
                                {"calibration", info.calibration},
                                {"calibration_expires", info.calibration_expires},
                                {"phase", info.phase},
                                {"channels", nlohmann::ordered_json::array()}};
    for (const auto& c : info.channels)
      j["channels"].push_back({{"id", c.id}, {"label", c.label}, {"unit", c.unit}, {"scale", c.scale}});
    fmt::print("{}\n", j.dump(2));
    return Exit::pass;
  }
  fmt::print("{}\n  serial       {}\n  firmware     {}\n  calibration  {}\n", info.model, info.serial,
             info.firmware,
             info.calibration +
                 (info.calibration_expires.empty() ? "" : ", valid until " + info.calibration_expires));
  fmt::print("  sampling     {:.0f} kS/s on {} channels\n", info.sample_rate / 1e3, info.channels.size());
  fmt::print("  source       {}\n",
             info.programmable_source ? "programmable (voltage, frequency, ambient)" : "fixed mains");
  fmt::print("  mains phase  {}\n", info.phase);
  for (const auto& c : info.channels)
    fmt::print("  {:<10} {:<14} {:.6g} {} per count\n", c.id, c.label, c.scale, c.unit);
  return Exit::pass;
}

Exit serve_rig(const ServeArgs& args) {
  const RigFile file = args.rig_file.empty() ? RigFile{} : read_rig(args.rig_file);
  refuse_unfit(file, args.rig_file);
  const sim::Specimen specimen =
      args.specimen_file.empty() ? load_specimen(file) : read_specimen(args.specimen_file);
  const std::string address = args.address.empty() ? file.listen : args.address;
  rigs::BoardOptions board = args.emulated ? rigs::emulated_board : rigs::BoardOptions{};
  const auto now = std::chrono::system_clock::now().time_since_epoch().count();
  board.boot_id = rigs::next_boot_id(file.config.serial,
                                     args.boot_seed != 0 ? args.boot_seed : static_cast<std::uint64_t>(now));
  board.secret = rigs::token_prefix(exposure_of(address, args.to_network));
  rigs::IiodServer server(file.config, specimen, address, rigs::iiod_port, board);
  fmt::print(stderr, "{} on ip:{} (port {}), specimen {}\nstop with Ctrl-C; try: iio_info -u ip:{}\n",
             file.config.name, server.address(), rigs::iiod_port, specimen.name, server.address());
  server.serve(true);
  fmt::print(stderr, "stopped\n");
  return Exit::pass;
}

Exit serve_bridge(const BridgeArgs& args) {
  rigs::BridgeOptions options;
  options.port = args.port;
  options.baud = args.baud;
  options.address = args.address;
  options.token_prefix = rigs::token_prefix(exposure_of(args.address, args.to_network));
  rigs::Bridge bridge(options);
  fmt::print(stderr, "{} on {} at {} baud -> ip:{} (port {})\nstop with Ctrl-C; try: iio_info -u ip:{}\n",
             bridge.board(), options.port, options.baud, bridge.address(), options.tcp_port,
             bridge.address());
  bridge.serve(true);
  fmt::print(stderr, "stopped\n");
  return Exit::pass;
}

}  // namespace powbench::host
