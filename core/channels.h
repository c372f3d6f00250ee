#pragma once

#include <array>
#include <cstddef>
#include <cstdint>
#include <string_view>

/// The record's channels, once. Enumeration, wire names, units and storage derive from this table.
/// Columns: name | IIO channel id | SI unit on the host | factor from the IIO unit (kPa, m, mA, mV) to SI | meaning
/// For the two force channels the factor gives pascal; force is pressure times the film area (attribute `film_area`,
/// m2). The order is the scan order on the wire. Shared with firmware: no heap, no exceptions.
#define POWBENCH_CHANNELS(X)                                                                                \
  X(pvdf_a, "pressure0", "N", 1e3, "contact force, fixed contact A (PVDF film, charge amplifier)")          \
  X(pvdf_b, "pressure1", "N", 1e3, "contact force, fixed contact B (PVDF film, charge amplifier)")          \
  X(laser, "distance0", "m", 1.0, "travel of the moving core, positive in closing direction")               \
  X(coil_current, "current0", "A", 1e-3, "coil current")                                                    \
  X(coil_voltage, "voltage0", "V", 1e-3, "voltage at the coil terminals")                                   \
  X(mains_voltage, "voltage1", "V", 1e-3, "mains ahead of the coil switch")                                 \
  X(contact_a, "voltage2", "V", 1e-3, "contact-voltage of the measured pole: 6 V open, 0 V closed (10 mA)") \
  X(aux, "voltage3", "V", 1e-3, "auxiliary input; a base accelerometer on the simulated rig")

namespace powbench {

enum class Channel : std::uint8_t {
#define POWBENCH_X(name, id, unit, factor, meaning) name,
  POWBENCH_CHANNELS(POWBENCH_X)
#undef POWBENCH_X
};

struct ChannelInfo {
  std::string_view name;     ///< label on the wire, key in files and JSON
  std::string_view iio_id;   ///< IIO channel id
  std::string_view unit;     ///< SI unit of the value on the host
  double si_per_iio_unit;    ///< factor from the IIO unit to SI
  std::string_view meaning;  ///< one line for people
};

inline constexpr std::array channel_table{
#define POWBENCH_X(name, id, unit, factor, meaning) ChannelInfo{#name, id, unit, factor, meaning},
    POWBENCH_CHANNELS(POWBENCH_X)
#undef POWBENCH_X
};

inline constexpr std::size_t channel_count = channel_table.size();
constexpr const ChannelInfo& info(Channel c) {
  return channel_table[static_cast<std::size_t>(c)];
}
constexpr std::size_t index(Channel c) {
  return static_cast<std::size_t>(c);
}

}  // namespace powbench
