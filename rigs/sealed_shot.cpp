#include "rigs/sealed_shot.h"

#include <charconv>
#include <cmath>

#include "core/crc32.h"

namespace powbench::rigs {
namespace {

constexpr std::string_view seal_key = " seal=";
constexpr std::int64_t longest_record =
    100'000'000;  // scans; far beyond any memory, so that products do not overflow

[[noreturn]] void fail(const std::string& why) {
  throw SealError("the rig's sealed shot " + why);
}

std::uint32_t parse_hex(std::string_view text) {
  std::uint32_t value = 0;
  const auto [stop, error] = std::from_chars(text.data(), text.data() + text.size(), value, 16);
  if (text.size() != 8 || error != std::errc{} || stop != text.data() + text.size())
    fail("has '" + std::string(text) + "' for eight hexadecimal digits");
  return value;
}

std::int64_t parse_number(std::string_view text) {
  std::int64_t value = 0;
  const auto [stop, error] = std::from_chars(text.data(), text.data() + text.size(), value);
  if (error != std::errc{} || stop != text.data() + text.size())
    fail("has '" + std::string(text) + "' for a number");
  return value;
}

/// `digits` times 10^`exponent`, rounded once.
double scaled(std::string_view digits, int exponent) {
  parse_number(digits);
  const std::string text = std::string(digits) + "e" + std::to_string(exponent);
  double value = std::nan("");
  std::from_chars(text.data(), text.data() + text.size(), value);
  if (!std::isfinite(value)) fail("has '" + text + "' for a number");
  return value;
}

std::string unescape(std::string_view text) {
  std::string out;
  for (std::size_t i = 0; i < text.size(); ++i) {
    if (text[i] != '%') {
      out += text[i];
      continue;
    }
    unsigned byte = 0;
    const char* from = text.data() + i + 1;
    if (i + 3 > text.size() || std::from_chars(from, from + 2, byte, 16).ptr != from + 2)
      fail("has a damaged text");
    out += static_cast<char>(byte);
    i += 2;
  }
  return out;
}

/// key=value pairs, which must come in the order they are asked for.
class Pairs {
 public:
  explicit Pairs(std::string_view text) : rest_(text) {}

  bool next_is(std::string_view key) const {
    return rest_.size() > key.size() && rest_.starts_with(key) && rest_[key.size()] == '=';
  }
  std::string_view take(std::string_view key) {
    if (!next_is(key)) fail("misses " + std::string(key));
    rest_.remove_prefix(key.size() + 1);
    const std::size_t end = rest_.find(' ');
    const std::string_view value = rest_.substr(0, end);
    rest_.remove_prefix(end == std::string_view::npos ? rest_.size() : end + 1);
    return value;
  }
  std::int64_t number(std::string_view key, std::int64_t least, std::int64_t most) {
    const std::int64_t value = parse_number(take(key));
    if (value < least || value > most) fail("has " + std::to_string(value) + " for " + std::string(key));
    return value;
  }
  std::string text(std::string_view key) { return unescape(take(key)); }
  bool empty() const { return rest_.empty(); }

 private:
  std::string_view rest_;
};

/// Up to the next `separator`; the text loses it.
std::string_view take_until(std::string_view& text, char separator) {
  const std::size_t end = text.find(separator);
  const std::string_view part = text.substr(0, end);
  text = end == std::string_view::npos ? std::string_view{} : text.substr(end + 1);
  return part;
}

std::vector<Gap> parse_gaps(std::string_view text, std::int64_t samples) {
  std::vector<Gap> gaps;
  if (text == "none") return gaps;
  while (!text.empty()) {
    std::string_view pair = take_until(text, ',');
    Gap gap;
    gap.first = parse_number(take_until(pair, ':'));
    gap.count = parse_number(pair);
    if (gap.first < 0 || gap.count < 1 || gap.first >= samples || gap.count > samples - gap.first)
      fail("has a gap outside of the record");
    gaps.push_back(gap);
  }
  return gaps;
}

/// SCALE:OFFSET:DELAY:CORNER:AREA
ChannelRecord parse_channel(std::size_t number, std::string_view text) {
  const ChannelInfo& row = channel_table[number];
  ChannelRecord c;
  c.channel = static_cast<Channel>(number);
  c.scale = scaled(take_until(text, ':'), -12) * row.si_per_iio_unit;
  c.offset = scaled(take_until(text, ':'), 0);
  c.delay = 1e-9 * scaled(take_until(text, ':'), 0);
  const double corner = scaled(take_until(text, ':'), -6), area = scaled(text, -12);
  if (row.unit == "N") {
    c.scale *= area;
    c.corner_hertz = corner;
  }
  if (c.scale == 0.0 || corner < 0.0 || std::fabs(c.offset) > 65536.0 || std::fabs(c.delay) > 1.0)
    fail("has values out of range for " + std::string(row.name));
  return c;
}

void parse_record(Pairs& pairs, SealedShot& s) {
  s.fire_sample = pairs.number("fire_sample", 0, s.samples - 1);
  s.fire_offset_ns = pairs.number("fire_offset_ns", 0, 1'000'000'000 / s.sample_rate);
  if (pairs.next_is("angle_u_mdeg")) s.angle_u_mdeg = pairs.number("angle_u_mdeg", 0, 360'000);
  s.gaps = parse_gaps(pairs.take("gaps"), s.samples);
  s.overruns = pairs.number("overruns", 0, s.samples);
  s.marks = pairs.number("marks", 0, 255);
  s.record_crc = parse_hex(pairs.take("record_crc"));
  for (std::size_t c = 0; c < channel_count; ++c)
    s.channels.push_back(parse_channel(c, pairs.take(channel_table[c].iio_id)));
}

}  // namespace

SealedShot parse_sealed_shot(std::string_view text) {
  const std::size_t seal = text.rfind(seal_key);
  if (seal == std::string_view::npos) fail("has no seal");
  const std::string_view body = text.substr(0, seal);
  if (crc32({reinterpret_cast<const std::uint8_t*>(body.data()), body.size()}) !=
      parse_hex(text.substr(seal + seal_key.size())))
    fail("does not match its seal");
  Pairs pairs(body);
  SealedShot s;
  s.text = text;
  pairs.number("powbench_shot", 1, 1);
  s.stage = pairs.text("stage");
  s.boot = pairs.text("boot");
  s.shot = pairs.number("shot", 1, 0xFFFFFFFF);
  s.model = pairs.text("model");
  s.serial = pairs.text("serial");
  s.firmware = pairs.text("firmware");
  s.commit = pairs.text("commit");
  s.board = pairs.text("board");
  s.image_crc32 = parse_hex(pairs.take("image"));
  s.config_crc32 = parse_hex(pairs.take("config"));
  s.calibration = pairs.text("calibration");
  s.angle_centideg = pairs.number("angle_centideg", 0, 35'999);
  s.hold_ms = pairs.number("hold_ms", 1, 10'000);
  s.touch_us = pairs.number("touch_us", 0, 50'000);
  s.tolerance_mdeg = pairs.number("tolerance_mdeg", 10, 90'000);
  if (pairs.next_is("supply_mv")) {
    firmware::SetPoints source;
    constexpr std::int64_t most = 1'000'000'000'000'000'000;
    source.supply_millivolts = pairs.number("supply_mv", 0, most);
    source.mains_millihertz = pairs.number("mains_mhz", 0, most);
    source.ambient_millidegc = pairs.number("ambient_mdegc", -most, most);
    source.seed = pairs.number("seed", 0, most);
    s.source = source;
  }
  s.sample_rate = pairs.number("sample_rate", 1, 1'000'000'000);
  s.samples = pairs.number("samples", 1, longest_record);
  if (s.complete()) parse_record(pairs, s);
  if (!pairs.empty()) fail("has more than it should");
  return s;
}

Record to_record(const SealedShot& s) {
  Record r;
  r.sample_rate = static_cast<double>(s.sample_rate);
  r.fire_sample = s.fire_sample;
  r.fire_offset = 1e-9 * static_cast<double>(s.fire_offset_ns);
  r.channels = s.channels;
  r.gaps = s.gaps;
  r.overruns = static_cast<std::uint32_t>(s.overruns);
  r.crc32 = s.record_crc;
  r.shot_id = static_cast<std::uint64_t>(s.shot);
  r.rig = s.model + ", " + s.serial;
  r.firmware = s.firmware;
  r.calibration = s.calibration;
  r.sealed = s.text;
  return r;
}

}  // namespace powbench::rigs
