#include <cmath>
#include <limits>

#include "host/config/bad_input.h"
#include "host/config/nearest.h"
#include "python/binding/binding.h"

namespace powbench::python {

namespace {

/// A text as TOML has it.
std::string quoted(const std::string& text) {
  std::string out = "\"";
  for (const char c : text) {
    if (c == '"' || c == '\\') out += '\\';
    if (static_cast<unsigned char>(c) < 0x20)
      out += ' ';
    else
      out += c;
  }
  return out + '"';
}

/// 17 digits, as TOML has numbers: always with a point or an exponent, `nan` and `inf` by name.
std::string number(double x) {
  if (std::isnan(x)) return "nan";
  if (std::isinf(x)) return x > 0 ? "inf" : "-inf";
  char text[40];
  std::snprintf(text, sizeof text, "%.17g", x);
  std::string out = text;
  if (out.find_first_of(".e") == std::string::npos) out += ".0";
  return out;
}

}  // namespace

host::Scene one_closing(const ClosingArgs& a, const std::string& caller) {
  std::string text = "name = \"closing\"\nrepeats = 1\n";
  text += "angles_deg = [" + number(a.angle_deg) + "]\n";
  text += "supply_volts = " + number(a.supply_volts) + "\nmains_hertz = " + number(a.mains_hertz) + "\n";
  text += "hold_time_ms = " + number(a.hold_time_ms) + "\nambient_degC = " + number(a.ambient_degC) + "\n";
  text += "angle_tolerance_deg = " + number(a.angle_tolerance_deg) + "\n";
  text += "seed = " + std::to_string(a.seed) + "\n";
  if (!a.specimen.empty()) text += "specimen = " + quoted(a.specimen) + "\n";
  return host::make_scene(host::parse_plan(text, caller));
}

Channel channel_named(const std::string& name) {
  std::string known;
  std::vector<std::string> names;
  for (std::size_t i = 0; i < channel_count; ++i) {
    if (channel_table[i].name == name) return static_cast<Channel>(i);
    names.emplace_back(channel_table[i].name);
    known += (known.empty() ? "" : ", ") + names.back();
  }
  const std::string meant = host::nearest(name, names);
  throw host::BadInput({"no channel '" + name + "'" +
                        (meant.empty() ? "" : "; did you mean '" + meant + "'?") + "; there are " + known});
}

template <class Float>
void fill_values(const Record& record, const ChannelRecord& channel, Float* to) {
  const std::int16_t* raw = channel.raw.data();
  const std::size_t n = channel.raw.size();
  const double scale = channel.scale, offset = channel.offset;
  for (std::size_t i = 0; i < n; ++i) to[i] = static_cast<Float>((raw[i] + offset) * scale);
  for (const std::vector<Gap>* gaps : {&record.gaps, &channel.gaps})
    for (const Gap& g : *gaps)
      for (std::int64_t i = g.first; i < g.first + g.count; ++i)
        to[i] = std::numeric_limits<Float>::quiet_NaN();
}
template void fill_values<float>(const Record&, const ChannelRecord&, float*);
template void fill_values<double>(const Record&, const ChannelRecord&, double*);

}  // namespace powbench::python
