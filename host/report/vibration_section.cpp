#include <fmt/format.h>

#include <algorithm>
#include <array>
#include <cmath>

#include "host/report/number.h"
#include "host/report/plot.h"
#include "host/report/sections.h"

namespace powbench::host {
namespace {

constexpr double page_width = 1000, left = 74, right = 14;
constexpr double top_hertz = 20e3;

/// Light to dark, even steps of lightness: readable in grey and for colour-blind eyes.
constexpr std::array<std::string_view, 8> shades{"#dbe8f3", "#b5d2e7", "#8dbad9", "#659fca",
                                                 "#4383b5", "#2a6798", "#184a78", "#0a2c56"};
constexpr double db_per_shade = 6;

constexpr std::array<Stroke, 4> strokes{Stroke{colour::frame, 1.6, 1.0}, Stroke{colour::simulated, 1.6, 0.9},
                                        Stroke{colour::measured, 1.6, 0.95},
                                        Stroke{colour::published, 1.4, 0.95, "5 3"}};

std::string db_text(double db) {
  return std::isfinite(db) ? fixed(db, 1) : std::string("none");
}

std::string bands_text(const FilmBands& f) {
  std::string text;
  constexpr std::size_t most = 6;
  for (std::size_t i = 0; i < std::min(most, f.core.size()); ++i) {
    const auto& [low, high] = f.core[i];
    text += fmt::format("{}{:.2f}\xE2\x80\x93{:.2f}", text.empty() ? "" : ", ", low * 1e-3, high * 1e-3);
  }
  if (f.core.size() > most) text += fmt::format(" and {} more", f.core.size() - most);
  return text.empty() ? std::string(no_value) : text;
}

Markup table(const VibrationView& v) {
  Markup out;
  out.open("table").open("thead").open("tr");
  for (const std::string_view head :
       {"film", "core bands / kHz", "contact band / kHz", "vibration in contact band / dB",
        "contact in core bands / dB", "plain filter", "reference canceller"})
    out.element("th", head, {{"scope", "col"}});
  out.close().close().open("tbody");
  for (const FilmBands& f : v.films) {
    out.open("tr");
    out.element("th", f.film + ": " + f.basis, {{"scope", "row"}});
    out.element("td", bands_text(f));
    out.element("td", fmt::format("0\xE2\x80\x93{:.2f}", f.contact_hertz * 1e-3), {{"class", "nowrap"}});
    out.element("td", db_text(f.ring_in_contact_db));
    out.element("td", db_text(f.pulse_in_core_db));
    out.element("td", f.filter, {{"class", f.overlaps ? "warn" : "nowrap"}});
    out.element("td", f.canceller);
    out.close();
  }
  return out.close().close();
}

Markup spectra_figure(const VibrationView& v) {
  Range x{0, top_hertz * 1e-3}, y;
  for (const auto& line : v.spectra)
    for (std::size_t i = 0; i < line.db.size(); ++i)
      if (line.hertz[i] <= top_hertz && line.hertz[i] > 0) y.include(line.db[i]);
  if (y.empty()) return {};
  y = {std::max(y.low, y.high - 90), y.high + 4};
  Plot plot({left, 40, page_width - left - right, 210}, x, y);
  const Ticks xt = nice_ticks(x, 10), yt = nice_ticks(y, 5);
  plot.grid(xt, yt);
  for (const FilmBands& f : v.films) {
    if (f.film != v.film) continue;
    plot.shade_x(0, f.contact_hertz * 1e-3, colour::measured, 0.08);
    for (const auto& [low, high] : f.core) plot.shade_x(low * 1e-3, high * 1e-3, colour::simulated, 0.16);
  }
  std::vector<Plot::LegendEntry> legend;
  for (std::size_t k = 0; k < v.spectra.size(); ++k) {
    std::vector<XY> points;
    for (std::size_t i = 0; i < v.spectra[k].db.size(); ++i)
      if (v.spectra[k].hertz[i] <= 1.02 * top_hertz)
        points.push_back({v.spectra[k].hertz[i] * 1e-3, v.spectra[k].db[i]});
    const Stroke& stroke = strokes[std::min(k, strokes.size() - 1)];
    plot.line(points, stroke);
    legend.push_back({v.spectra[k].label, stroke});
  }
  plot.frame();
  plot.x_labels(xt, "frequency / kHz");
  plot.y_labels(yt, "dB re 1 N\xC2\xB2/Hz");
  plot.legend(legend, 12);
  return figure(page_width, 40 + 210 + 46,
                "Spectra of the force before and after the core vibration is taken out", {plot.finish()});
}

/// One path a shade: runs of equal shade along the time axis.
Markup map_panel(const SpectrumMap& m, double y, double highest, double height, double impact_ms, bool last) {
  const Range window{m.t0_ms, m.t0_ms + m.dt_ms * static_cast<double>(m.frames - 1)};
  const Range hertz{0, top_hertz * 1e-3};
  const double width = page_width - left - right;
  Plot plot({left, y, width, height}, window, hertz);
  const auto bins = std::min(m.bins, static_cast<std::size_t>(top_hertz / m.bin_hertz) + 1);
  const double cell = width / static_cast<double>(m.frames - 1), row = height * m.bin_hertz / top_hertz;
  std::array<std::string, shades.size()> paths;
  const auto shade = [&](std::size_t frame, std::size_t bin) {
    const double below = (highest - static_cast<double>(m.db[frame * m.bins + bin])) / db_per_shade;
    return below < static_cast<double>(shades.size())
               ? static_cast<int>(shades.size()) - 1 - static_cast<int>(std::max(below, 0.0))
               : -1;
  };
  for (std::size_t bin = 0; bin < bins; ++bin)
    for (std::size_t k = 0; k < m.frames;) {
      const int s = shade(k, bin);
      std::size_t end = k + 1;
      while (end < m.frames && shade(end, bin) == s) ++end;
      if (s >= 0) {
        const double x0 = std::max(left, left + (static_cast<double>(k) - 0.5) * cell);
        const double x1 = std::min(left + width, left + (static_cast<double>(end) - 0.5) * cell);
        const double y0 = std::max(y, y + height - (static_cast<double>(bin) + 0.5) * row);
        const double y1 = std::min(y + height, y + height - (static_cast<double>(bin) - 0.5) * row);
        paths[static_cast<std::size_t>(s)] +=
            fmt::format("M{:.0f} {:.1f}H{:.0f}V{:.1f}H{:.0f}z", x0, y0, x1, y1, x0);
      }
      k = end;
    }
  Markup out;
  for (std::size_t s = 0; s < paths.size(); ++s)
    if (!paths[s].empty()) out.empty("path", {{"d", paths[s]}, {"fill", shades[s]}});
  plot.vertical(impact_ms, {colour::simulated, 1.1, 0.9, "5 3"});
  plot.frame();
  plot.y_labels(nice_ticks(hertz, 4), m.title);
  if (last) plot.x_labels(nice_ticks(window, 12), "time in the record / ms");
  out.embed(plot.finish());
  return out;
}

Markup maps_figure(const VibrationView& v) {
  double highest = -1e9;
  for (const auto& m : v.maps)
    for (const float db : m.db) highest = std::max(highest, static_cast<double>(db));
  constexpr double height = 150, gap = 14;
  double y = 10;
  std::vector<Markup> panels;
  for (const auto& m : v.maps) {
    const bool last = &m == &v.maps.back();
    panels.push_back(map_panel(m, y, highest, height, v.impact_ms, last));
    y += height + (last ? 46 : gap);
  }
  return figure(page_width, y, "Spectrograms of the force before and after the core vibration is taken out",
                panels);
}

}  // namespace

Markup vibration_section(const VibrationView& v) {
  Markup out;
  out.open("section", {{"id", "vibration"}});
  out.element("h2", "Core vibration on the films");
  out.embed(table(v));

  if (!v.spectra.empty()) {
    out.open("figure");
    out.element("h3", fmt::format("{}, shot {} {}: spectra around the core impact", v.film, v.shot,
                                  at_angle(v.angle)));
    out.embed(spectra_figure(v));
    out.element("figcaption", "Blue shade: contact band. Orange shade: core bands.");
    out.close();
  }
  if (!v.maps.empty()) {
    out.open("figure");
    out.element("h3", "The same in time; dashed: core impact");
    out.embed(maps_figure(v));
    out.element("figcaption",
                fmt::format("Each shade is {:.0f} dB; white is more than {:.0f} dB below the largest.",
                            db_per_shade, db_per_shade * static_cast<double>(shades.size())));
    out.close();
  }
  out.element("p",
              "The contact band ends at 1.5 over the shortest contact. Where more than -20 dB of the "
              "vibration lies in it, no "
              "filter can separate the two, and none is offered. The definitions name how events were taken.",
              {{"class", "fine"}});
  return out.close();
}

}  // namespace powbench::host
