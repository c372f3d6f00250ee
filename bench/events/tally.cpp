#include "bench/events/tally.h"

#include <algorithm>
#include <cmath>
#include <iterator>
#include <limits>

#include "dsp/signal/statistics.h"

namespace powbench::bench {

namespace {

constexpr double window = 300e-6;  // s

double root_mean_square(const std::vector<double>& x) {
  double sum = 0;
  for (const double v : x) sum += v * v;
  return std::sqrt(sum / static_cast<double>(x.size()));
}

double share(int part, int whole) {
  return whole > 0 ? static_cast<double>(part) / whole : std::numeric_limits<double>::quiet_NaN();
}

}  // namespace

double QuantityErrors::rms() const {
  return root_mean_square(error);
}
double QuantityErrors::spread() const {
  return root_mean_square(z);
}

double QuantityErrors::median() const {
  std::vector<double> size = error;
  for (double& v : size) v = std::abs(v);
  return size.empty() ? std::numeric_limits<double>::quiet_NaN() : dsp::median(size);
}

double QuantityErrors::bias() const {
  return error.empty() ? std::numeric_limits<double>::quiet_NaN() : dsp::median(error);
}

double QuantityErrors::beyond() const {
  return share(static_cast<int>(std::count_if(z.begin(), z.end(), [](double v) { return std::abs(v) > 3; })),
               static_cast<int>(z.size()));
}

void QuantityErrors::add(const Measured& found, double truth) {
  if (!found.known() || !std::isfinite(truth)) return;
  error.push_back(found.value - truth);
  z.push_back(error.back() / (found.u > 0 ? found.u : 1e-12));
}

void QuantityErrors::add(const QuantityErrors& o) {
  error.insert(error.end(), o.error.begin(), o.error.end());
  z.insert(z.end(), o.z.begin(), o.z.end());
}

double Tally::recall() const {
  return share(matched, matched + missed);
}
double Tally::precision() const {
  return share(matched, matched + invented);
}
double Tally::exact_share() const {
  return share(exact, records);
}

void Tally::add(const std::vector<TrueContact>& truth, const ContactTrain& train) {
  const std::vector<Contact>& found = train.contacts;
  std::vector<bool> used(found.size(), false);
  int pairs = 0;
  const auto beside = [&](double seconds) -> QuantityErrors& {
    const auto at =
        std::lower_bound(longest_opening.begin(), std::prev(longest_opening.end()), 1e3 * seconds);
    return beside_opening[static_cast<std::size_t>(at - longest_opening.begin())];
  };
  for (std::size_t k = 0; k < truth.size(); ++k) {
    const TrueContact& c = truth[k];
    std::size_t best = found.size();
    double distance = window;
    for (std::size_t j = 0; j < found.size(); ++j) {
      const double d = std::abs(found[j].touch.value - c.touch);
      if (!used[j] && d < distance) distance = d, best = j;
    }
    if (best == found.size()) continue;
    used[best] = true;
    ++pairs;
    touch.add(found[best].touch, c.touch);
    if (k > 0) beside(c.touch - truth[k - 1].release).add(found[best].touch, c.touch);
    if (k + 1 < truth.size()) beside(truth[k + 1].touch - c.release).add(found[best].release, c.release);
    if (std::isfinite(c.release)) {
      release.add(found[best].release, c.release);
      peak.add(found[best].peak, c.peak);
    }
  }
  if (!truth.empty() && !std::isfinite(truth.back().release)) settled.add(train.settled, truth.back().touch);
  for (std::size_t j = 0; j < found.size(); ++j) {
    if (!(found[j].probability < 0.9)) continue;
    ++doubted.listed;
    doubted.real += used[j];
    doubted.expected += found[j].probability;
  }
  ++records;
  matched += pairs;
  missed += static_cast<int>(truth.size()) - pairs;
  invented += static_cast<int>(found.size()) - pairs;
  exact += found.size() == truth.size() && pairs == static_cast<int>(truth.size());
  contacts += static_cast<int>(found.size());
  flagged += static_cast<int>(
      std::count_if(found.begin(), found.end(), [](const Contact& c) { return c.flags != flag_none; }));
}

void Tally::add(const Tally& o) {
  records += o.records, exact += o.exact, matched += o.matched, missed += o.missed, invented += o.invented;
  flagged += o.flagged, contacts += o.contacts;
  doubted.listed += o.doubted.listed, doubted.real += o.doubted.real, doubted.expected += o.doubted.expected;
  for (std::size_t k = 0; k < beside_opening.size(); ++k) beside_opening[k].add(o.beside_opening[k]);
  touch.add(o.touch), release.add(o.release), peak.add(o.peak), settled.add(o.settled);
}

}  // namespace powbench::bench
