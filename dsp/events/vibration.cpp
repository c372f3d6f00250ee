#include "dsp/events/vibration.h"

#include <algorithm>
#include <bit>
#include <cmath>
#include <limits>
#include <stdexcept>
#include <utility>

#include "core/units.h"
#include "dsp/contacts/contact_train.h"
#include "dsp/events/coil.h"
#include "dsp/filter/force.h"
#include "dsp/signal/spectrum.h"
#include "dsp/signal/statistics.h"

namespace powbench::dsp {

namespace {

constexpr double before_impact = 0.3e-3, after_impact = 5e-3;  // s

const ContactTrain& train_of(const Events& e, Channel film) {
  return film == Channel::pvdf_a ? e.pvdf_a : e.pvdf_b;
}

Force film_force(const Record& record, Channel film, const Events& events, const ExtractOptions& o) {
  const auto& hertz = events.coil.mains_hertz;
  return restore_force(record, film, o, hertz.known() ? std::optional(hertz.value) : std::nullopt);
}

std::span<const double> part(const Signal& s, double from, double to) {
  const std::size_t i = s.index_at(from), k = std::max(i, s.index_at(to));
  return std::span(s.value).subspan(i, k - i);
}

/// Standard deviation of the first differences: what is fast in a signal.
double fast_part(std::span<const double> x) {
  if (x.size() < 16) return 0;
  double sum = 0;
  for (std::size_t i = 1; i < x.size(); ++i) sum += (x[i] - x[i - 1]) * (x[i] - x[i - 1]);
  return std::sqrt(sum / static_cast<double>(x.size() - 1));
}

/// The channel that shows the core's vibration on the axis of `force`; empty when none moves at the impact.
Signal reference_for(const Record& record, const Signal& force, double impact, std::string& name) {
  for (const Channel c : {Channel::aux, Channel::laser}) {
    const Signal s = to_signal(record, c);
    if (s.empty()) continue;
    const double quiet = fast_part(part(s, s.t0, std::min(0.0, impact - 1e-3)));
    const double moved = fast_part(part(s, impact, impact + after_impact));
    if (!(moved > 2 * quiet) || !(moved > 0)) continue;
    name = info(c).name;
    return on_axis_of(s, force);
  }
  return {};
}

double shortest_contact(const ContactTrain& t) {
  double shortest = 1e-3;
  for (const Contact& c : t.contacts)
    if (c.release.known() && c.touch.known())
      shortest = std::min(shortest, std::max(c.release.value - c.touch.value, 20e-6));
  return shortest;
}

}  // namespace

Signal on_axis_of(const Signal& s, const Signal& axis) {
  Signal out;
  out.t0 = axis.t0;
  out.dt = axis.dt;
  out.value.resize(axis.size());
  out.masked.assign(axis.size(), mask_none);
  if (s.empty()) return {};
  for (std::size_t i = 0; i < axis.size(); ++i) {
    const double at = (axis.time(i) - s.t0) / s.dt, last = static_cast<double>(s.size() - 1);
    const auto k = static_cast<std::size_t>(std::clamp(at, 0.0, last));
    const std::size_t next = std::min(k + 1, s.size() - 1);
    const double share = std::clamp(at - static_cast<double>(k), 0.0, 1.0);
    out.value[i] = s.value[k] + share * (s.value[next] - s.value[k]);
    out.masked[i] = s.masked[k] | s.masked[next];
    if (at < 0 || at > last) out.masked[i] |= mask_edge;
  }
  return out;
}

FilmVibration film_vibration(const Record& record, Channel film, const Events& events,
                             const ExtractOptions& o, const FilmPath* path) {
  FilmVibration v;
  FilmPath own;
  if (!path) {
    own.force = film_force(record, film, events, o);
    ForceAnalysis a = analyse_force(own.force, closing_end(record, own.force.signal), events.core.seat, o);
    own.ring = std::move(a.ring), own.stripped = std::move(a.stripped);
    path = &own;
  }
  const Force& f = path->force;
  if (!f.present) return v;
  v.present = true;
  const auto seat = events.core.seat.known() ? std::optional(events.core.seat.value) : std::nullopt;
  v.force = f.signal;
  v.settled = f.settled;
  v.stripped = path->stripped;
  v.ring = path->ring;
  const ContactTrain& train = train_of(events, film);
  v.shortest = shortest_contact(train);
  v.impact = seat                      ? *seat
             : !v.ring.empty()         ? v.ring.onset
             : !train.contacts.empty() ? train.contacts.front().touch.value
                                       : 0.0;
  const Signal reference = reference_for(record, v.force, v.impact, v.reference);
  const double from = std::max(v.impact - before_impact, v.force.t0),
               to = std::min(v.impact + 2 * after_impact, v.force.end());
  if (reference.empty() || !(from < to)) return v;
  CancelOptions c;
  c.from = from;
  c.to = to;
  c.taps = static_cast<std::size_t>(std::clamp(std::lround(128e-6 * v.force.rate()), 8L, 128L));
  try {
    v.cancelled = cancel_reference(v.force, reference, c);
  } catch (const std::exception& e) {  // a record shorter than the high-pass remembers
    v.cancelled = Cancelled{v.force, {}, 0, true, e.what()};
  }
  return v;
}

BandReport bands_of_ring(const Ring& ring, const BandQuestion& q) {
  if (!(q.pulse_width > 0)) throw std::invalid_argument("pulse_width: allowed > 0 s");
  BandReport out;
  out.closings = 1;
  out.contact = {0, 1.5 / q.pulse_width};
  double all = 0, inside = 0, pulse = 0;
  for (const RingMode& m : ring.modes) {
    const double half = std::max(m.pole.decay / (2 * pi), 1.0);
    out.core.push_back({std::max(0.0, m.pole.hertz - half), m.pole.hertz + half});
    const double growth = std::exp(-2 * m.pole.decay * (ring.onset - ring.reference));
    const double energy =
        (m.cosine * m.cosine + m.sine * m.sine) * growth / (4 * std::max(m.pole.decay, 1e-9));
    all += energy;
    // a resonance has a share arctan(..)/pi of its energy below an edge
    inside += energy * (0.5 + std::atan((out.contact.high - m.pole.hertz) / half) / pi);
    pulse += half_sine_energy_below(out.core.back().high, q.pulse_width) -
             half_sine_energy_below(out.core.back().low, q.pulse_width);
  }
  std::sort(out.core.begin(), out.core.end(), [](const Band& a, const Band& b) { return a.low < b.low; });
  out.ring_in_contact_db = decibel(all > 0 ? inside / all : 0);
  out.pulse_in_core_db = decibel(pulse);
  out.overlaps = out.ring_in_contact_db > q.overlap_limit;
  return out;
}

std::optional<Closing> closing_of(const Record& record, Channel film, const Events& events,
                                  const ExtractOptions& o) {
  if (!events.core.seat.known()) return std::nullopt;
  Force f = film_force(record, film, events, o);
  if (!f.present) return std::nullopt;
  std::string name;
  Signal reference = reference_for(record, f.signal, events.core.seat.value, name);
  if (reference.empty()) return std::nullopt;
  return Closing{std::move(f.signal), std::move(reference), events.core.seat.value};
}

std::optional<BandReport> bands_of_closings(std::span<const Closing> closings, const BandQuestion& q) {
  if (closings.size() < 3) return std::nullopt;
  const double rate = closings.front().force.rate();
  const std::size_t n = std::bit_floor(static_cast<std::size_t>((before_impact + after_impact) * rate));
  if (n < 16) return std::nullopt;
  std::vector<std::span<const double>> x, y;
  for (const Closing& c : closings) {
    const std::size_t i = c.force.index_at(c.impact - before_impact);
    if (std::abs(c.force.rate() - rate) > 1e-6 * rate || i + n > c.force.size()) continue;
    x.push_back(std::span(c.reference.value).subspan(i, n));
    y.push_back(std::span(c.force.value).subspan(i, n));
  }
  if (x.size() < 3) return std::nullopt;
  SpectrumEstimator estimator(n, rate);
  return find_bands(estimator.shot_coherence(x, y), q);
}

Spectrogram spectrogram(const Signal& s, double from, double to, double window, std::size_t frames) {
  const double samples = s.empty() ? 0.0 : std::round(window * s.rate());
  if (s.empty() || !(from < to) || frames < 2 || !(samples >= 8) || !(samples <= 1e6))
    throw std::invalid_argument(
        "spectrogram: allowed a signal, from < to, 2 or more frames, windows of 8 samples or more");
  const auto n = static_cast<std::size_t>(samples);
  RealFft fft(good_length(4 * n));  // zeros behind the window: a smooth picture
  Spectrogram out;
  out.t0 = from;
  out.dt = (to - from) / static_cast<double>(frames - 1);
  out.frames = frames;
  out.bins = fft.size() / 2 + 1;
  out.bin_hertz = s.rate() / static_cast<double>(fft.size());
  std::vector<double> hann(n);
  double squares = 0;
  for (std::size_t i = 0; i < n; ++i) {
    hann[i] = 0.5 - 0.5 * std::cos(2 * pi * (static_cast<double>(i) + 0.5) / samples);
    squares += hann[i] * hann[i];
  }
  for (std::size_t k = 0; k < frames; ++k) {
    const double centre = out.t0 + static_cast<double>(k) * out.dt;
    const auto first = std::lround((centre - s.t0) / s.dt - 0.5 * (samples - 1));
    const auto t = fft.time();
    std::fill(t.begin(), t.end(), 0.0);
    double mean = 0;
    const auto at = [&](std::size_t i) {
      const long j = first + static_cast<long>(i);
      return j >= 0 && j < static_cast<long>(s.size()) ? s.value[static_cast<std::size_t>(j)] : 0.0;
    };
    for (std::size_t i = 0; i < n; ++i) mean += at(i) / samples;
    for (std::size_t i = 0; i < n; ++i) t[i] = (at(i) - mean) * hann[i];
    fft.forward();
    for (const auto& v : fft.spectrum()) out.density.push_back(2 * std::norm(v) * s.dt / squares);
  }
  return out;
}

}  // namespace powbench::dsp
