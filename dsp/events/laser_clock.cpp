#include "dsp/events/laser_clock.h"

#include <algorithm>
#include <cmath>
#include <vector>

namespace powbench::dsp {

namespace {

/// In record samples: value n was new just after first + n * period.
struct Clock {
  double first = 0, period = 0;
  bool found = false;
};

/// Straight line through the changes, their numbers counted on from one to the next.
Clock clock_of(const std::vector<double>& change, double guess) {
  Clock c{0, guess, false};
  for (int pass = 0; pass < 3; ++pass) {
    double n = 0, sn = 0, sc = 0, snn = 0, snc = 0;
    const double count = static_cast<double>(change.size());
    for (std::size_t k = 0; k < change.size(); ++k) {
      if (k > 0) n += std::max(1.0, std::round((change[k] - change[k - 1]) / c.period));
      sn += n, sc += change[k], snn += n * n, snc += n * change[k];
    }
    const double det = count * snn - sn * sn;
    if (!(det > 0)) return c;
    c.period = (count * snc - sn * sc) / det;
    c.first = (sc - c.period * sn) / count - 0.5;  // the record looks half a sample later, on average
  }
  double n = 0;
  std::size_t off = 0;
  for (std::size_t k = 0; k < change.size(); ++k) {
    if (k > 0) n += std::max(1.0, std::round((change[k] - change[k - 1]) / c.period));
    const double after = change[k] - c.first - n * c.period;
    off += after < -0.5 || after > 1.5;
  }
  c.found = 20 * off < change.size();
  return c;
}

}  // namespace

Unheld unheld(const Signal& s, double t1, double t2) {
  Unheld out{s, 0};
  const std::size_t i1 = std::max<std::size_t>(1, s.index_at(t1)), i2 = s.index_at(t2);
  std::vector<double> change;
  std::vector<double> run;
  for (std::size_t i = i1; i < i2; ++i) {
    if (s.value[i] == s.value[i - 1] || s.masked[i] || s.masked[i - 1]) continue;
    if (!change.empty()) run.push_back(static_cast<double>(i) - change.back());
    change.push_back(static_cast<double>(i));
  }
  if (run.size() < 40) return out;
  // values that do not change make runs of two periods: a mean over the shorter ones is the first guess
  std::vector<double> sorted = run;
  std::nth_element(sorted.begin(), sorted.begin() + static_cast<std::ptrdiff_t>(sorted.size() / 2),
                   sorted.end());
  const double typical = sorted[sorted.size() / 2];
  double sum = 0, count = 0;
  for (const double r : run)
    if (r < 1.6 * typical) sum += r, count += 1;
  const double guess = sum / count;
  if (!(guess > 1.9)) return out;  // as fast as the record
  const Clock c = clock_of(change, guess);
  out.late = s.dt / std::sqrt(12.0);
  if (!c.found) return out;
  out.late = 0;
  const double from = static_cast<double>(i1) - c.first, to = static_cast<double>(i2) - c.first;
  double left = 0, right = 0, at = 0;
  bool begun = false;
  std::size_t i = i1;
  for (double n = std::ceil(from / c.period); (n + 1) * c.period < to; n += 1) {
    const double middle = c.first + (n + 0.5) * c.period;
    right = s.value[static_cast<std::size_t>(std::lround(middle))];
    for (; begun && i < i2 && static_cast<double>(i) <= middle; ++i)
      out.signal.value[i] = left + (right - left) * (static_cast<double>(i) - at) / (middle - at);
    if (!begun) i = static_cast<std::size_t>(std::ceil(middle));
    left = right, at = middle, begun = true;
  }
  return out;
}

}  // namespace powbench::dsp
