#include "firmware/bench_devices.h"

#include <utility>

#include "firmware/control_device.h"
#include "firmware/identity.h"
#include "firmware/sealed_shot.h"

namespace powbench::firmware {
namespace {

using iiod::Attribute;

const BenchDevices& devices(const void* self) {
  return *static_cast<const BenchDevices*>(self);
}
const Controller& bench(const void* self) {
  return devices(self).controller();
}
const FireControl& control_of(const void* self) {
  return bench(self).fire_control();
}

// ---- contactor-daq: channels ----

const ChannelCalibration& calibration(const void* self, std::uint32_t channel) {
  return bench(self).config().calibration[channel];
}
int read_scale(const void* self, std::uint32_t channel, Text& out) {
  return out.put_fixed(calibration(self, channel).scale_pico, 12), 0;
}
int read_raw(const void* self, std::uint32_t channel, Text& out) {
  return out.put_int(bench(self).latest(static_cast<Channel>(channel))), 0;
}
int read_label(const void*, std::uint32_t channel, Text& out) {
  return out.put(channel_table[channel].name), 0;
}
/// (raw + offset) * scale: the reading at zero, with the other sign.
int read_offset(const void* self, std::uint32_t channel, Text& out) {
  return out.put_int(-calibration(self, channel).zero_counts), 0;
}
int read_delay(const void* self, std::uint32_t channel, Text& out) {
  return out.put_int(calibration(self, channel).delay_ns), 0;
}
int read_corner(const void* self, std::uint32_t channel, Text& out) {
  return out.put_fixed(calibration(self, channel).corner_microhertz, 6), 0;
}
int read_film_area(const void* self, std::uint32_t channel, Text& out) {
  return out.put_fixed(calibration(self, channel).film_area_pico, 12), 0;
}
int read_sensitivity(const void* self, std::uint32_t channel, Text& out) {
  return out.put_fixed(calibration(self, channel).sensitivity_femto, 15), 0;
}

template <std::uint32_t C>
constexpr std::array force_attributes{Attribute{"charge_sensitivity", read_sensitivity, nullptr, C},
                                      Attribute{"corner_frequency", read_corner, nullptr, C},
                                      Attribute{"delay_ns", read_delay, nullptr, C},
                                      Attribute{"film_area", read_film_area, nullptr, C},
                                      Attribute{"label", read_label, nullptr, C},
                                      Attribute{"offset", read_offset, nullptr, C},
                                      Attribute{"raw", read_raw, nullptr, C},
                                      Attribute{"scale", read_scale, nullptr, C}};
template <std::uint32_t C>
constexpr std::array plain_attributes{
    Attribute{"delay_ns", read_delay, nullptr, C}, Attribute{"label", read_label, nullptr, C},
    Attribute{"offset", read_offset, nullptr, C}, Attribute{"raw", read_raw, nullptr, C},
    Attribute{"scale", read_scale, nullptr, C}};

template <std::uint32_t C>
constexpr iiod::Channel scan_channel() {
  iiod::Channel channel{.id = channel_table[C].iio_id, .scan_index = static_cast<int>(C)};
  if constexpr (channel_table[C].unit == "N")
    channel.attributes = force_attributes<C>;
  else
    channel.attributes = plain_attributes<C>;
  return channel;
}

template <std::size_t... C>
constexpr auto scan_channels(std::index_sequence<C...>) {
  return std::array<iiod::Channel, sizeof...(C) + 1>{
      scan_channel<C>()...,
      iiod::Channel{.id = "timestamp", .scan_index = static_cast<int>(sizeof...(C)), .bits = 64}};
}
constexpr auto daq_channels = scan_channels(std::make_index_sequence<channel_count>{});

// ---- contactor-daq: device ----

/// Doubts about the record: words, or "none".
int read_marks(const void* self, std::uint32_t, Text& out) {
  const unsigned marks = bench(self).recorder().marks();
  if (marks == 0) return out.put("none"), 0;
  constexpr std::array<std::string_view, mark_count> names{"laser_range", "force_saturated",
                                                           "contact_travel"};
  for (std::size_t m = 0; m < names.size(); ++m) {
    if ((marks >> m & 1U) == 0) continue;
    if (!out.view().empty()) out.put(' ');
    out.put(names[m]);
  }
  return 0;
}

/// 20301231, or "none": the calibration is none that was stored.
int put_day(std::uint32_t day, Text& out) {
  if (day == 0) return out.put("none"), 0;
  return out.put_unsigned(day), 0;
}

constexpr std::array daq_attributes{
    Attribute{"board_id",
              [](const void* s, std::uint32_t, Text& t) { return t.put(bench(s).identity().board_id), 0; }},
    Attribute{"calibration", [](const void* s, std::uint32_t,
                                Text& t) { return t.put(bench(s).config().calibration_id), 0; }},
    Attribute{"calibration_date",
              [](const void* s, std::uint32_t, Text& t) { return put_day(bench(s).certificate().date, t); }},
    Attribute{"calibration_expires", [](const void* s, std::uint32_t,
                                        Text& t) { return put_day(bench(s).certificate().expires, t); }},
    Attribute{"config_crc32", [](const void* s, std::uint32_t,
                                 Text& t) { return t.put_hex32(config_crc32(bench(s).config())), 0; }},
    Attribute{"fire_offset_ns",
              [](const void* s, std::uint32_t, Text& t) { return t.put_int(fire_offset_ns(bench(s))), 0; }},
    Attribute{"fire_sample", [](const void* s, std::uint32_t,
                                Text& t) { return t.put_int(bench(s).recorder().fire_sample()), 0; }},
    Attribute{"fw_commit",
              [](const void* s, std::uint32_t, Text& t) { return t.put(bench(s).identity().commit), 0; }},
    Attribute{"gaps",
              [](const void* s, std::uint32_t, Text& t) {
                if (bench(s).recorder().gaps().empty()) t.put("none");
                for (const auto& gap : bench(s).recorder().gaps()) {
                  if (!t.view().empty()) t.put(' ');
                  t.put_int(gap.first).put(':').put_int(gap.count);
                }
                return 0;
              }},
    Attribute{"image_crc32", [](const void* s, std::uint32_t,
                                Text& t) { return t.put_hex32(bench(s).identity().image_crc32), 0; }},
    Attribute{"mains_frequency",
              [](const void* s, std::uint32_t, Text& t) {
                return t.put_fixed(
                           static_cast<std::int64_t>(control_of(s).phase().frequency * 1000.0F + 0.5F), 3),
                       0;
              }},
    Attribute{"overruns", [](const void* s, std::uint32_t,
                             Text& t) { return t.put_int(bench(s).recorder().overruns()), 0; }},
    Attribute{"pretrigger", [](const void* s, std::uint32_t,
                               Text& t) { return t.put_int(bench(s).recorder().pretrigger()), 0; }},
    Attribute{"record_crc32", [](const void* s, std::uint32_t,
                                 Text& t) { return t.put_hex32(bench(s).recorder().crc()), 0; }},
    Attribute{"record_length", [](const void* s, std::uint32_t,
                                  Text& t) { return t.put_int(bench(s).recorder().length()), 0; }},
    Attribute{"record_marks", read_marks},
    Attribute{"sampling_frequency", [](const void* s, std::uint32_t,
                                       Text& t) { return t.put_int(bench(s).config().sample_rate), 0; }},
    Attribute{
        "sampling_frequency_available",
        [](const void* s, std::uint32_t, Text& t) { return t.put_int(bench(s).config().sample_rate), 0; }},
    Attribute{"sealed_shot",
              [](const void* s, std::uint32_t, Text& t) {
                return write_sealed_shot(bench(s), devices(s).source(), devices(s).identity(), t);
              }},
    Attribute{"shot_id", [](const void* s, std::uint32_t,
                            Text& t) { return t.put_int(control_of(s).shots_armed()), 0; }},
    Attribute{"zero_cross_sample", [](const void* s, std::uint32_t, Text& t) {
                return t.put_int(control_of(s).zero_cross_sample() - bench(s).recorder().first_sample()), 0;
              }}};

constexpr std::array daq_buffer_attributes{
    Attribute{"data_available",
              [](const void* s, std::uint32_t, Text& t) {
                return t.put_int(static_cast<std::int64_t>(bench(s).recorder().available(0))), 0;
              }},
    Attribute{"watermark", [](const void*, std::uint32_t, Text& t) { return t.put('1'), 0; }}};

constexpr std::array trigger_attributes{Attribute{"trigger_now", read_zero, write_fire}};

}  // namespace

BenchDevices::BenchDevices(Controller& controller, const SetPoints* source)
    : controller_(controller),
      set_points_(source),
      daq_{.id = "iio:device0",
           .name = "contactor-daq",
           .label = "record",
           .channels = daq_channels,
           .attributes = daq_attributes,
           .buffer_attributes = daq_buffer_attributes,
           .self = this,
           .buffer = &controller.recorder(),
           .has_trigger = true},
      control_{.id = "iio:device1",
               .name = "contactor-ctl",
               .label = "control",
               .channels = control_channels,
               .attributes = control_attributes,
               .self = this},
      trigger_{
          .id = "trigger0", .name = "fire", .label = "", .attributes = trigger_attributes, .self = this} {}

}  // namespace powbench::firmware
