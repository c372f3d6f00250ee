#include "dsp/events/requested.h"

#include <algorithm>
#include <cmath>
#include <cstdio>
#include <limits>

#include "core/channels.h"
#include "dsp/events/extract.h"
#include "dsp/events/vibration.h"
#include "dsp/filter/bands.h"
#include "dsp/filter/sos.h"

namespace powbench::dsp {

namespace {

/// Shortest time closed or open between two edges, s.
double shortest_piece(const ContactTrain& t) {
  double shortest = 1e-3;
  const Contact* before = nullptr;
  for (const Contact& c : t.contacts) {
    if (c.probability < 0.5) continue;
    if (before != nullptr && before->release.known())
      shortest = std::min(shortest, c.touch.value - before->release.value);
    if (c.release.known()) shortest = std::min(shortest, c.release.value - c.touch.value);
    before = &c;
  }
  return std::max(shortest, 20e-6);
}

/// Mean power gain over a band.
double power_gain(const EventFilter& f, double low, double high, double rate) {
  constexpr int points = 40;
  double sum = 0;
  for (int i = 0; i < points; ++i) {
    const double g = gain_of(f, low + (high - low) * (i + 0.5) / points, rate);
    sum += g * g / points;
  }
  return sum;
}

/// What is left of the modes' energy.
double left_of_ring(const EventFilter& f, const Ring& ring, double rate) {
  double all = 0, left = 0;
  for (const RingMode& m : ring.modes) {
    const double growth = std::exp(-2 * m.pole.decay * (ring.onset - ring.reference));
    const double energy = (m.cosine * m.cosine + m.sine * m.sine) * growth / std::max(m.pole.decay, 1e-9);
    const double half = std::max(m.pole.decay / (2 * pi), 1.0);
    all += energy;
    left += energy * power_gain(f, std::max(m.pole.hertz - half, 0.0), m.pole.hertz + half, rate);
  }
  return all > 0 ? left / all : 1.0;
}

/// Lowest low-pass that is not refused, Hz; 0 where there is none below half the rate.
double least_low_pass(EventFilter f, double shortest, double rate) {
  double low = 0.1 / shortest, high = 0.499 * rate;
  const auto taken = [&](double hertz) {
    f.high_hertz = hertz;
    return half_sine_taken_db([&](double at) { return gain_of(f, at, rate); }, shortest);
  };
  if (low >= high || taken(high) > most_taken_db) return 0;
  for (int i = 0; i < 20; ++i) {
    const double middle = std::sqrt(low * high);
    (taken(middle) > most_taken_db ? low : high) = middle;
  }
  return high;
}

/// Not below x, so that what is printed is not refused again.
double up_to_three_digits(double x) {
  if (!(x > 0)) return x;
  const double digit = std::pow(10.0, std::floor(std::log10(x)) - 2);
  return std::ceil(x / digit) * digit;
}

std::string refusal(const EventFilter& f, const FilmFilter& film, double rate) {
  char text[300];
  std::snprintf(text, sizeof text,
                "%s takes %.1f dB of the energy of the shortest contact or opening on %s (%.3f ms), allowed "
                "%.0f dB or less",
                name_of(f).c_str(), film.contact_db, std::string(info(film.film).name).c_str(),
                film.shortest * 1e3, most_taken_db);
  std::string out = text;
  if (f.kind != EventFilter::Kind::low) return out;
  const double least = up_to_three_digits(least_low_pass(f, film.shortest, rate));
  std::snprintf(text, sizeof text,
                least > 0 ? ": a low-pass from %.3g kHz on" : ": no low-pass at this sample rate",
                least * 1e-3);
  return out + text;
}

/// The end of the contact band for `plain`, or why it is not to be had.
std::string resolve_plain(EventFilter& f, const std::vector<FilmVibration>& vibrations,
                          const std::vector<FilmFilter>& films, double rate) {
  BandQuestion q;
  for (const FilmFilter& film : films) q.pulse_width = std::min(q.pulse_width, film.shortest);
  f.high_hertz = 1.5 / q.pulse_width;
  try {
    for (const FilmVibration& v : vibrations) plain_filter(bands_of_ring(v.ring, q), rate);
  } catch (const BandOverlapError& e) {
    return e.what();
  }
  if (f.high_hertz < rate / 2) return "";
  char text[160];
  std::snprintf(text, sizeof text, "the contact band reaches %.3g kHz, half the sample rate is %.3g kHz",
                f.high_hertz * 1e-3, rate * 0.5e-3);
  return text;
}

/// Why rate or length of the record do not allow the filter; "" where they do.
std::string impossible(const EventFilter& f, const std::vector<FilmVibration>& vibrations, double rate) {
  try {
    const auto sections = to_sections(spec_of(f, rate));
    for (const FilmVibration& v : vibrations) {
      const std::size_t memory = filter_memory(sections, 1e-3, v.force.size() + 1);
      if (memory > v.force.size()) return FilterMemoryError(v.force.size(), memory).what();
    }
  } catch (const FilterDesignError& e) {
    return e.what();
  }
  return "";
}

}  // namespace

FilterJudgement judge_filter(const Record& record, const Events& unfiltered, const FilmPaths& paths,
                             const ExtractOptions& o) {
  FilterJudgement j;
  j.filter = o.filter;
  ExtractOptions bare = o;
  bare.filter = {};
  std::vector<FilmVibration> vibrations;
  for (const Channel c : {Channel::pvdf_a, Channel::pvdf_b}) {
    FilmVibration v = film_vibration(record, c, unfiltered, bare, &paths.of(c));
    if (!v.present) continue;
    FilmFilter film;
    film.film = c;
    film.shortest = shortest_piece(c == Channel::pvdf_a ? unfiltered.pvdf_a : unfiltered.pvdf_b);
    film.found = !v.ring.empty();
    j.films.push_back(film);
    vibrations.push_back(std::move(v));
  }
  if (j.films.empty()) {
    j.refused = "there is no force channel to filter";
    return j;
  }
  const double rate = record.sample_rate;
  if (o.filter.kind == EventFilter::Kind::plain) {
    j.refused = resolve_plain(j.filter, vibrations, j.films, rate);
    if (!j.refused.empty()) return j;
  }
  j.refused = impossible(j.filter, vibrations, rate);
  if (!j.refused.empty()) return j;
  j.effect = effect_of(j.filter, rate);
  for (std::size_t i = 0; i < j.films.size(); ++i) {
    FilmFilter& film = j.films[i];
    film.contact_db =
        half_sine_taken_db([&](double at) { return gain_of(j.filter, at, rate); }, film.shortest);
    film.vibration_db = decibel(film.found ? left_of_ring(j.filter, vibrations[i].ring, rate)
                                           : power_gain(j.filter, o.ring_low_hertz, o.ring_high_hertz, rate));
    if (o.filter.kind != EventFilter::Kind::plain && j.refused.empty() && film.contact_db > most_taken_db)
      j.refused = refusal(j.filter, film, rate);
  }
  j.filter.judged = j.refused.empty();
  return j;
}

Extracted extract_on_request(const Record& record, const ExtractOptions& o) {
  ExtractOptions used = o;
  used.filter = {};
  Extracted out;
  out.events = extract_events(record, used, in_turn, out.bare);
  if (!o.filter.wanted()) return out;
  out.filter = judge_filter(record, out.events, out.bare, o);
  if (out.filter->filter.judged) {
    used.filter = out.filter->filter;
    out.events = extract_events(record, used);
  } else {
    out.events.method += "; filter refused: " + out.filter->refused;
  }
  out.events.parameters_hash = parameters_hash(o);
  return out;
}

}  // namespace powbench::dsp
