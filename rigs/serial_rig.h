#pragma once

#include "rigs/bridge/options.h"
#include "rigs/rig.h"

namespace powbench::rigs {

/// Port and baud rate of `serial:/dev/ttyACM0,2000000`; without a rate, 2 Mbaud. Throws RigError.
BridgeOptions serial_options(const std::string& uri);

/// A board on a serial line: a bridge inside this process, on a loopback address of its own, and libiio's
/// client on it.
std::unique_ptr<Rig> connect_serial(const std::string& uri);

}  // namespace powbench::rigs
