#pragma once

#include <algorithm>
#include <span>

#include "sim/models/plant.h"

namespace powbench::rigs {

/// A change of the coil switch in plant time.
struct SwitchEdge {
  double at = 0.0;  ///< s
  bool on = false;
};

/// Advances the plant to times.back(), switching the coil at the edges on the way, and fills `states`.
/// Edges must lie in (plant.now(), times.back()], in order; one that is already past takes effect at once.
inline void advance_through(sim::Plant& plant, std::span<const SwitchEdge> edges,
                            std::span<const double> times, std::span<sim::PlantSample> states) {
  std::size_t done = 0;
  const auto advance_to = [&](double t) {
    const auto end = std::upper_bound(times.begin() + static_cast<std::ptrdiff_t>(done), times.end(), t);
    const auto n = static_cast<std::size_t>(end - times.begin()) - done;
    plant.advance(t, times.subspan(done, n), states.subspan(done, n));
    done += n;
  };
  for (const SwitchEdge& edge : edges) {
    if (edge.at > plant.now()) advance_to(edge.at);
    plant.gate(edge.on);
  }
  if (done < times.size()) advance_to(times.back());
}

}  // namespace powbench::rigs
