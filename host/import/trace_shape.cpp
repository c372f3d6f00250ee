#include "host/import/trace_shape.h"

#include <algorithm>
#include <array>
#include <cmath>

#include "core/phase.h"
#include "dsp/events/switch_off.h"

namespace powbench::host {
namespace {

/// When a fraction of the way from `start` to `end` is first passed, s, by the median of five samples.
double passes(const std::vector<double>& t, const std::vector<double>& v, double start, double end,
              double fraction) {
  const double sign = end > start ? 1 : -1, level = sign * (start + fraction * (end - start));
  for (std::size_t i = 2; i + 2 < v.size(); ++i) {
    std::array<double, 5> five{v[i - 2], v[i - 1], v[i], v[i + 1], v[i + 2]};
    for (double& x : five) x *= sign;
    std::nth_element(five.begin(), five.begin() + 2, five.end());
    if (five[2] > level) return t[i];
  }
  return t.back();
}

/// Share of the variance of v that a mean and the best sine of 45 to 65 Hz explain; the rest is noise and others.
double sine_share(const std::vector<double>& t, const std::vector<double>& v, std::size_t from,
                  std::size_t to) {
  double best = 0;
  for (double hertz = 45; hertz <= 65; hertz += 1) {
    // least squares of mean, cosine and sine, by normal equations
    std::array<std::array<double, 4>, 3> m{};
    double vv = 0, sum = 0;
    for (std::size_t i = from; i < to; ++i) {
      const double phase = 2 * pi * hertz * t[i];
      const std::array<double, 3> row{1.0, std::cos(phase), std::sin(phase)};
      for (std::size_t a = 0; a < 3; ++a) {
        for (std::size_t b = 0; b < 3; ++b) m[a][b] += row[a] * row[b];
        m[a][3] += row[a] * v[i];
      }
      vv += v[i] * v[i], sum += v[i];
    }
    const auto n = static_cast<double>(to - from);
    const double total = vv - sum * sum / n;
    if (!(total > 0)) return 0;
    const std::array<double, 3> rhs{m[0][3], m[1][3], m[2][3]};
    bool singular = false;
    for (std::size_t p = 0; p < 3; ++p)
      for (std::size_t r = p + 1; r < 3; ++r) {
        if (std::abs(m[p][p]) < 1e-12) singular = true;
        const double f = m[r][p] / m[p][p];
        for (std::size_t c = p; c < 4; ++c) m[r][c] -= f * m[p][c];
      }
    if (singular) continue;
    std::array<double, 3> x{};
    for (std::size_t p = 3; p-- > 0;) {
      double s = m[p][3];
      for (std::size_t c = p + 1; c < 3; ++c) s -= m[p][c] * x[c];
      x[p] = s / m[p][p];
    }
    const double fitted = x[0] * rhs[0] + x[1] * rhs[1] + x[2] * rhs[2] - sum * sum / n;
    best = std::max(best, fitted / total);
  }
  return best;
}

double mean(const std::vector<double>& v, std::size_t from, std::size_t to) {
  double sum = 0;
  for (std::size_t i = from; i < to; ++i) sum += v[i];
  return sum / static_cast<double>(to - from);
}

double rms(const std::vector<double>& v, std::size_t from, std::size_t to) {
  const double m = mean(v, from, to);
  double sum = 0;
  for (std::size_t i = from; i < to; ++i) sum += (v[i] - m) * (v[i] - m);
  return std::sqrt(sum / static_cast<double>(to - from));
}

/// Of `TraceShape::slowing`. x ~ t^2 gives 0.6 and x ~ t^3 0.5; a current of 1 - exp(-t / T) gives 2.7, and more with
/// the dip that the moving core makes.
constexpr double quickens = 1.0, either = 1.5, slows = 2.0;

}  // namespace

double returns_at(const std::vector<double>& time, const std::vector<double>& column) {
  constexpr double never = std::numeric_limits<double>::infinity();
  constexpr std::size_t most = 20'000;  // 10 us in a record of 200 ms
  std::vector<double> t, v;
  for (std::size_t i = 0; i < column.size(); ++i)
    if (std::isfinite(column[i]) && std::isfinite(time[i]) && (t.empty() || time[i] > t.back()))
      t.push_back(time[i]), v.push_back(column[i]);
  if (t.size() < 60) return never;
  dsp::Signal s;
  const std::size_t n = std::min(t.size(), most);
  s.t0 = t.front(), s.dt = (t.back() - t.front()) / static_cast<double>(n - 1);
  s.masked.assign(n, 0);
  for (std::size_t i = 0, k = 0; i < n; ++i) {
    while (k + 2 < t.size() && t[k + 1] <= s.time(i)) ++k;
    const double share = std::clamp((s.time(i) - t[k]) / (t[k + 1] - t[k]), 0.0, 1.0);
    s.value.push_back(v[k] + share * (v[k + 1] - v[k]));
  }
  const double at = dsp::left_at(s);
  return std::isfinite(at) ? at : never;
}

std::optional<TraceShape> shape_of(const std::vector<double>& time, const std::vector<double>& column,
                                   const CoilOn& on) {
  std::vector<double> t, v;
  const std::size_t step = std::max<std::size_t>(1, column.size() / 4000);
  for (std::size_t i = 0; i < column.size(); i += step)
    if (std::isfinite(column[i]) && std::isfinite(time[i]) && time[i] < on.to)
      t.push_back(time[i]), v.push_back(column[i]);
  const std::size_t n = v.size();
  if (n < 60) return std::nullopt;
  TraceShape s;
  s.low = *std::min_element(v.begin(), v.end()), s.high = *std::max_element(v.begin(), v.end());
  std::size_t rest = n / 5;
  while (rest > n / 50 + 2 && t[rest - 1] >= on.from) --rest;
  s.early = rms(v, 0, rest), s.late = rms(v, 2 * n / 3, n);
  s.sine_early = sine_share(t, v, 0, n / 3), s.sine_late = sine_share(t, v, 2 * n / 3, n);
  s.start = mean(v, 0, n / 10), s.end = mean(v, n - n / 10, n);
  s.last = rms(v, n - n / 5, n), s.middle = mean(v, 2 * n / 3, n);
  double swing = 0, later = 0;
  for (std::size_t i = 0; i < n; ++i) {
    swing = std::max(swing, std::abs(v[i] - s.start));
    if (i >= n - n / 5) later = std::max(later, std::abs(v[i] - s.start));
  }
  if (later > 0) s.inrush = swing / later;
  const double distance = s.distance();
  if (!(distance > 0)) return s;
  const double at[] = {passes(t, v, s.start, s.end, 0.1), passes(t, v, s.start, s.end, 0.5),
                       passes(t, v, s.start, s.end, 0.9)};
  s.rise = at[2] - at[0];
  if (at[1] > at[0]) s.slowing = (at[2] - at[1]) / (at[1] - at[0]);
  std::size_t between = 0;
  for (const double x : v) {
    if (std::abs(x - s.start) > 0.15 * distance && std::abs(x - s.end) > 0.15 * distance) ++between;
    s.beyond =
        std::max(s.beyond, std::max(std::min(s.start, s.end) - x, x - std::max(s.start, s.end)) / distance);
  }
  s.between = static_cast<double>(between) / static_cast<double>(n);
  s.passing = std::min(s.rise, s.between * (t.back() - t.front()));
  return s;
}

std::optional<Looks> shaped(const TraceShape& s) {
  constexpr double a_sine = 0.9, nearly_all = 0.97;
  constexpr double an_inrush = 1.5;  // the closed magnet takes a fraction of the current of the open one
  const auto sure_if = [](bool sure) { return sure ? Sureness::sure : Sureness::likely; };
  if (s.sine_early > a_sine && s.sine_late > a_sine && s.early > 0.5 * s.late)
    return Looks{Channel::mains_voltage, sure_if(std::min(s.sine_early, s.sine_late) > nearly_all),
                 "a sine of mains frequency from beginning to end"};
  if (s.early < 0.2 * s.late && s.sine_late > 0.5 && s.inrush > an_inrush &&
      std::abs(s.middle - s.start) < s.late)
    return Looks{Channel::coil_current, sure_if(s.inrush > 2 * an_inrush && s.sine_late > a_sine),
                 "rest, then pulsation of mains frequency that is largest at its beginning"};
  if (s.sine_late > a_sine && s.early < 0.2 * s.late && s.span() > 20)
    return Looks{Channel::coil_voltage, sure_if(s.sine_late > nearly_all && s.span() > 200),
                 "rest, then a sine of mains frequency of some volts and more"};
  if (!s.arrives()) return std::nullopt;
  if (s.passing < slow_rise && std::abs(s.end) < 0.1 * std::abs(s.start) && s.between < 0.03)
    return Looks{Channel::contact_a, sure_if(s.passing < 0.2 * slow_rise && s.between < 0.01),
                 "one level, then zero, hardly anything between"};
  if (s.passing < slow_rise || s.beyond > 0.35 || s.between > 0.5) return std::nullopt;
  if (s.slowing < either && s.between < 0.3)
    return Looks{Channel::laser, sure_if(s.slowing < quickens),
                 "rest, then a motion that ends at another level"};
  if (s.slowing > slows)
    return Looks{Channel::coil_current, sure_if(s.slowing > 1.3 * slows),
                 "rest, then a rise that slows down to another level, as in a DC coil"};
  return std::nullopt;
}

}  // namespace powbench::host
