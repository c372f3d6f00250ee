#include "host/gather/strip_picture.h"

#include <algorithm>
#include <cmath>
#include <span>
#include <vector>

#include "dsp/events/vibration.h"
#include "dsp/signal/spectrum.h"
#include "host/config/bad_input.h"
#include "host/report/plot.h"

namespace powbench::host {

namespace {

constexpr double page_width = 1000, left = 74, right = 14, panel = 190, gap = 66, head = 62;
constexpr double top_hertz = 25e3;
constexpr Stroke before_stroke{colour::simulated, 1.2, 0.75}, after_stroke{colour::measured, 1.4, 0.95};

struct Strip {
  std::string film;
  dsp::Signal before, after;
  double from = 0, to = 0;  ///< s
};

std::span<const double> part(const dsp::Signal& s, double from, double to) {
  const std::size_t i = s.index_at(from), k = std::max(i, s.index_at(to));
  return std::span(s.value).subspan(i, k - i);
}

std::vector<Strip> strips(const Record& record, const FilteredEvents& found) {
  std::vector<Strip> out;
  for (const Channel c : {Channel::pvdf_a, Channel::pvdf_b}) {
    dsp::FilmVibration bare = dsp::film_vibration(record, c, found.events, found.bare, &found.films.of(c));
    if (!bare.present) continue;
    dsp::FilmVibration used = dsp::film_vibration(record, c, found.events, found.used);
    const auto& contacts = (c == Channel::pvdf_a ? found.events.pvdf_a : found.events.pvdf_b).contacts;
    Strip s{c == Channel::pvdf_a ? "film A" : "film B", std::move(bare.force), std::move(used.stripped), 0,
            0};
    s.from = (contacts.empty() ? bare.impact : contacts.front().touch.value) - 1e-3;
    s.to = contacts.empty() ? s.from + 10e-3 : contacts.back().touch.value + 2e-3;
    out.push_back(std::move(s));
  }
  return out;
}

std::vector<Plot::LegendEntry> legend() {
  return {{"as it came", before_stroke}, {"as events were taken from it", after_stroke}};
}

Markup time_panel(const Strip& s, double y) {
  const Range x{s.from * 1e3, s.to * 1e3};
  Range range;
  for (const dsp::Signal* signal : {&s.before, &s.after})
    for (const double v : part(*signal, s.from, s.to)) range.include(v);
  Plot plot({left, y, page_width - left - right, panel}, x, range.padded(0.05));
  const Ticks xt = nice_ticks(x, 12), yt = nice_ticks(range, 5);
  plot.grid(xt, yt);
  for (const auto& [signal, stroke] : {std::pair{&s.before, before_stroke}, {&s.after, after_stroke}}) {
    std::vector<XY> line;
    for (std::size_t i = signal->index_at(s.from); i < signal->index_at(s.to); ++i)
      line.push_back({signal->time(i) * 1e3, signal->value[i]});
    plot.line(line, stroke);
  }
  plot.frame();
  plot.x_labels(xt, "time in the record / ms");
  plot.y_labels(yt, s.film + " / N");
  plot.legend(legend(), 12);
  return plot.finish();
}

std::vector<XY> spectrum(const dsp::Signal& s, double from, double to) {
  const auto values = part(s, from, to);
  const auto piece = static_cast<std::size_t>(2.5e-3 * s.rate()) & ~std::size_t{1};
  std::vector<XY> line;
  if (piece < 16 || values.size() < piece) return line;
  dsp::SpectrumEstimator estimator(piece, s.rate());
  const dsp::Spectrum p = estimator.welch(values);
  for (std::size_t b = 1; b < p.density.size() && p.hertz(b) <= top_hertz; ++b)
    line.push_back({p.hertz(b) * 1e-3, 10 * std::log10(std::max(p.density[b], 1e-30))});
  return line;
}

Markup spectrum_panel(const Strip& s, double y) {
  const std::vector<XY> before = spectrum(s.before, s.from, s.to), after = spectrum(s.after, s.from, s.to);
  const Range x{0, top_hertz * 1e-3};
  Range range;
  for (const auto* line : {&before, &after})
    for (const XY& p : *line) range.include(p.y);
  if (range.empty()) range = {-60, 0};
  range = {std::max(range.low, range.high - 90) - 3, range.high + 3};
  Plot plot({left, y, page_width - left - right, panel}, x, range);
  const Ticks xt = nice_ticks(x, 10), yt = nice_ticks(range, 5);
  plot.grid(xt, yt);
  plot.line(before, before_stroke);
  plot.line(after, after_stroke);
  plot.frame();
  plot.x_labels(xt, "frequency / kHz");
  plot.y_labels(yt, s.film + " / dB re 1 N\xC2\xB2/Hz");
  return plot.finish();
}

}  // namespace

std::string strip_svg(const Record& record, const FilteredEvents& found, const std::string& title) {
  const std::vector<Strip> all = strips(record, found);
  if (all.empty()) throw BadInput({"--picture: the record has no force channel"});
  std::vector<Markup> panels;
  Markup about;
  about.open("text", {{"x", "74"}, {"y", "18"}, {"font-size", "13"}, {"fill", colour::ink}})
      .text(title)
      .close();
  panels.push_back(about);
  double y = head;
  for (const Strip& s : all) {
    panels.push_back(time_panel(s, y));
    panels.push_back(spectrum_panel(s, y + panel + gap));
    y += 2 * (panel + gap);
  }
  std::string svg = figure(page_width, y,
                           "Force before and after filter and vibration model, in time and frequency", panels)
                        .str();
  return svg.insert(svg.find(' '),
                    " font-family=\"Arial, Liberation Sans, DejaVu Sans, sans-serif\" font-size=\"12\" "
                    "style=\"background:#fff\"") +
         "\n";
}

}  // namespace powbench::host
