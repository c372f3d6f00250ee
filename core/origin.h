#pragma once

#include <array>
#include <cstdint>
#include <string_view>

/// Where a record comes from, in the words that stand on every page, in every export and in JSON.

namespace powbench {

enum class Origin : std::uint8_t {
  unknown,         ///< from before it was kept, or a rig that does not tell
  simulated_rig,   ///< the plant of the simulator, the firmware in a program
  emulated_board,  ///< the plant of the simulator, the firmware on an emulated processor
  board,           ///< a contactor on a bench
  import,          ///< a waveform file of somebody else's
  simulation,      ///< no rig at all: closings that were only computed
};

inline constexpr std::array<std::string_view, 6> origin_names{
    "ORIGIN UNKNOWN", "SIMULATED RIG", "EMULATED BOARD", "BOARD", "IMPORT", "SIMULATION ONLY"};
constexpr std::string_view name(Origin o) {
  return origin_names[static_cast<std::size_t>(o)];
}

/// What it means, one sentence for the first page.
constexpr std::string_view meaning(Origin o) {
  constexpr std::array<std::string_view, 6> sentences{
      "The file does not say what these records were taken from.",
      "No contactor was switched: these records come from a simulated contactor and simulated sensors.",
      "No contactor was switched: real firmware on an emulated processor, a simulated contactor and "
      "simulated sensors.",
      "Records of a contactor on a bench.",
      "Waveforms from files.",
      "No rig was fired; closings were only computed."};
  return sentences[static_cast<std::size_t>(o)];
}

/// By the `bench,kind` attribute of a rig: sim, qemu, board.
constexpr Origin origin_of_kind(std::string_view kind) {
  return kind == "sim"     ? Origin::simulated_rig
         : kind == "qemu"  ? Origin::emulated_board
         : kind == "board" ? Origin::board
                           : Origin::unknown;
}

}  // namespace powbench
