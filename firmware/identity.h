#pragma once

#include <cstdint>
#include <string_view>

#include "firmware/controller.h"

/// Which program, on which board, with which configuration: what every shot has to say about its maker.

namespace powbench::firmware {

/// CRC-32 over the fields that decide what a shot is and what it is worth, in the order of their declaration and as
/// little-endian 64-bit integers (floats as their bits): equal on every port, whatever its padding and pointers.
std::uint32_t config_crc32(const ControllerConfig&);

struct ShotIdentity {
  BuildIdentity build;
  std::uint32_t config_crc32 = 0;
  std::string_view calibration_id;
};

/// For whoever seals a shot. The texts live as long as the program.
inline ShotIdentity shot_identity(const Controller& controller) {
  return {.build = controller.identity(),
          .config_crc32 = config_crc32(controller.config()),
          .calibration_id = controller.config().calibration_id};
}

}  // namespace powbench::firmware
