#pragma once

#include <filesystem>
#include <string>
#include <vector>

#include "host/config/bad_input.h"
#include "host/config/key_line.h"
#include "rigs/sim_rig_config.h"
#include "sim/specimen/specimen.h"

/// The rig file: one bench. Owner: the bench keeper.

namespace powbench::host {

struct RigFile {
  std::string listen = "127.0.0.7";  ///< address the simulated rig serves on; the IIO port is fixed
  std::string
      specimen;  ///< specimen file of the mounted device, relative to the rig's folder; "" = the built-in reference
  rigs::SimRigConfig config;

  std::filesystem::path folder;  ///< of the rig file; not part of the resolved text
};

/// Throws BadInput with all mistakes.
RigFile read_rig(const std::filesystem::path&);
RigFile parse_rig(std::string text, std::string file);

/// Commented file with every key.
std::string rig_template();

/// Every key with its value.
std::vector<KeyLine> keys_of(const RigFile&);

/// Canonical text: equal rigs give equal bytes. parse_rig reads it back.
std::string resolved_text(const RigFile&);

/// The specimen mounted on the rig. Throws BadInput.
sim::Specimen load_specimen(const RigFile&);

}  // namespace powbench::host
