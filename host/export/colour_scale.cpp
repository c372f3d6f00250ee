#include "host/export/colour_scale.h"

#include <fmt/format.h>

#include <algorithm>
#include <array>

namespace powbench::host {

std::string scale_colour(double share) {
  constexpr std::array<std::array<double, 3>, 6> stops{
      {{247, 251, 255}, {198, 219, 239}, {107, 174, 214}, {65, 182, 140}, {240, 180, 60}, {165, 15, 21}}};
  const double at = std::clamp(share, 0.0, 1.0) * (stops.size() - 1);
  const auto k = std::min(static_cast<std::size_t>(at), stops.size() - 2);
  const double t = at - static_cast<double>(k);
  const auto mix = [&](std::size_t c) {
    return static_cast<int>(stops[k][c] + t * (stops[k + 1][c] - stops[k][c]) + 0.5);
  };
  return fmt::format("#{:02x}{:02x}{:02x}", mix(0), mix(1), mix(2));
}

}  // namespace powbench::host
