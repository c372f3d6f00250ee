#include "firmware/sealed_shot.h"

#include "core/crc32.h"
#include "firmware/identity.h"

namespace powbench::firmware {
namespace {

bool plain(char c) {
  return (c >= '0' && c <= '9') || (c >= 'a' && c <= 'z') || (c >= 'A' && c <= 'Z') || c == '.' || c == '_' ||
         c == ':' || c == '+' || c == '-';
}

/// key=value pairs.
class Pairs {
 public:
  explicit Pairs(Text& out) : out_(out) {}

  [[gnu::noinline]] Pairs& text(std::string_view key, std::string_view value) {
    begin(key);
    for (const char c : value) {
      const auto byte = static_cast<unsigned char>(c);
      if (plain(c))
        out_.put(c);
      else
        out_.put('%').put("0123456789abcdef"[byte >> 4]).put("0123456789abcdef"[byte & 15U]);
    }
    return *this;
  }
  [[gnu::noinline]] Pairs& number(std::string_view key, std::int64_t value) {
    begin(key).put_int(value);
    return *this;
  }
  [[gnu::noinline]] Text& begin(std::string_view key) {
    if (!out_.view().empty()) out_.put(' ');
    return out_.put(key).put('=');
  }

 private:
  Text& out_;
};

void put_gaps(const Recorder& recorder, Text& out) {
  if (recorder.gaps().empty()) out.put("none");
  bool first = true;
  for (const auto& gap : recorder.gaps()) {
    if (!first) out.put(',');
    first = false;
    out.put_int(gap.first).put(':').put_int(gap.count);
  }
}

void put_record(const Controller& controller, Pairs& pairs) {
  const Recorder& recorder = controller.recorder();
  pairs.number("fire_sample", recorder.fire_sample()).number("fire_offset_ns", fire_offset_ns(controller));
  pairs.number("angle_u_mdeg", to_millidegrees(controller.fire_control().angle_deviation()));
  put_gaps(recorder, pairs.begin("gaps"));
  pairs.number("overruns", recorder.overruns()).number("marks", recorder.marks());
  pairs.begin("record_crc").put_hex32(recorder.crc());
  for (std::size_t c = 0; c < channel_count; ++c) {
    const ChannelCalibration& row = controller.config().calibration[c];
    const bool force = channel_table[c].unit == "N";
    Text& out = pairs.begin(channel_table[c].iio_id);
    out.put_int(row.scale_pico).put(':').put_int(-row.zero_counts).put(':').put_int(row.delay_ns);
    out.put(':').put_int(force ? row.corner_microhertz : 0).put(':').put_int(force ? row.film_area_pico : 0);
  }
}

}  // namespace

std::string_view identity_value(std::span<const iiod::ContextAttribute> identity, std::string_view name) {
  for (const auto& attribute : identity)
    if (attribute.name == name) return attribute.value;
  return {};
}

std::int64_t fire_offset_ns(const Controller& controller) {
  const Tick edge = controller.recorder().edge();
  const std::int64_t period_ns = 1'000'000'000 / controller.config().sample_rate;
  const std::int64_t rest = edge.fraction == 0 ? 0 : 65536 - edge.fraction;
  return rest * period_ns / 65536;
}

int write_sealed_shot(const Controller& controller, const SetPoints* source,
                      std::span<const iiod::ContextAttribute> identity, Text& out) {
  const FireControl& fire = controller.fire_control();
  const bool complete = controller.recorder().complete() && fire.state() != State::firing;
  const LatchedShot& shot = fire.latched();
  if (shot.number == 0 || (!complete && !fire.set_points_latched())) return out.put("none"), 0;
  Pairs pairs(out);
  pairs.number("powbench_shot", 1).text("stage", complete ? "complete" : name(fire.state()));
  pairs.text("boot", identity_value(identity, "boot_id")).number("shot", shot.number);
  pairs.text("model", identity_value(identity, "hw_model"))
      .text("serial", identity_value(identity, "hw_serial"));
  pairs.text("firmware", identity_value(identity, "fw_version"));
  const ShotIdentity made = shot_identity(controller);
  pairs.text("commit", made.build.commit).text("board", made.build.board_id);
  pairs.begin("image").put_hex32(made.build.image_crc32);
  pairs.begin("config").put_hex32(made.config_crc32);
  pairs.text("calibration", made.calibration_id);
  pairs.number("angle_centideg", shot.closing_angle).number("hold_ms", shot.hold_time_ms);
  pairs.number("touch_us", shot.touch_delay_us).number("tolerance_mdeg", shot.tolerance_millideg);
  if (source) {
    pairs.number("supply_mv", source->supply_millivolts).number("mains_mhz", source->mains_millihertz);
    pairs.number("ambient_mdegc", source->ambient_millidegc).number("seed", source->seed);
  }
  pairs.number("sample_rate", controller.config().sample_rate);
  pairs.number("samples", controller.recorder().length());
  if (complete) put_record(controller, pairs);
  const std::string_view text = out.view();
  const std::uint32_t seal = crc32({reinterpret_cast<const std::uint8_t*>(text.data()), text.size()});
  pairs.begin("seal").put_hex32(seal);
  return out.overflowed() ? -iiod::eoverflow : 0;
}

}  // namespace powbench::firmware
