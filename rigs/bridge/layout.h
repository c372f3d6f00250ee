#pragma once

#include <cstddef>
#include <cstdint>
#include <string>
#include <string_view>
#include <vector>

/// What the bridge needs to know of a context description: which devices there are and how long a scan is.

namespace powbench::rigs::bridge {

struct DeviceLayout {
  std::string id, name;
  std::vector<std::size_t>
      widths;  ///< bytes of one sample of each scan channel, in the order of the mask's bits

  bool buffered() const { return !widths.empty(); }
  /// Bytes of one scan with the channels of `mask`, as libiio 0.x packs it: every sample aligned to its own
  /// size, nothing behind the last. 0: the mask names a channel that does not exist, or none.
  std::size_t scan_bytes(std::uint32_t mask) const;
};

/// The devices of a context description, in its order. What it does not understand it leaves out.
std::vector<DeviceLayout> read_devices(std::string_view xml);

/// Value of the context attribute `name`; empty: there is none.
std::string context_attribute(std::string_view xml, std::string_view name);

}  // namespace powbench::rigs::bridge
