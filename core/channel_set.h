#pragma once

#include <cstdint>

#include "core/channels.h"

namespace powbench {

/// A set of channels: bit `index(c)` for each.
using ChannelSet = std::uint32_t;
inline constexpr ChannelSet all_channels = (1U << channel_count) - 1;
constexpr bool contains(ChannelSet set, Channel c) {
  return (set >> index(c) & 1U) != 0;
}

}  // namespace powbench
