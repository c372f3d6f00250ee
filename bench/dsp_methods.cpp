#include "bench/dsp_methods.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <limits>

#include "dsp/contacts/contact_train.h"
#include "dsp/events/core_seat.h"
#include "dsp/filter/force.h"
#include "dsp/filter/sos.h"
#include "dsp/signal/least_squares.h"
#include "dsp/signal/statistics.h"

namespace powbench::bench {

namespace {

using namespace powbench::dsp;

constexpr double unknown = std::numeric_limits<double>::quiet_NaN();

Contact timed(double touch, double release) {
  Contact c;
  c.touch.value = touch;
  c.release.value = release;
  return c;
}

double cross(const Signal& s, std::size_t i, double level) {
  if (i == 0) return s.time(0);
  const double rise = s.value[i] - s.value[i - 1];
  return s.time(i - 1) + (rise != 0 ? (level - s.value[i - 1]) / rise : 0.0) * s.dt;
}

std::vector<Contact> two_levels(const Signal& s, double high, double low, double least_closed,
                                double least_open) {
  std::vector<Contact> raw, out;
  bool closed = false;
  for (std::size_t i = 0; i < s.size(); ++i) {
    if (!closed && s.value[i] > high)
      closed = true, raw.push_back(timed(cross(s, i, high), unknown));
    else if (closed && s.value[i] < low)
      closed = false, raw.back().release.value = cross(s, i, low);
  }
  for (const Contact& c : raw) {
    if (!out.empty() && c.touch.value - out.back().release.value < least_open)
      out.back().release = c.release;
    else
      out.push_back(c);
  }
  std::erase_if(out, [&](const Contact& c) { return c.release.value - c.touch.value < least_closed; });
  return out;
}

Signal zeroed(const Record& r) {
  Signal s = to_signal(r, Channel::pvdf_a);
  const double zero = median(std::span(s.value).first(s.index_at(0.0)));
  for (double& v : s.value) v -= zero;
  return s;
}

/// The textbook: band-pass 20 .. 4000 Hz forward and backward, edges and memory ignored, 10 % of the largest
/// value.
std::vector<Contact> threshold(const Record& r) {
  Signal s = zeroed(r);
  const auto band = to_sections({FilterKind::band, 4, 20, 4000, s.rate(), false});
  for (int pass = 0; pass < 2; ++pass) {
    filter_forward(band, s.value);
    std::reverse(s.value.begin(), s.value.end());
  }
  const double peak = *std::max_element(s.value.begin(), s.value.end());
  return two_levels(s, 0.10 * peak, 0.05 * peak, 50e-6, 30e-6);
}

/// Zero-phase low-pass 10 kHz, droop undone, 5 % of the largest value or six standard deviations.
Signal low_passed(const Record& r, bool without_hum) {
  Signal s;
  if (without_hum) {
    s = restore_force(r, Channel::pvdf_a, {}, std::nullopt).signal;
  } else {
    s = zeroed(r);
    undo_droop(s.value, r.find(Channel::pvdf_a)->corner_hertz, s.dt);
  }
  return filter_zero_phase(to_sections({FilterKind::low, 4, 0, 10e3, s.rate(), false}), s).signal;
}

std::vector<Contact> hysteresis_on(const Signal& s) {
  const double sigma = robust_sigma(std::span(s.value).first(s.index_at(0.0)));
  const double peak = *std::max_element(s.value.begin(), s.value.end());
  const double high = std::max(6 * sigma, 0.05 * peak);
  return two_levels(s, high, 0.5 * high, 50e-6, 30e-6);
}

std::vector<Contact> hysteresis(const Record& r) {
  return hysteresis_on(low_passed(r, false));
}

/// Line plus parabola beyond a kink on a grid of kinks, zero before.
double hinge(const Signal& s, double guess, int side, double open, double closed) {
  const double t1 = side > 0 ? guess - open : guess - closed, t2 = side > 0 ? guess + closed : guess + open;
  const std::size_t i1 = s.index_at(t1), i2 = s.index_at(t2);
  if (i2 < i1 + 8) return guess;
  const std::span y = std::span(s.value).subspan(i1, i2 - i1);
  std::vector<std::vector<double>> c(3, std::vector<double>(y.size(), 1.0));
  const double step = std::max(3e-6, 0.25 * s.dt);
  std::vector<double> at, cost;
  for (double k = -250e-6; k <= 30e-6; k += step) {
    const double kink = guess + side * k;
    if (kink < t1 + 2 * s.dt || kink > t2 - 3 * s.dt) continue;
    for (std::size_t i = 0; i < y.size(); ++i) {
      const double u = std::max(side * (s.time(i1 + i) - kink), 0.0) * 1e4;
      c[1][i] = u, c[2][i] = u * u;
    }
    at.push_back(kink);
    cost.push_back(linear_least_squares(c, y).chi2);
  }
  if (at.size() < 3) return guess;
  const auto k = static_cast<std::size_t>(std::min_element(cost.begin(), cost.end()) - cost.begin());
  if (k == 0 || k + 1 == at.size()) return at[k];
  const double bend = cost[k - 1] - 2 * cost[k] + cost[k + 1];
  return at[k] + (bend > 0 ? 0.5 * (cost[k - 1] - cost[k + 1]) / bend : 0.0) * (at[k + 1] - at[k]);
}

std::vector<Contact> hinged(const Record& r) {
  const auto coarse = hysteresis_on(low_passed(r, true));
  const Signal s = restore_force(r, Channel::pvdf_a, {}, std::nullopt).signal;
  auto out = coarse;
  for (std::size_t i = 0; i < coarse.size(); ++i) {
    const Contact& c = coarse[i];
    const double before = i ? c.touch.value - coarse[i - 1].release.value : 1.0;
    const double after = i + 1 < coarse.size() ? coarse[i + 1].touch.value - c.release.value : 1.0;
    const double width = c.release.known() ? c.release.value - c.touch.value : 1.0;
    const double closed = std::min(80e-6, std::max(30e-6, 0.45 * width));
    out[i].touch.value = hinge(s, c.touch.value, +1, std::min(300e-6, std::max(20e-6, 0.8 * before)), closed);
    if (c.release.known())
      out[i].release.value =
          hinge(s, c.release.value, -1, std::min(300e-6, std::max(20e-6, 0.8 * after)), closed);
  }
  return out;
}

std::vector<Contact> extracted(const Record& r, int modes) {
  ExtractOptions o;
  o.ring_modes = modes;
  const Force f = restore_force(r, Channel::pvdf_a, o, std::nullopt);
  if (!f.present) return {};
  const Measured seat = core_events(r, o).seat;
  return analyse_force(f, closing_end(r, f.signal), seat, o).train.contacts;
}

std::vector<Contact> pulse_fit(const Record& r) {
  return extracted(r, 0);
}
std::vector<Contact> full_chain(const Record& r) {
  return extracted(r, ExtractOptions{}.ring_modes);
}

constexpr std::array table{Method{"threshold", threshold}, Method{"hysteresis", hysteresis},
                           Method{"hinge", hinged}, Method{"pulse fit", pulse_fit},
                           Method{"full chain", full_chain}};

}  // namespace

std::span<const Method> methods() {
  return table;
}

}  // namespace powbench::bench
