#include "sim/mechanics/canonical_order.h"

#include <algorithm>
#include <numeric>
#include <tuple>

namespace powbench::sim {
namespace {

auto own_numbers(const RigidBridge& b) {
  return std::tie(b.position, b.gap[0], b.gap[1], b.pad_arm, b.seat_arm, b.mass, b.inertia, b.preload, b.rate,
                  b.damping, b.turning_rate);
}
auto own_numbers(const BaseMode& m) {
  return std::tie(m.hertz, m.mass, m.damping, m.buffer);
}

std::vector<std::size_t> in_order_of(std::size_t count, const auto& less) {
  std::vector<std::size_t> order(count);
  std::iota(order.begin(), order.end(), std::size_t{0});
  std::stable_sort(order.begin(), order.end(), less);
  return order;
}

/// Compares two modes by their shapes, bridge by bridge.
bool shape_less(const BaseMode& a, const BaseMode& b, const std::vector<std::size_t>& bridges) {
  for (const std::size_t j : bridges)
    for (int end = 0; end < 2; ++end)
      if (a.shape[j][end] != b.shape[j][end]) return a.shape[j][end] < b.shape[j][end];
  return false;
}

}  // namespace

CanonicalParts in_canonical_order(const RigidParts& p) {
  const auto by_numbers = in_order_of(p.bridges.size(), [&](std::size_t i, std::size_t j) {
    return own_numbers(p.bridges[i]) < own_numbers(p.bridges[j]);
  });
  const auto modes = in_order_of(p.modes.size(), [&](std::size_t i, std::size_t j) {
    const auto& a = p.modes[i];
    const auto& b = p.modes[j];
    if (own_numbers(a) != own_numbers(b)) return own_numbers(a) < own_numbers(b);
    return shape_less(a, b, by_numbers);
  });
  const auto bridges = in_order_of(p.bridges.size(), [&](std::size_t i, std::size_t j) {
    if (own_numbers(p.bridges[i]) != own_numbers(p.bridges[j]))
      return own_numbers(p.bridges[i]) < own_numbers(p.bridges[j]);
    for (const std::size_t m : modes)
      for (int end = 0; end < 2; ++end)
        if (p.modes[m].shape[i][end] != p.modes[m].shape[j][end])
          return p.modes[m].shape[i][end] < p.modes[m].shape[j][end];
    return false;
  });

  CanonicalParts result;
  result.parts = p;
  std::iota(result.number.begin(), result.number.end(), 0);
  for (std::size_t m = 0; m < modes.size(); ++m) result.parts.modes[m] = p.modes[modes[m]];
  for (std::size_t lane = 0; lane < bridges.size(); ++lane) {
    const std::size_t from = bridges[lane];
    result.number[lane] = static_cast<int>(from);
    result.parts.bridges[lane] = p.bridges[from];
    for (std::size_t m = 0; m < modes.size(); ++m)
      for (int end = 0; end < 2; ++end)
        result.parts.modes[m].shape[lane][end] = p.modes[modes[m]].shape[from][end];
  }
  return result;
}

}  // namespace powbench::sim
