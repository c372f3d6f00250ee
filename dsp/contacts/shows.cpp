#include "dsp/contacts/shows.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <cstdio>
#include <span>

#include "dsp/signal/statistics.h"

namespace powbench::dsp {

namespace {

constexpr double clear = 6;        // standard deviations of the calm force
constexpr double faint = 8;        // the same: a contact whose peak is no larger is none
constexpr double beside = 0.5e-3;  // s
constexpr double larger_than_swing = 2.5;
constexpr double most_pull = 12,
                 breaking = 150e-6;  // a contact this much larger may pull for so long when it breaks

}  // namespace

CalmForce calm_force(const Signal& s, double noise, const ExtractOptions& o) {
  const double width = std::max(o.detection_width / s.dt, 1.0);
  return {bell_mean(s.value, width), noise * gaussian_noise_gain(width)};
}

bool swings_below_zero(const Force& f, const std::vector<Interval>& contacts, double t_end,
                       const ExtractOptions& o) {
  constexpr double quiet = 3e-3;  // s before the first touch, whose level may be a little off zero
  if (contacts.empty()) return false;
  const Signal& s = f.signal;
  const CalmForce calm = calm_force(s, f.noise, o);
  const double touch = contacts.front().touch;
  const std::size_t from = s.index_at(touch - quiet), first = s.index_at(touch);
  const double zero = first > from + 10 ? median(std::span(calm.value).subspan(from, first - from)) : 0.0;
  const double limit = std::min(zero, 0.0) - clear * calm.noise;
  const auto largest = [&](const Interval& c) {
    double top = 0;
    for (std::size_t i = s.index_at(c.touch); i < s.index_at(std::min(c.release, t_end)); ++i)
      top = std::max(top, calm.value[i]);
    return top;
  };
  std::size_t k = 0;
  for (std::size_t i = first; i < s.index_at(t_end); ++i) {
    if (calm.value[i] >= limit) continue;
    while (k + 1 < contacts.size() && contacts[k + 1].touch < s.time(i)) ++k;
    const Interval& c = contacts[k];
    const double since = s.time(i) - c.release;
    if (!(since > -breaking && since < breaking) || !(largest(c) > -most_pull * calm.value[i])) return true;
  }
  return false;
}

void drop_swings(std::vector<Contact>& contacts, const Signal& stripped, double noise,
                 const ExtractOptions& o) {
  if (contacts.empty()) return;
  const CalmForce calm = calm_force(stripped, noise, o);
  std::erase_if(contacts, [&](Contact& c) {
    if (!c.peak.known()) return false;
    if (!c.release.known())
      return c.peak.value < faint * calm.noise && stripped.end() - c.touch.value < beside;
    double lowest = 0;
    for (std::size_t i = stripped.index_at(c.touch.value - beside);
         i < stripped.index_at(c.release.value + beside); ++i)
      lowest = std::min(lowest, calm.value[i]);
    if (c.peak.value < faint * calm.noise) return true;
    if (!(lowest < -clear * calm.noise)) return false;
    const double smaller = -larger_than_swing * lowest / c.peak.value;  // 1 where it would go
    c.probability = 1 - 0.5 * smaller * smaller;
    return smaller > 1;
  });
}

Verdict verdict_of(const Force& f, const std::vector<Contact>& contacts, double t_end,
                   const ExtractOptions& o) {
  const Signal& s = f.signal;
  std::size_t lost = 0;
  for (const auto m : s.masked) lost += m != mask_none;
  if (!f.present || s.empty())
    return {Shows::not_usable, "no signal: the channel is missing or stays at one value"};
  if (2 * lost > s.size()) return {Shows::not_usable, "more than half of the samples are lost or clipped"};
  const CalmForce calm = calm_force(s, f.noise, o);
  double above = 0, below = 0, deepest = 0, largest = 0, swing = 0;
  const double from = contacts.empty() ? s.t0 : contacts.front().touch.value - beside;
  for (std::size_t i = s.index_at(from); i < s.index_at(t_end); ++i) {
    deepest = std::min(deepest, calm.value[i]);
    if (calm.value[i] > 3 * calm.noise) above += calm.value[i];
    if (calm.value[i] < -3 * calm.noise) below -= calm.value[i];
  }
  for (const Contact& c : contacts)
    if (c.peak.known()) largest = std::max(largest, c.peak.value);
  for (std::size_t i = s.index_at(0.0); i < s.index_at(t_end); ++i) swing = std::max(swing, -calm.value[i]);
  std::array<char, 128> text{};
  if (!contacts.empty() && swing > std::max(largest, faint * calm.noise)) {
    std::snprintf(text.data(), text.size(),
                  "swings to %.3g N below zero, and no contact presses with more than %.3g N", swing,
                  largest);
    return {Shows::vibration, text.data()};
  }
  if (contacts.empty() && deepest > -faint * calm.noise)
    return {Shows::nothing, "before switch-off nothing stands out of the noise that could be a contact"};
  if (!contacts.empty() && below <= most_below * above) return {Shows::contact, {}};
  std::snprintf(text.data(), text.size(),
                "swings below zero as above: impulse %.3g N s below, %.3g N s above; a contact only presses",
                below * s.dt, above * s.dt);
  return {Shows::vibration, text.data()};
}

}  // namespace powbench::dsp
