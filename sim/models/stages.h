#pragma once

#include <cstdint>
#include <string_view>

/// The stages of a closing by name.

namespace powbench::sim {

/// The six stages of a closing, in order.
enum class ClosingStage : std::uint8_t {
  energising,  ///< the pull rises, the core still rests on its stops
  travel,      ///< the core moves, all pads are open
  touching,    ///< from the first touch of a pad until every pad has touched
  overtravel,  ///< the core moves on while the bridges rest on their pads
  seating,     ///< from the first touch of a pole face until the last bounce
  closed       ///< nothing touches or leaves any more
};
std::string_view stage_name(ClosingStage);

struct StageTime {
  ClosingStage stage{};
  double begin = 0;  ///< s
};

}  // namespace powbench::sim
