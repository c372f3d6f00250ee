#include "host/import/calibration.h"

#include <fmt/format.h>

#include <algorithm>
#include <cctype>
#include <cmath>

#include "core/commanded_phase.h"
#include "core/phase.h"
#include "host/config/bad_input.h"
#include "host/config/file_reader.h"
#include "host/config/test_record.h"
#include "host/import/dcc.h"
#include "host/import/foreign_table.h"

namespace powbench::host {

namespace {

/// Key of the gain: what one volt stands for.
std::string gain_key(Channel c) {
  const std::string_view unit = info(c).unit;
  return "gain_" + std::string(unit == "m" ? "mm" : unit) + "_per_V";
}

void declare_channel(FileKind& kind, Channel c, WaveformChannel& k) {
  kind.section(std::string(info(c).name), std::string(info(c).meaning));
  kind.number(gain_key(c), k.gain, {-1e9, 1e9},
              "of one volt, for a column in V; negative for a sensor that is upside down", Need::optional);
  if (info(c).unit != "V")
    kind.text("certificate", k.certificate,
              "digital calibration certificate (DCC, XML) beside this file that gives the gain");
  kind.number("delay_us", k.delay, {-1e5, 1e5}, "by how much the channel is late");
  kind.number("step", k.step, {1e-300, 1e12},
              "of the converter, in the column's unit, when all numbers are multiples of it", Need::optional);
  kind.number("clip_low", k.clip_low, {-1e12, 1e12}, "in the column's unit: at or below it is saturated",
              Need::optional);
  kind.number("clip_high", k.clip_high, {-1e12, 1e12}, "in the column's unit: at or above it is saturated",
              Need::optional);
  if (c != Channel::pvdf_a && c != Channel::pvdf_b) return;
  kind.number("corner_hertz", k.corner_hertz, {0, 1000},
              "low corner of the charge amplifier, whose droop is undone; 0 = coupled down to DC");
  kind.number("crosstalk_percent", k.crosstalk, {-50, 50},
              "share of the other film's force that this film shows");
}

/// Only for files of others: what this program writes has the names already.
void declare_columns(FileKind& kind, ForeignColumns& columns) {
  kind.section("columns",
               "what the columns of a foreign file are called there, as \"CH1 [V]\"; without [unit] the "
               "header's own counts");
  kind.text("time", columns[0], "the time column");
  for (std::size_t i = 0; i < channel_count; ++i)
    kind.text(std::string(channel_table[i].name), columns[1 + i], std::string(channel_table[i].meaning));
}

FileKind kind_of(Calibration& k, const std::vector<Channel>& channels, bool foreign = true) {
  FileKind kind("calibration", "what the numbers of a waveform file mean");
  kind.text("calibration", k.id, "name of the calibration in force; without it all results are flagged");
  kind.text("valid_until", k.valid_until, "its last day, as 2030-12-31; without it there is none");
  kind.text("source", k.source,
            "what made the record, where it was no contactor; page 1 of a report shows it");
  kind.text("recorded", k.recorded, "day of the record, as 2030-12-31; without it today");
  kind.number("switch_on_s", k.switch_on, {-1e12, 1e12}, "when the coil was switched on, on the time column");
  kind.number("hold_ms", k.hold_time, {1e-3, 1e7},
              "how long it stayed on; without it to where coil voltage or current ends, else to the end",
              Need::optional);
  kind.number("sample_rate_hertz", k.sample_rate, {1e3, 1e9},
              "instead of the time column's stamps; the first sample keeps its time", Need::optional);
  kind.number("mains_hertz", k.mains_hertz, {40, 70},
              "nominal mains frequency; without it 50 Hz is assumed to look for it", Need::optional);
  kind.number("closing_angle_deg", k.closing_angle, {0, 360},
              "commanded; stands where the record does not show it", Need::optional);
  if (foreign) declare_columns(kind, k.columns);
  for (const Channel c : channels) declare_channel(kind, c, k.channels[index(c)]);
  return kind;
}

std::vector<Channel> all_channels() {
  std::vector<Channel> list;
  for (std::size_t i = 0; i < channel_count; ++i) list.push_back(static_cast<Channel>(i));
  return list;
}

Calibration read_with(FileReader reader) {
  Calibration k;
  reader.read(kind_of(k, all_channels()));
  for (const auto& [key, text] : {std::pair{"valid_until", &k.valid_until}, {"recorded", &k.recorded}})
    if (!text->empty() && !is_day(*text)) reader.fail("", key, "is no day", "a day as 2030-12-31");
  for (const Channel c : all_channels()) {
    const std::string section(info(c).name);
    const WaveformChannel& ch = k.of(c);
    if (std::abs(ch.gain) < 1e-9)
      reader.fail(section, gain_key(c), "makes every value zero", "-1e9..-1e-9 or 1e-9..1e9");
    if (ch.clip_low >= ch.clip_high) reader.fail(section, "clip_low", "is not below clip_high");
  }
  reader.finish();
  return k;
}

}  // namespace

std::filesystem::path calibration_path(const std::filesystem::path& waveform) {
  auto path = waveform;
  return path.replace_extension(".toml");
}

namespace {

void take_certificate(Calibration& k, Channel c, const std::filesystem::path& folder) {
  WaveformChannel& ch = k.channels[index(c)];
  const std::string file = (folder / ch.certificate).string();
  const Certificate certificate = parse_dcc(whole_file(file), file);
  const CertifiedGain g = gain_of(certificate, info(c).unit, file);
  if (!std::isnan(ch.gain) && std::abs(ch.gain - g.gain) > 1e-9 * std::abs(g.gain))
    throw BadInput(
        {fmt::format("{}: certificate {} states {:.9g} {}/V, [{}] {} another gain; allowed one of both", file,
                     certificate.id, g.gain, info(c).unit, info(c).name, gain_key(c))});
  ch.gain = g.gain;
  if (k.id.find(certificate.id) == std::string::npos) k.id += (k.id.empty() ? "" : ", ") + certificate.id;
  std::string note = fmt::format("{}: gain {:.6g} {}/V from certificate {}", info(c).name, g.gain,
                                 info(c).unit, certificate.id);
  if (std::isfinite(g.expanded) && std::isfinite(g.coverage))
    note += fmt::format(", U = {:.3g} {}/V (k = {:g})", g.expanded, info(c).unit, g.coverage);
  if (!certificate.performed.empty()) note += ", calibrated on " + certificate.performed;
  k.notes.push_back(note);
}

}  // namespace

Calibration read_calibration(const std::filesystem::path& path) {
  Calibration k = read_with(FileReader::open(path));
  const bool named = !k.id.empty();
  const std::string id = k.id;
  for (const Channel c : all_channels())
    if (!k.of(c).certificate.empty()) take_certificate(k, c, path.parent_path());
  if (named) k.id = id;
  return k;
}

Calibration parse_calibration(std::string text, std::string file) {
  return read_with(FileReader(std::move(file), std::move(text)));
}

std::string calibration_template() {
  Calibration k;
  return kind_of(k, all_channels()).template_text();
}

std::string calibration_of(const Record& record, const std::string& source) {
  Calibration k;
  k.source = source;
  k.id = record.calibration;
  k.hold_time = record.conditions.hold_time;
  k.mains_hertz = record.conditions.mains_hertz;
  k.closing_angle = wrap_turn(commanded_phase(record.conditions));
  std::vector<Channel> channels;
  for (const ChannelRecord& c : record.channels) {
    channels.push_back(c.channel);
    WaveformChannel& to = k.channels[index(c.channel)];
    to.corner_hertz = c.corner_hertz;
    to.delay = c.delay;
    if (c.offset == 0.0) to.step = std::abs(c.scale);
    const double low = (c.clip_low + c.offset) * c.scale, high = (c.clip_high + c.offset) * c.scale;
    to.clip_low = std::min(low, high);
    to.clip_high = std::max(low, high);
  }
  return kind_of(k, channels, false).resolved_text();
}

bool in_force(const Calibration& k, const std::string& today) {
  if (k.id.empty()) return false;
  return k.valid_until.empty() || (k.recorded.empty() ? today : k.recorded) <= k.valid_until;
}

}  // namespace powbench::host
