#include "sim/models/stages.h"

#include <array>
#include <cstddef>

namespace powbench::sim {

std::string_view stage_name(ClosingStage s) {
  constexpr std::array<std::string_view, 6> names = {"energising", "travel",  "touching",
                                                     "overtravel", "seating", "closed"};
  return names[static_cast<std::size_t>(s)];
}

}  // namespace powbench::sim
