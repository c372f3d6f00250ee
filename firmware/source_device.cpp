#include "firmware/source_device.h"

#include "firmware/commands.h"

#include <array>

namespace powbench::firmware {
namespace {

using iiod::Attribute;

struct SetPointRow {
  std::int64_t SetPoints::*field;
  std::int64_t least, most;
};
constexpr std::array set_point_rows{
    SetPointRow{&SetPoints::ambient_millidegc, -40'000, 85'000},
    SetPointRow{&SetPoints::mains_millihertz, 40'000, 70'000},
    SetPointRow{&SetPoints::seed, 0, 999'999'999'999'999'999},
    SetPointRow{&SetPoints::supply_millivolts, 0, 300'000},
};

const SourceDevice& source(const void* self) {
  return *static_cast<const SourceDevice*>(self);
}

int read_set_point(const void* self, std::uint32_t row, Text& out) {
  return out.put_int(source(self).set_points.*set_point_rows[row].field), 0;
}

int write_set_point(void* self, std::uint32_t row, std::string_view value) {
  Controller& controller = static_cast<SourceDevice*>(self)->controller;
  if (const int error = admit(controller, value); error != 0) return error;
  const auto number = parse_int(value);
  if (!number) return -iiod::einval;
  if (controller.fire_control().set_points_latched()) return -iiod::ebusy;
  if (*number < set_point_rows[row].least || *number > set_point_rows[row].most) return -iiod::erange;
  static_cast<SourceDevice*>(self)->set_points.*set_point_rows[row].field = *number;
  return 0;
}

/// CHANNEL:MICRO, in 1e-6 of the channel's SI unit, or "none".
int read_reference(const void* self, std::uint32_t, Text& out) {
  const SetPoints& s = source(self).set_points;
  if (s.reference_channel < 0) return out.put("none"), 0;
  out.put(channel_table[static_cast<std::size_t>(s.reference_channel)].name)
      .put(':')
      .put_int(s.reference_micro);
  return 0;
}
int write_reference(void* self, std::uint32_t, std::string_view value) {
  Controller& controller = static_cast<SourceDevice*>(self)->controller;
  if (const int error = admit(controller, value); error != 0) return error;
  if (controller.fire_control().set_points_latched()) return -iiod::ebusy;
  SetPoints& s = static_cast<SourceDevice*>(self)->set_points;
  if (value == "none") return s.reference_channel = -1, 0;
  for (std::size_t c = 0; c < channel_count; ++c) {
    const std::string_view name = channel_table[c].name;
    if (!value.starts_with(name) || value.size() <= name.size() || value[name.size()] != ':') continue;
    value.remove_prefix(name.size() + 1);
    const auto micro = parse_int(value);
    if (!micro) return -iiod::einval;
    if (*micro < -1'000'000'000'000 || *micro > 1'000'000'000'000) return -iiod::erange;
    s.reference_channel = static_cast<std::int64_t>(c);
    s.reference_micro = *micro;
    return 0;
  }
  return -iiod::einval;
}

int put_ns(std::int64_t ns, Text& out) {
  if (ns == PlantTruth::none) return out.put("none"), 0;
  return out.put_int(ns), 0;
}

constexpr std::array attributes{
    Attribute{"ambient_millidegc", read_set_point, write_set_point, 0},
    Attribute{"mains_millihertz", read_set_point, write_set_point, 1},
    Attribute{"reference", read_reference, write_reference},
    Attribute{"seed", read_set_point, write_set_point, 2},
    Attribute{"specimen", [](const void* s, std::uint32_t, Text& t) { return t.put(source(s).specimen), 0; }},
    Attribute{"supply_millivolts", read_set_point, write_set_point, 3},
    Attribute{"truth_seat_ns",
              [](const void* s, std::uint32_t, Text& t) { return put_ns(source(s).truth.seat_ns, t); }},
    Attribute{"truth_settled_ns",
              [](const void* s, std::uint32_t, Text& t) { return put_ns(source(s).truth.settled_ns, t); }},
    Attribute{"truth_touch_ns",
              [](const void* s, std::uint32_t, Text& t) { return put_ns(source(s).truth.touch_ns, t); }},
};

}  // namespace

SourceDevice::SourceDevice(std::string_view name, Controller& owner)
    : specimen(name),
      controller(owner),
      device_{.id = "iio:device2",
              .name = "contactor-plant",
              .label = "plant",
              .attributes = attributes,
              .self = this} {}

}  // namespace powbench::firmware
