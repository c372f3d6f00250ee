#include "host/gather/vibration.h"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <nlohmann/json.hpp>

#include "core/counted.h"
#include "dsp/contacts/threshold.h"
#include "dsp/events/extract.h"
#include "dsp/filter/event_filter.h"
#include "dsp/filter/force.h"
#include "dsp/signal/spectrum.h"
#include "host/compare/compare.h"

namespace powbench::host {

namespace {

constexpr std::size_t most_closings = 40;

std::string film_name(Channel c) {
  return c == Channel::pvdf_a ? "film A" : "film B";
}

std::string filter_text(const dsp::BandReport& bands, double rate) {
  try {
    const dsp::FilterSpec f = dsp::plain_filter(bands, rate);
    return fmt::format("low-pass {:.2f} kHz", f.high_hertz * 1e-3);
  } catch (const dsp::BandOverlapError&) {
    return "refused";
  } catch (const std::exception&) {
    return "none below half the sample rate";
  }
}

std::string canceller_text(const dsp::FilmVibration& v) {
  if (!v.cancelled) return "no reference moves at the impact";
  if (v.cancelled->refused && v.cancelled->reason.starts_with("the reference explains"))
    return fmt::format("refused: {} explains {:.1f} %, needed {:.0f} %", v.reference,
                       100 * v.cancelled->explained, 100 * dsp::CancelOptions{}.least_explained);
  if (v.cancelled->refused) return fmt::format("refused: {} {}", v.reference, v.cancelled->reason);
  return fmt::format("{} explains {:.0f} %", v.reference, 100 * v.cancelled->explained);
}

FilmBands film_bands(const dsp::BandReport& b, const dsp::FilmVibration& v, Channel film, std::string basis) {
  FilmBands out;
  out.film = film_name(film);
  out.basis = std::move(basis);
  for (const dsp::Band& band : b.core) out.core.emplace_back(band.low, band.high);
  out.contact_hertz = b.contact.high;
  out.ring_in_contact_db = b.ring_in_contact_db;
  out.pulse_in_core_db = b.pulse_in_core_db;
  out.overlaps = b.overlaps;
  out.filter = filter_text(b, v.force.rate());
  out.canceller = canceller_text(v);
  return out;
}

std::vector<double> decibels(const std::vector<double>& density) {
  std::vector<double> db;
  for (const double d : density) db.push_back(10 * std::log10(std::max(d, 1e-30)));
  return db;
}

/// Welch density between two times, in pieces of about 2.5 ms.
void add_spectrum(VibrationView& view, const std::string& label, const dsp::Signal& s, double from,
                  double to) {
  const std::size_t i = s.index_at(from), k = std::max(i, s.index_at(to));
  const auto piece = std::max<std::size_t>(16, static_cast<std::size_t>(2.5e-3 * s.rate()) & ~std::size_t{1});
  if (k - i < piece) return;
  dsp::SpectrumEstimator estimator(piece, s.rate());
  const dsp::Spectrum p = estimator.welch(std::span(s.value).subspan(i, k - i));
  SpectrumLine line{label, {}, decibels(p.density)};
  for (std::size_t b = 0; b < p.density.size(); ++b) line.hertz.push_back(p.hertz(b));
  view.spectra.push_back(std::move(line));
}

void add_map(VibrationView& view, const std::string& title, const dsp::Signal& s, double from, double to) {
  const dsp::Spectrogram g = dsp::spectrogram(s, from, to, 1.2e-3, 160);
  SpectrumMap m{title, g.t0 * 1e3, g.dt * 1e3, g.bin_hertz, g.frames, g.bins, {}};
  for (const double d : decibels(g.density)) m.db.push_back(static_cast<float>(d));
  view.maps.push_back(std::move(m));
}

void draw(VibrationView& view, const dsp::FilmVibration& v) {
  const double from = v.impact - 1e-3, to = v.impact + 9e-3;
  add_spectrum(view, "before switch-on", v.force, v.force.t0, std::min(0.0, from));
  if (view.spectra.empty()) view.spectra.push_back({"before switch-on: none", {}, {}});
  add_spectrum(view, "at the impact", v.force, from, to);
  add_spectrum(view, "less the fitted modes", v.stripped, from, to);
  if (v.cancelled && !v.cancelled->refused)
    add_spectrum(view, "less what the reference explains", v.cancelled->force, from, to);
  const double start = std::max(v.force.t0, v.impact - 10e-3),
               end = std::min(v.force.end(), v.impact + 15e-3);
  if (!(start < end) || v.force.rate() < 10e3) return;
  add_map(view, "before / kHz", v.force, start, end);
  add_map(view, "after / kHz", v.stripped, start, end);
}

}  // namespace

void VibrationFinder::add(int shot, const Record& record, const Events& events) {
  for (Film& film : films_) {
    const ContactTrain& train = film.channel == Channel::pvdf_a ? events.pvdf_a : events.pvdf_b;
    for (const Contact& c : train.contacts)
      if (c.release.known())
        film.shortest = std::clamp(c.release.value - c.touch.value, 50e-6, film.shortest);
    if (film.closings.size() < most_closings)
      if (auto closing = dsp::closing_of(record, film.channel, events, options_))
        film.closings.push_back(std::move(*closing));
    const bool better = !film.drawn || (film.drawn->ring.empty() && shot_ == shot);
    if (!better && !(film.drawn->ring.empty() && film.closings.size() < 4)) continue;
    auto v = dsp::film_vibration(record, film.channel, events, options_);
    if (!v.present || (film.drawn && v.ring.empty())) continue;
    film.drawn = std::move(v);
    shot_ = shot;
    angle_ = effective_angle(record.conditions);
  }
}

std::optional<VibrationView> VibrationFinder::finish() {
  VibrationView view;
  view.shot = shot_;
  view.angle = angle_;
  const dsp::FilmVibration* best = nullptr;
  for (Film& film : films_) {
    if (!film.drawn) continue;
    const dsp::FilmVibration& v = *film.drawn;
    dsp::BandQuestion q;
    q.pulse_width = film.shortest;
    if (const auto bands = dsp::bands_of_closings(film.closings, q))
      view.films.push_back(film_bands(
          *bands, v, film.channel,
          fmt::format("coherence with {} over {}", v.reference.empty() ? "the reference" : v.reference,
                      counted(bands->closings, "closing"))));
    if (!v.ring.empty())
      view.films.push_back(
          film_bands(dsp::bands_of_ring(v.ring, q), v, film.channel,
                     fmt::format("{} fitted to shot {}", counted(v.ring.modes.size(), "mode"), shot_)));
    if (!best || (best->ring.empty() && !v.ring.empty())) {
      best = &v;
      view.film = film_name(film.channel);
    }
  }
  if (!best) return std::nullopt;
  view.impact_ms = best->impact * 1e3;
  draw(view, *best);
  return view;
}

void set_rule(dsp::ExtractOptions& o, const LabRule& rule) {
  if (rule.voltage_percent) o.open_share = *rule.voltage_percent / 100;
  if (rule.min_opening_us) {
    o.merge_openings = *rule.min_opening_us * 1e-6;
    o.min_open_voltage = std::max(o.min_open_voltage, o.merge_openings);
  }
}

void apply_rule(Events& e, const Record& record, const dsp::ExtractOptions& options, const LabRule& rule) {
  if (!rule.force_percent) return;
  dsp::ThresholdRule r;
  r.share = *rule.force_percent / 100;
  if (rule.min_opening_us) r.min_open = *rule.min_opening_us * 1e-6;
  for (const auto& [film, train] : {std::pair{Channel::pvdf_a, &e.pvdf_a}, {Channel::pvdf_b, &e.pvdf_b}}) {
    if (!train->present) continue;
    const dsp::FilmVibration v = dsp::film_vibration(record, film, e, options);
    const ContactTrain fitted = *train;
    *train = dsp::threshold_train(v.stripped, v.settled, fitted.noise, dsp::closing_end(record, v.force), r);
    if (options.filter.judged) dsp::admit_filter(*train, dsp::effect_of(options.filter, v.force.rate()));
    train->flags |= fitted.flags;
  }
  dsp::conclude(e, record, options);
  e.method = fmt::format("forces: crossing of {:g} % of the settled force{}", *rule.force_percent,
                         options.filter.judged ? ", " + dsp::name_of(options.filter) : "");
}

namespace {

/// A film that is there, its ring, and its bands where it rings.
struct FilmRing {
  Channel film;
  dsp::Ring ring;
  FilmBands bands;
};

std::vector<FilmRing> film_rings(const Record& record, const Events& events,
                                 const dsp::ExtractOptions& options, const dsp::FilmPaths& films) {
  std::vector<FilmRing> out;
  for (const Channel film : {Channel::pvdf_a, Channel::pvdf_b}) {
    const dsp::FilmVibration v = dsp::film_vibration(record, film, events, options, &films.of(film));
    if (!v.present) continue;
    out.push_back({film, v.ring, {}});
    if (v.ring.empty()) continue;
    dsp::BandQuestion q;
    q.pulse_width = v.shortest;
    out.back().bands = film_bands(dsp::bands_of_ring(v.ring, q), v, film, "");
  }
  return out;
}

}  // namespace

std::string bands_json(const Record& record, const Events& events, const dsp::ExtractOptions& options,
                       const dsp::FilmPaths& films) {
  using Json = nlohmann::ordered_json;
  const auto number = [](double x) { return std::isfinite(x) ? Json(x) : Json(nullptr); };
  Json out = Json::array();
  for (const FilmRing& f : film_rings(record, events, options, films)) {
    Json modes = Json::array();
    for (const auto& m : f.ring.modes) modes.push_back(m.pole.hertz);
    Json j = {{"film", info(f.film).name}, {"modes_hertz", modes}};
    if (!f.ring.empty())
      j.update({{"contact_hertz", number(f.bands.contact_hertz)},
                {"ring_in_contact_db", number(f.bands.ring_in_contact_db)},
                {"pulse_in_core_db", number(f.bands.pulse_in_core_db)},
                {"overlaps", f.bands.overlaps},
                {"filter", f.bands.filter},
                {"canceller", f.bands.canceller}});
    out.push_back(std::move(j));
  }
  return out.dump();
}

std::vector<std::string> band_lines(const Record& record, const Events& events,
                                    const dsp::ExtractOptions& options, const dsp::FilmPaths& films) {
  std::vector<std::string> lines;
  for (const FilmRing& f : film_rings(record, events, options, films)) {
    if (f.ring.empty()) {
      lines.push_back(fmt::format("{}: no core vibration stands out", film_name(f.film)));
      continue;
    }
    const FilmBands& b = f.bands;
    std::string modes;
    for (const auto& m : f.ring.modes)
      modes += fmt::format("{}{:.2f}", modes.empty() ? "" : ", ", m.pole.hertz * 1e-3);
    lines.push_back(
        fmt::format("{}: core vibrates at {} kHz, contact force reaches {:.2f} kHz: {:.1f} dB of the "
                    "vibration lie in the contact "
                    "band, {:.1f} dB of a contact in the core's; plain filter: {}; canceller: {}",
                    b.film, modes, b.contact_hertz * 1e-3, b.ring_in_contact_db, b.pulse_in_core_db, b.filter,
                    b.canceller));
  }
  return lines;
}

}  // namespace powbench::host
