#include "host/report/closing_json.h"

#include <fmt/format.h>

#include <algorithm>
#include <array>
#include <cmath>

#include "core/quantities.h"
#include "host/export/base64.h"
#include "host/report/number.h"
#include "host/report/sections.h"

namespace powbench::host {
namespace {

constexpr double before = 4, behind = 8;     // ms around the closing
constexpr std::size_t most_points = 8000;    // of one closing
constexpr std::int16_t no_number = -32'768;  // counts

struct Panel {
  std::string_view channel, name;
};
constexpr std::array panels{Panel{"pvdf_a", "force A"},
                            Panel{"pvdf_b", "force B"},
                            Panel{"laser", "travel"},
                            Panel{"coil_current", "coil current"},
                            Panel{"coil_voltage", "coil voltage"},
                            Panel{"contact_a", "contact"}};

/// Time axis of one closing.
struct Grid {
  double t0 = 0, dt = 0;  ///< ms
  std::size_t n = 0;
};

/// Two points of the grid take the least and the largest of the samples between them, in their order: no peak is lost.
void extremes(const Waveform& w, const Grid& grid, double scale, std::vector<float>& out) {
  const auto sample = [&](std::size_t i) {
    const double at = ((grid.t0 + static_cast<double>(i) * grid.dt) * 1e-3 - w.t0) / w.dt;
    return static_cast<std::size_t>(std::clamp(at, 0.0, static_cast<double>(w.values.size())));
  };
  for (std::size_t i = 0; i + 1 < grid.n; i += 2) {
    const std::size_t from = sample(i), to = sample(i + 2);
    std::size_t low = to, high = to;
    for (std::size_t k = from; k < to; ++k) {
      if (!std::isfinite(w.values[k])) continue;
      if (low == to || w.values[k] < w.values[low]) low = k;
      if (high == to || w.values[k] > w.values[high]) high = k;
    }
    if (low == to) continue;
    out[i] = static_cast<float>(scale) * w.values[std::min(low, high)];
    out[i + 1] = static_cast<float>(scale) * w.values[std::max(low, high)];
  }
}

std::vector<float> on_grid(const Waveform& w, const Grid& grid, double scale) {
  std::vector<float> out(grid.n, std::nanf(""));
  if (grid.dt * 1e-3 > 1.01 * w.dt) {
    extremes(w, grid, scale, out);
    return out;
  }
  for (std::size_t i = 0; i < grid.n; ++i) {
    const double at = ((grid.t0 + static_cast<double>(i) * grid.dt) * 1e-3 - w.t0) / w.dt;
    if (at < 0 || at > static_cast<double>(w.values.size() - 1)) continue;
    const auto k = std::min(static_cast<std::size_t>(at), w.values.size() - 2);
    const auto part = static_cast<float>(at - static_cast<double>(k));
    out[i] = static_cast<float>(scale) * ((1 - part) * w.values[k] + part * w.values[k + 1]);
  }
  return out;
}

/// One curve as 16-bit counts.
std::string series_json(std::string_view label, const std::vector<float>& values) {
  Range r;
  for (const float v : values) r.include(static_cast<double>(v));
  if (r.empty()) return {};
  const double middle = (r.low + r.high) / 2, step = std::max(r.span(), 1e-30) / 65'000;
  std::string bytes(2 * values.size(), '\0');
  for (std::size_t i = 0; i < values.size(); ++i) {
    const auto v = static_cast<double>(values[i]);
    const auto count =
        std::isfinite(v) ? static_cast<std::int16_t>(std::lrint((v - middle) / step)) : no_number;
    bytes[2 * i] = static_cast<char>(count & 0xFF);
    bytes[2 * i + 1] = static_cast<char>((count >> 8) & 0xFF);
  }
  return fmt::format("{{\"label\":\"{}\",\"middle\":{:.9g},\"step\":{:.9g},\"data\":\"{}\"}}", label, middle,
                     step, base64(bytes));
}

std::string marks_json(const Events& events, bool simulated) {
  std::string out;
  const auto mark = [&](double at, std::string_view text) {
    if (!std::isfinite(at)) return;
    out += fmt::format("{}{{\"at\":{:.5f},\"text\":\"{}\",\"simulated\":{}}}", out.empty() ? "" : ",",
                       at * 1e3, simulated ? "" : text, simulated);
  };
  const auto& contacts = timing_train(events).contacts;
  for (std::size_t i = 0; i < contacts.size(); ++i) {
    mark(after_switch_on(events, contacts[i].touch).value, i == 0 ? "touch" : "");
    mark(after_switch_on(events, contacts[i].release).value, "");
  }
  mark(after_switch_on(events, events.core.seat).value, "core seat");
  return out;
}

/// The half width (k = 2) of the simulated curve's band; empty: not known.
std::string band_json(const Waveform& u, double end_ms, double scale) {
  std::string values;
  for (std::size_t k = 0; k < u.values.size() && (u.t0 + static_cast<double>(k) * u.dt) * 1e3 < end_ms; ++k)
    values += (k ? "," : "") + (std::isfinite(u.values[k])
                                    ? fmt::format("{:.3g}", 2 * static_cast<double>(u.values[k]) * scale)
                                    : "null");
  return fmt::format(",\"band\":{{\"t0\":{:.6g},\"dt\":{:.6g},\"half\":[{}]}}", u.t0 * 1e3, u.dt * 1e3,
                     values);
}

std::string closing_json(const ReportShot& shot, const AngleView& view) {
  const Events& events = *shot.events;
  const double touch = find_quantity("t_ct1")->of(events).value * 1e3,
               settled = find_quantity("t_ct2")->of(events).value * 1e3;
  const double end = (std::isfinite(settled) ? settled : 30) + behind;
  Grid grid{-before, shot.waveforms.front().dt * 1e3, 0};
  grid.dt = std::max(grid.dt, (end + before) / static_cast<double>(most_points));
  grid.n = static_cast<std::size_t>((end + before) / grid.dt) + 1;
  std::string channels;
  for (const Panel& panel : panels) {
    const Waveform* measured = find_waveform(shot.waveforms, panel.channel);
    const Waveform* raw = find_waveform(shot.raw, panel.channel);
    const Waveform* simulated =
        view.simulated != nullptr ? find_waveform(view.simulated->waveforms, panel.channel) : nullptr;
    const Waveform* any = measured != nullptr ? measured : simulated;
    if (any == nullptr) continue;
    const ReadableUnit unit = readable_unit(any->unit);
    std::string list;
    const auto add = [&](std::string_view label, const std::vector<float>& values) {
      const std::string one = series_json(label, values);
      if (!one.empty()) list += (list.empty() ? "" : ",") + one;
    };
    if (raw != nullptr && measured != nullptr) {
      Waveform taken = *raw;
      for (std::size_t i = 0; i < taken.values.size(); ++i)
        taken.values[i] = i < measured->values.size() ? taken.values[i] - measured->values[i] : std::nanf("");
      add("raw", on_grid(*raw, grid, unit.per_si));
      add("raw minus measured", on_grid(taken, grid, unit.per_si));
    }
    if (simulated != nullptr) add("simulated", on_grid(*simulated, grid, unit.per_si));
    if (measured != nullptr) add("measured", on_grid(*measured, grid, unit.per_si));
    if (list.empty()) continue;
    const Waveform* u =
        view.simulated != nullptr ? find_waveform(view.simulated->spread, panel.channel) : nullptr;
    channels +=
        fmt::format("{}{{\"name\":\"{}\",\"unit\":\"{}\",\"series\":[{}]{}}}", channels.empty() ? "" : ",",
                    panel.name, unit.name, list, u != nullptr ? band_json(*u, end, unit.per_si) : "");
  }
  std::string marks = marks_json(events, false);
  if (view.simulated != nullptr)
    if (const std::string more = marks_json(view.simulated->events, true); !more.empty())
      marks += (marks.empty() ? "" : ",") + more;
  const double from = std::isfinite(touch) ? touch - 1 : -before;
  const std::string level =
      std::isfinite(shot.contact_level) ? fmt::format("{:.6g}", shot.contact_level) : "null";
  return fmt::format(
      "{{\"name\":\"shot {} at "
      "{}\",\"t0\":{:.6g},\"dt\":{:.9g},\"n\":{},\"bounce\":[{:.4f},{:.4f}],\"contact_level_V\":{},"
      "\"channels\":[{}],\"marks\":[{}]}}",
      shot.index,
      std::isfinite(view.angle) ? fmt::format("{:.1f} deg", degrees(view.angle)) : "an angle not known",
      grid.t0, grid.dt, grid.n, from, end - behind + 2, level, channels, marks);
}

}  // namespace

std::string closings_json(const ReportInput& input) {
  std::string data;
  for (const AngleView& view : angles_of(input))
    for (const ReportShot* shot : view.shots)
      if (!shot->raw.empty() && shot->events && !shot->waveforms.empty())
        data += (data.empty() ? "" : ",\n") + closing_json(*shot, view);
  return data.empty() ? data : "[" + data + "]";
}

}  // namespace powbench::host
