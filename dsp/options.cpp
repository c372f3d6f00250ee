#include "dsp/options.h"

#include <cmath>
#include <cstdint>
#include <cstdio>
#include <stdexcept>
#include <string_view>
#include <utility>

namespace powbench::dsp {

namespace {

std::string value_text(double v) {
  char buffer[40];
  std::snprintf(buffer, sizeof buffer, "%.17g", v);
  return buffer;
}

std::string value_text(int v) {
  return std::to_string(v);
}

void require(bool ok, const char* name, double value, const char* range) {
  if (!ok) throw std::invalid_argument(std::string(name) + " = " + value_text(value) + ": allowed " + range);
}

bool signed_option(std::string_view name) {
  return name.starts_with("crosstalk");
}

}  // namespace

std::string to_text(const ExtractOptions& o) {
  std::string text;
#define POWBENCH_X(type, name, value, meaning) text += std::string(#name "=") + value_text(o.name) + "\n";
  POWBENCH_EXTRACT_OPTIONS(POWBENCH_X)
#undef POWBENCH_X
  const EventFilter& f = o.filter;
  if (f.wanted()) {
    constexpr const char* kinds[] = {"none", "plain", "lowpass", "bandstop"};
    text += std::string("filter=") + kinds[static_cast<int>(f.kind)] + "\n";
    text += "filter_low_hertz=" + value_text(f.low_hertz) +
            "\nfilter_high_hertz=" + value_text(f.high_hertz) + "\n";
    text += std::string("filter_phase=") + (f.phase == FilterPhase::zero ? "zero" : "causal") + "\n";
  }
  return text;
}

std::string parameters_hash(const ExtractOptions& o) {
  std::uint64_t h = 0xcbf29ce484222325ULL;
  for (const char c : to_text(o)) h = (h ^ static_cast<unsigned char>(c)) * 0x100000001b3ULL;
  char buffer[20];
  std::snprintf(buffer, sizeof buffer, "%016llx", static_cast<unsigned long long>(h));
  return buffer;
}

void check(const ExtractOptions& o) {
#define POWBENCH_X(type, name, value, meaning)                                                        \
  require(std::isfinite(static_cast<double>(o.name)) && (o.name >= 0 || signed_option(#name)), #name, \
          o.name, "0 .. finite");
  POWBENCH_EXTRACT_OPTIONS(POWBENCH_X)
#undef POWBENCH_X
  for (const auto& [name, value] : {std::pair{"crosstalk_a", o.crosstalk_a}, {"crosstalk_b", o.crosstalk_b}})
    require(std::abs(value) <= 0.5, name, value, "-0.5 .. 0.5");
  require(o.mains_hertz >= 40 && o.mains_hertz <= 70, "mains_hertz", o.mains_hertz, "40 .. 70 Hz");
  require(o.min_hum_periods >= 1.9, "min_hum_periods", o.min_hum_periods, ">= 1.9");
  require(o.detection_width > 0, "detection_width", o.detection_width, "> 0 s");
  require(o.detection_width_max >= o.detection_width, "detection_width_max", o.detection_width_max,
          ">= detection_width");
  require(o.touch_sigmas >= 3, "touch_sigmas", o.touch_sigmas, ">= 3");
  require(o.release_sigmas > 0 && o.release_sigmas <= o.touch_sigmas, "release_sigmas", o.release_sigmas,
          "0 .. touch_sigmas");
  require(o.release_share <= o.touch_share && o.touch_share < 1, "touch_share", o.touch_share,
          "release_share .. 1");
  require(o.exponent_min > 0.2 && o.exponent_max > o.exponent_min, "exponent_min", o.exponent_min,
          "0.2 .. exponent_max");
  require(o.chi2_confidence > 0.5 && o.chi2_confidence < 1, "chi2_confidence", o.chi2_confidence, "0.5 .. 1");
  require(o.ring_modes <= 12, "ring_modes", o.ring_modes, "0 .. 12");
  require(o.ring_high_hertz > o.ring_low_hertz, "ring_high_hertz", o.ring_high_hertz, "> ring_low_hertz");
  require(o.open_share > 0 && o.open_share < 1, "open_share", o.open_share, "0 .. 1, exclusive");
  require(o.seat_window > 0, "seat_window", o.seat_window, "> 0 s");
  require(o.display_order >= 1 && o.display_order <= 16, "display_order", o.display_order, "1 .. 16");
  require(o.display_hertz > 0, "display_hertz", o.display_hertz, "> 0 Hz");
}

}  // namespace powbench::dsp
