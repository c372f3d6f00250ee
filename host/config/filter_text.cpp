#include "host/config/filter_text.h"

#include <charconv>
#include <cmath>
#include <cstdio>

#include "host/config/unit.h"

namespace powbench::host {

namespace {

constexpr double lowest_hertz = 100, highest_hertz = 1e6;  // Hz
constexpr double narrowest = 1.05;                         // upper over lower edge

std::string_view without_blanks(std::string_view s) {
  while (!s.empty() && s.front() == ' ') s.remove_prefix(1);
  while (!s.empty() && s.back() == ' ') s.remove_suffix(1);
  return s;
}

/// Factor of a unit at the end of `text`, which is cut off; 0 without one.
double take_unit(std::string_view& text) {
  text = without_blanks(text);
  if (!text.ends_with("Hz")) return 0;
  text.remove_suffix(2);
  const double factor = text.ends_with("k") ? 1e3 : text.ends_with("M") ? 1e6 : 1;
  if (factor > 1) text.remove_suffix(1);
  text = without_blanks(text);
  return factor;
}

/// `factor`: of a number without a unit of its own, 0 = it needs one.
std::string read_hertz(std::string_view text, double factor, double& hertz) {
  const std::string whole(without_blanks(text));
  if (const double own = take_unit(text); own > 0) factor = own;
  double value = 0;
  const auto [rest, error] = std::from_chars(text.data(), text.data() + text.size(), value);
  if (error != std::errc() || rest != text.data() + text.size()) return "'" + whole + "' is no frequency";
  if (factor == 0) return "'" + whole + "' has no unit (Hz, kHz)";
  hertz = value * factor;
  return hertz >= lowest_hertz && hertz <= highest_hertz ? "" : "'" + whole + "' is out of range";
}

std::string hertz_text(double hertz) {
  return hertz < 1e3 ? number_text(hertz) + "Hz" : number_text(hertz / 1e3) + "kHz";
}

}  // namespace

std::string read_band(std::string_view text, dsp::Band& band) {
  const std::size_t dots = text.find("..");
  if (dots == std::string_view::npos) return "'" + std::string(text) + "' is no band";
  std::string_view high = text.substr(dots + 2);
  const double unit = take_unit(high);
  dsp::Band read;
  if (const auto wrong = read_hertz(text.substr(dots + 2), 0, read.high); !wrong.empty()) return wrong;
  if (const auto wrong = read_hertz(text.substr(0, dots), unit, read.low); !wrong.empty()) return wrong;
  if (read.low >= read.high) return "'" + std::string(text) + "' ends below its start";
  if (read.high < narrowest * read.low) return "'" + std::string(text) + "' is too narrow";
  band = read;
  return "";
}

std::string read_filter(std::string_view text, dsp::EventFilter& filter) {
  using Kind = dsp::EventFilter::Kind;
  text = without_blanks(text);
  dsp::EventFilter read{Kind::none, 0, 0, filter.phase, false};
  const std::size_t colon = text.find(':');
  const std::string_view kind = without_blanks(text.substr(0, colon));
  const std::string_view edges = colon == std::string_view::npos ? "" : text.substr(colon + 1);
  const bool bare = colon == std::string_view::npos;
  if (kind == "none" || kind == "plain") {
    if (!bare) return std::string(kind) + " takes no frequency";
    if (kind == "plain") read.kind = Kind::plain;
  } else if (kind == "lowpass" || kind == "bandstop") {
    if (bare) return std::string(kind) + " needs its frequency";
    dsp::Band band;
    const std::string wrong =
        kind == "lowpass" ? read_hertz(edges, 0, band.high) : read_band(without_blanks(edges), band);
    if (!wrong.empty()) return wrong;
    read.kind = kind == "lowpass" ? Kind::low : Kind::stop;
    read.low_hertz = band.low;
    read.high_hertz = band.high;
  } else {
    return "'" + std::string(text) + "' is no filter";
  }
  filter = read;
  return "";
}

std::string read_phase(std::string_view text, dsp::FilterPhase& phase) {
  text = without_blanks(text);
  if (text != "zero" && text != "causal") return "'" + std::string(text) + "' is no phase";
  phase = text == "zero" ? dsp::FilterPhase::zero : dsp::FilterPhase::causal;
  return "";
}

FilterMistake set_filter(dsp::ExtractOptions& o, const FilterWords& words) {
  dsp::Band band{o.ring_low_hertz, o.ring_high_hertz};
  if (!words.filter.empty())
    if (auto wrong = read_filter(words.filter, o.filter); !wrong.empty())
      return {"filter", wrong, filter_forms};
  if (!words.phase.empty()) {
    if (auto wrong = read_phase(words.phase, o.filter.phase); !wrong.empty())
      return {"phase", wrong, phase_forms};
    if (!o.filter.wanted() && words.filter.empty()) return {"phase", "there is no filter", "with a filter"};
  }
  if (o.filter.kind == dsp::EventFilter::Kind::plain && o.filter.phase == dsp::FilterPhase::causal)
    return {"phase", "the plain filter is zero phase", "zero"};
  if (!words.band.empty())
    if (auto wrong = read_band(words.band, band); !wrong.empty()) return {"band", wrong, band_forms};
  o.ring_low_hertz = band.low;
  o.ring_high_hertz = band.high;
  return {};
}

std::string text_of(const dsp::EventFilter& f) {
  switch (f.kind) {
    case dsp::EventFilter::Kind::none:
      return "none";
    case dsp::EventFilter::Kind::plain:
      return "plain";
    case dsp::EventFilter::Kind::low:
      return "lowpass:" + hertz_text(f.high_hertz);
    case dsp::EventFilter::Kind::stop:
      return "bandstop:" + hertz_text(f.low_hertz) + ".." + hertz_text(f.high_hertz);
  }
  return "";
}

}  // namespace powbench::host
