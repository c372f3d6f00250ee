#include "firmware/control_device.h"

#include <utility>

#include "firmware/bench_devices.h"
#include "firmware/commands.h"

/// `contactor-ctl`: state, set-points, actions.

namespace powbench::firmware {
namespace {

using iiod::Attribute;

const Controller& bench(const void* self) {
  return static_cast<const BenchDevices*>(self)->controller();
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
constexpr std::array channels{iiod::Channel{.id = "phase0", .output = true, .attributes = angle_attributes}};

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
int write_hold(void* self, std::uint32_t, std::string_view value) {
  return write_set_point(self, value, [](FireControl& f, std::int64_t v) { return f.set_hold_time_ms(v); });
}
int write_touch_delay(void* self, std::uint32_t, std::string_view value) {
  return write_set_point(self, value, [](FireControl& f, std::int64_t v) { return f.set_touch_delay_us(v); });
}

int write_tolerance(void* self, std::uint32_t, std::string_view value) {
  return write_set_point(self, value,
                         [](FireControl& f, std::int64_t v) { return f.set_angle_tolerance(v); });
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
      fire.note_refusal(not_the_owner);
      return -iiod::ebusy;
    case Lease::Claim::malformed:
      return -iiod::einval;
    case Lease::Claim::forbidden:
      fire.note_refusal("refused: this rig wants its secret and a dot in front of the token");
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

/// Whether an arm would be accepted now: "yes", or the sentence it would be refused with.
int read_ready(const void* self, std::uint32_t, Text& out) {
  const std::string_view why = control_of(self).obstacle();
  return out.put(why.empty() ? "yes" : why), 0;
}

/// The latched fault: its number in docs/reference/faults.md and its name, or "0 none".
int read_fault(const void* self, std::uint32_t, Text& out) {
  const Fault fault = control_of(self).fault();
  out.put_int(static_cast<int>(fault)).put(' ').put(fault == Fault::none ? "none" : info(fault).name);
  return 0;
}

/// Bits and words: what is wrong with the mains.
int read_phase_faults(const void* self, std::uint32_t, Text& out) {
  const std::uint16_t faults = control_of(self).phase().faults;
  out.put_int(faults);
  for (std::size_t bit = 0; bit < phase_fault_names.size(); ++bit)
    if ((faults >> bit & 1U) != 0) out.put(' ').put(phase_fault_names[bit]);
  if (faults == 0) out.put(" none");
  return 0;
}

/// Standard uncertainty of the phase now and 20 ms ahead.
int read_phase_uncertainty(const void* self, std::uint32_t, Text& out) {
  const PhaseEstimate& phase = control_of(self).phase();
  out.put_int(to_millidegrees(phase.deviation(0.0F))).put(' ');
  out.put_int(to_millidegrees(phase.deviation(PhaseEstimate::ahead_seconds)));
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

// ---- calibration ----

/// The word up to the next colon; the text loses both.
[[gnu::noinline]] std::string_view take_part(std::string_view& text) {
  std::size_t end = 0;
  while (end < text.size() && text[end] != ':') ++end;
  const std::string_view part{text.data(), end};
  text.remove_prefix(end < text.size() ? end + 1 : end);
  return part;
}

/// Checksum of the draft's rows.
int read_calibration_draft(const void* self, std::uint32_t, Text& out) {
  return out.put_hex32(rows_crc32(bench(self).calibrations().draft().rows)), 0;
}
/// CHANNEL:SCALE:ZERO:DELAY:CORNER:AREA:SENSITIVITY, in the units of ChannelCalibration.
int write_calibration_draft(void* self, std::uint32_t, std::string_view value) {
  if (const int error = admit(bench(self), value); error != 0) return error;
  const std::string_view name = take_part(value);
  std::size_t channel = 0;
  while (channel < channel_count && channel_table[channel].name != name) ++channel;
  if (channel == channel_count) return -iiod::einval;
  ChannelCalibration row;
  for (std::int64_t* field : {&row.scale_pico, &row.zero_counts, &row.delay_ns, &row.corner_microhertz,
                              &row.film_area_pico, &row.sensitivity_femto}) {
    const auto number = parse_int(take_part(value));
    if (!number) return -iiod::einval;
    *field = *number;
  }
  if (!value.empty()) return -iiod::einval;
  return to_errno(bench(self).draft(channel, row));
}

/// What the memory holds, and which write it was.
int read_calibration_store(const void* self, std::uint32_t, Text& out) {
  constexpr std::array<std::string_view, 7> words{"no_memory", "none",    "stored",      "one_slot_damaged",
                                                  "damaged",   "writing", "write_failed"};
  const CalibrationStore& store = bench(self).calibrations();
  out.put(words[static_cast<std::size_t>(store.state())]).put(' ').put_unsigned(store.number());
  return 0;
}
/// ID:DATE:EXPIRES:SWITCH_DELAY_NS:CHECKSUM, the last eight hexadecimal digits as read from calibration_draft.
int write_calibration_store(void* self, std::uint32_t, std::string_view value) {
  if (const int error = admit(bench(self), value); error != 0) return error;
  Certificate certificate;
  const std::string_view id = take_part(value);
  const auto date = parse_int(take_part(value)), expires = parse_int(take_part(value));
  const auto delay = parse_int(take_part(value));
  if (!usable_certificate(id) || !date || !expires || !delay) return -iiod::einval;
  if (!is_day(*date) || !is_day(*expires) || *expires < *date) return -iiod::erange;
  for (const char letter : id) certificate.id[certificate.id_size++] = letter;
  certificate.date = static_cast<std::uint32_t>(*date);
  certificate.expires = static_cast<std::uint32_t>(*expires);
  TextOf<8> checksum;
  checksum.put_hex32(rows_crc32(bench(self).calibrations().draft().rows));
  if (value != checksum.view()) return -iiod::einval;
  return to_errno(bench(self).propose(certificate, *delay));
}

constexpr std::array attributes{
    Attribute{"abort", read_zero, write_abort},
    Attribute{"angle_tolerance_millideg",
              [](const void* s, std::uint32_t, Text& t) {
                return t.put_int(control_of(s).tolerance_millideg()), 0;
              },
              write_tolerance},
    Attribute{"angle_tolerance_millideg_available",
              [](const void*, std::uint32_t, Text& t) { return t.put("[10 1 90000]"), 0; }},
    Attribute{"arm",
              [](const void* s, std::uint32_t, Text& t) {
                return t.put(control_of(s).state() == State::armed ? '1' : '0'), 0;
              },
              write_arm},
    Attribute{"calibration_draft", read_calibration_draft, write_calibration_draft},
    Attribute{"calibration_store", read_calibration_store, write_calibration_store},
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
    Attribute{"phase_faults", read_phase_faults},
    Attribute{"phase_u_millideg", read_phase_uncertainty},
    Attribute{"ready", read_ready},
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

}  // namespace

int read_zero(const void*, std::uint32_t, Text& out) {
  return out.put('0'), 0;
}

int write_fire(void* self, std::uint32_t, std::string_view value) {
  if (const int error = admit(bench(self), value); error != 0) return error;
  if (parse_int(value) != 1) return -iiod::einval;
  return to_errno(control_of(self).fire(), iiod::eagain);
}

const std::span<const iiod::Channel> control_channels = channels;
const std::span<const iiod::Attribute> control_attributes = attributes;

}  // namespace powbench::firmware
