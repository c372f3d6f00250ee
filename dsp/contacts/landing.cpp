#include "dsp/contacts/landing.h"

#include <algorithm>
#include <cmath>
#include <limits>

namespace powbench::dsp {

namespace {

constexpr double one_edge = 0.5e-3;  ///< s between the two sightings of one edge

struct Window {
  double first = 0, last = 0;
  bool holds(const Measured& m) const { return m.known() && m.value >= first && m.value <= last; }
};

/// The crossing nearest to `t` among touches or releases; NaN when none is near.
double nearest(const std::vector<Interval>& unaided, double t, bool touch) {
  double best = std::numeric_limits<double>::quiet_NaN(), distance = one_edge;
  for (const Interval& i : unaided) {
    const double at = touch ? i.touch : i.release;
    if (!(std::abs(at - t) < distance)) continue;
    distance = std::abs(at - t), best = at;
  }
  return best;
}

/// Anywhere between the two sightings, as far as `hidden`; anywhere within the landing where there is only one. True
/// where that is worth a flag.
bool widen(Measured& m, double other, double hidden) {
  constexpr double worth_a_flag = 20e-6;  // s
  const double apart = std::isnan(other) ? landing_time : std::min(std::abs(other - m.value), hidden);
  const double share = apart / std::sqrt(12.0);
  m.u = std::hypot(m.u, share);
  return share > worth_a_flag;
}

}  // namespace

bool doubt_landing(std::vector<Contact>& contacts, const std::vector<Interval>& unaided, const Measured& seat,
                   double amplitude, const std::function<double(double, int)>& hidden) {
  if (!seat.known() || !(amplitude > 0)) return false;
  const double u = std::isfinite(seat.u) ? std::min(seat.u, 30e-6) : 30e-6;
  const Window window{seat.value - 3 * u, seat.value + landing_time};
  const auto gone = std::erase_if(contacts, [&](const Contact& c) {
    return c.release.known() && window.holds(c.touch) && c.peak.value < amplitude;
  });
  bool any = gone > 0;
  for (Contact& c : contacts) {
    const bool touch = window.holds(c.touch), release = window.holds(c.release);
    const auto doubted = [&](Measured& m, bool of_touch) {
      const double reach =
          hidden ? hidden(m.value, of_touch ? +1 : -1) : std::numeric_limits<double>::infinity();
      return widen(m, nearest(unaided, m.value, of_touch), reach);
    };
    bool far = touch && doubted(c.touch, true);
    if (release && doubted(c.release, false)) far = true;
    if (far) c.flags |= flag_ring_overlap, any = true;
  }
  return any;
}

}  // namespace powbench::dsp
