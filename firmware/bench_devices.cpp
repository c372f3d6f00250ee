#include "firmware/bench_devices.h"

#include <utility>

#include "firmware/commands.h"
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
Controller& bench(void* self) {
  return static_cast<BenchDevices*>(self)->controller();
}
FireControl& control_of(void* self) {
  return bench(self).fire_control();
}
const FireControl& control_of(const void* self) {
  return bench(self).fire_control();
}

int to_errno(Refusal refusal, int wrong_state = iiod::ebusy) {
  switch (refusal) {
    case Refusal::accepted:
      return 0;
    case Refusal::wrong_state:
      return -wrong_state;
    case Refusal::out_of_range:
      return -iiod::erange;
    case Refusal::faulted:
      return -iiod::eperm;
  }
  return -iiod::einval;
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
int read_zero(const void*, std::uint32_t, Text& out) {
  return out.put('0'), 0;
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

constexpr std::array daq_attributes{
    Attribute{"board_id",
              [](const void* s, std::uint32_t, Text& t) { return t.put(bench(s).identity().board_id), 0; }},
    Attribute{"calibration", [](const void* s, std::uint32_t,
                                Text& t) { return t.put(bench(s).config().calibration_id), 0; }},
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

// ---- contactor-ctl ----

int read_angle(const void* self, std::uint32_t, Text& out) {
  return out.put_int(control_of(self).closing_angle()), 0;
}
/// A set-point from its owner, as a whole number.
int write_set_point(void* self, std::string_view value, Refusal (*set)(FireControl&, std::int64_t)) {
  if (const int error = admit(bench(self), value); error != 0) return error;
  const auto number = parse_int(value);
  return number ? to_errno(set(control_of(self), *number)) : -iiod::einval;
}
int write_angle(void* self, std::uint32_t, std::string_view value) {
  return write_set_point(self, value, [](FireControl& f, std::int64_t v) { return f.set_closing_angle(v); });
}
constexpr std::array angle_attributes{
    Attribute{"label", [](const void*, std::uint32_t, Text& t) { return t.put("closing_angle"), 0; }},
    Attribute{"raw", read_angle, write_angle},
    Attribute{"raw_available", [](const void*, std::uint32_t, Text& t) { return t.put("[0 1 35999]"), 0; }},
    Attribute{"scale", [](const void*, std::uint32_t, Text& t) { return t.put("0.000174532925"), 0; }}};
constexpr std::array control_channels{
    iiod::Channel{.id = "phase0", .output = true, .attributes = angle_attributes}};

/// 1 stops the coil, whoever writes it; what goes beyond stopping is the owner's, or anybody's while there is none.
int write_abort(void* self, std::uint32_t, std::string_view value) {
  std::string_view token = value;
  if (parse_int(take_word(token)) != 1) return -iiod::einval;
  const Lease& lease = bench(self).lease();
  if (!lease.held() || lease.is_owner(token))
    control_of(self).abort();
  else
    control_of(self).stop();
  return 0;
}
int write_arm(void* self, std::uint32_t, std::string_view value) {
  if (const int error = admit(bench(self), value); error != 0) return error;
  if (parse_int(value) == 0) return to_errno(control_of(self).disarm());
  if (parse_int(value) != 1) return -iiod::einval;
  const Refusal refusal = control_of(self).arm();
  if (refusal == Refusal::accepted) static_cast<BenchDevices*>(self)->latch_source();
  return to_errno(refusal);
}
int write_fire(void* self, std::uint32_t, std::string_view value) {
  if (const int error = admit(bench(self), value); error != 0) return error;
  if (parse_int(value) != 1) return -iiod::einval;
  return to_errno(control_of(self).fire(), iiod::eagain);
}
int write_hold(void* self, std::uint32_t, std::string_view value) {
  return write_set_point(self, value, [](FireControl& f, std::int64_t v) { return f.set_hold_time_ms(v); });
}
int write_touch_delay(void* self, std::uint32_t, std::string_view value) {
  return write_set_point(self, value, [](FireControl& f, std::int64_t v) { return f.set_touch_delay_us(v); });
}

int read_lease(const void* self, std::uint32_t, Text& out) {
  const Lease& lease = bench(self).lease();
  if (!lease.held()) return out.put("free"), 0;
  out.put(lease.owner()).put(", ").put_int(lease.left_ms()).put(" ms left");
  return 0;
}
/// TOKEN MS [OWNER]; MS = 0 gives it back.
int write_lease(void* self, std::uint32_t, std::string_view value) {
  const std::string_view token = take_word(value);
  const auto ms = parse_int(take_word(value));
  Controller& controller = bench(self);
  FireControl& fire = controller.fire_control();
  Lease& lease = controller.lease();
  if (!ms) return -iiod::einval;
  if (*ms == 0) {
    if (!lease.is_owner(token) || fire.state() == State::firing) return -iiod::ebusy;
    fire.disarm();
    lease.give_back();
    return 0;
  }
  if (*ms < Lease::shortest_ms || *ms > Lease::longest_ms) return -iiod::erange;
  const bool was_free = !lease.held();
  switch (lease.claim(token, *ms, value)) {
    case Lease::Claim::taken:
      fire.note_stranger(not_the_owner);
      return -iiod::ebusy;
    case Lease::Claim::malformed:
      return -iiod::einval;
    case Lease::Claim::forbidden:
      fire.note_stranger("refused: this rig wants its secret and a dot in front of the token");
      return -iiod::eperm;
    case Lease::Claim::granted:
      break;
  }
  if (was_free) fire.disarm();  // nothing of another owner is taken over
  return 0;
}

int read_last_error(const void* self, std::uint32_t, Text& out) {
  const std::string_view error = control_of(self).last_error();
  out.put(error);
  return error.data() == not_the_owner.data() ? read_lease(self, 0, out) : 0;
}

/// How the last capture of the coil's zero ended; writing 1 captures anew.
int read_zero_capture(const void* self, std::uint32_t, Text& out) {
  constexpr std::array<std::string_view, 5> words{"none", "capturing", "done", "current_flows",
                                                  "offset_too_large"};
  return out.put(words[static_cast<std::size_t>(bench(self).zero_state())]), 0;
}
int write_zero_capture(void* self, std::uint32_t, std::string_view value) {
  if (const int error = admit(bench(self), value); error != 0) return error;
  if (parse_int(value) != 1) return -iiod::einval;
  return to_errno(bench(self).capture_zero());
}

/// The latched fault: its number in docs/faults.md and its name, or "0 none".
int read_fault(const void* self, std::uint32_t, Text& out) {
  const Fault fault = control_of(self).fault();
  out.put_int(static_cast<int>(fault)).put(' ').put(fault == Fault::none ? "none" : info(fault).name);
  return 0;
}

/// What the last reset was; after a crash with its kind, program counter and link register.
int read_last_reset(const void* self, std::uint32_t, Text& out) {
  constexpr std::array<std::string_view, 5> causes{"power_on", "pin", "software", "watchdog", "brown_out"};
  constexpr std::array<std::string_view, 8> crashes{
      "none", "hard_fault", "memory_fault", "bus_fault", "usage_fault", "nmi", "assertion", "stack_overflow"};
  const FireControl& control = control_of(self);
  out.put(causes[static_cast<std::size_t>(control.reset_cause())]);
  const Survivor* kept = control.survivor();
  if (!kept || control.reset_cause() == ResetCause::power_on || !kept->has_crash()) return 0;
  out.put(' ').put(crashes[kept->cause]).put(" pc ").put_hex32(kept->program_counter);
  out.put(" lr ").put_hex32(kept->link_register);
  return 0;
}

constexpr std::array control_attributes{
    Attribute{"abort", read_zero, write_abort},
    Attribute{"arm",
              [](const void* s, std::uint32_t, Text& t) {
                return t.put(control_of(s).state() == State::armed ? '1' : '0'), 0;
              },
              write_arm},
    Attribute{"deadlines_missed", [](const void* s, std::uint32_t,
                                     Text& t) { return t.put_int(control_of(s).deadlines_missed()), 0; }},
    Attribute{"fault", read_fault},
    Attribute{"fire", read_zero, write_fire},
    Attribute{"gate", [](const void* s, std::uint32_t,
                         Text& t) { return t.put(control_of(s).gate_on() ? '1' : '0'), 0; }},
    Attribute{
        "hold_time_ms",
        [](const void* s, std::uint32_t, Text& t) { return t.put_int(control_of(s).hold_time_ms()), 0; },
        write_hold},
    Attribute{"hold_time_ms_available",
              [](const void*, std::uint32_t, Text& t) { return t.put("[1 1 10000]"), 0; }},
    Attribute{"last_error", read_last_error},
    Attribute{"last_reset", read_last_reset},
    Attribute{"lease", read_lease, write_lease},
    Attribute{"operations",
              [](const void* s, std::uint32_t, Text& t) { return t.put_int(control_of(s).operations()), 0; }},
    Attribute{"phase_faults", [](const void* s, std::uint32_t,
                                 Text& t) { return t.put_int(control_of(s).phase().faults), 0; }},
    Attribute{"safety_relay", [](const void* s, std::uint32_t,
                                 Text& t) { return t.put(control_of(s).relay_closed() ? '1' : '0'), 0; }},
    Attribute{"state",
              [](const void* s, std::uint32_t, Text& t) { return t.put(name(control_of(s).state())), 0; }},
    Attribute{"state_available", [](const void*, std::uint32_t,
                                    Text& t) { return t.put("idle armed firing captured fault"), 0; }},
    Attribute{
        "touch_delay_us",
        [](const void* s, std::uint32_t, Text& t) { return t.put_int(control_of(s).touch_delay_us()), 0; },
        write_touch_delay},
    Attribute{"touch_delay_us_available",
              [](const void*, std::uint32_t, Text& t) { return t.put("[0 1 50000]"), 0; }},
    Attribute{"zero_capture", read_zero_capture, write_zero_capture}};

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
