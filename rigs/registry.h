#pragma once

#include <memory>
#include <optional>
#include <string>
#include <string_view>
#include <vector>

#include "rigs/rig.h"
#include "rigs/sim_rig_config.h"
#include "sim/specimen/specimen.h"

namespace powbench::rigs {

/// A kind of rig that a URI can name.
struct RigKind {
  std::string_view scheme, example, meaning;
};
inline constexpr RigKind rig_kinds[] = {
    {"sim:", "sim:scenes/demo.rig.toml",
     "simulated rig inside this program (plant, sensors, native firmware)"},
    {"qemu:", "qemu:scenes/demo.rig.toml",
     "the same with the firmware on an emulated Cortex-M4F (qemu-system-arm)"},
    {"ip:", "ip:127.0.0.7", "any rig that serves IIO on the network, port 30431"},
    {"usb:", "usb:1.5.0", "a rig on USB, as libiio names it"},
    {"serial:", "serial:/dev/ttyACM0,2000000", "a board on a serial line: port and baud rate"},
};

/// The URI names a rig with a simulated plant: what follows the colon is a rig file, or nothing.
inline bool is_simulated(std::string_view uri) {
  return uri.starts_with("sim:") || uri.starts_with("qemu:");
}

/// A rig as an address that libiio understands. What serves it lives as long as this.
struct Endpoint {
  std::string uri;
  std::shared_ptr<void> server;
};
/// Throws as open() does.
Endpoint endpoint(const std::string& uri, const SimRigConfig& sim, const sim::Specimen& specimen);
/// The same for whoever only looks on or stops: a serial port that another program holds is reached through its bridge.
/// Throws RigError.
Endpoint endpoint_to_stop(const std::string& uri);

/// Opens the rig that `uri` names. `sim` is what a `sim:` or `qemu:` rig is made of. Throws RigError with one sentence.
std::unique_ptr<Rig> open(const std::string& uri, const SimRigConfig& sim, const sim::Specimen& specimen);

}  // namespace powbench::rigs
