#include "dsp/filter/zero_level.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <cstdint>
#include <functional>
#include <vector>

#include "core/units.h"
#include "dsp/signal/least_squares.h"
#include "dsp/signal/statistics.h"

namespace powbench::dsp {

namespace {

constexpr double block_time = 0.1e-3;  // s
constexpr double calm = 1.6;           // scatter of an open block over the noise
constexpr std::size_t in_a_row = 4;    // blocks that an open one stands among
constexpr std::size_t beside = 3;      // blocks in which a contact rises
constexpr double before_touch = 2e-3;  // s after switch-on in which nothing touches
constexpr std::size_t together = 3;    // fewer open blocks tell nothing
constexpr double alike = 20;           // blocks of a wandering zero that tell as much as one: 2 ms

/// How far and how fast a zero may go, N and N/s: what 1.1 N of hum at 50 Hz does, but no more than a tenth of the
/// largest force and no more than twenty times the noise, whichever is larger. A contact that presses little is not
/// to be mistaken for it.
struct Reach {
  double jump = 1.2;      // at switch-on
  double farthest = 0.6;  // between two open blocks, however far apart
  double fastest = 350;
  double unforeseen = 50;  // with a model of the zero

  Reach(const Signal& s, double noise) {
    double largest = 0;
    for (const double v : s.value) largest = std::max(largest, std::abs(v));
    const double scale = std::min(1.0, std::max(0.1 * largest, 20 * noise) / farthest);
    for (double* v : {&jump, &farthest, &fastest, &unforeseen}) *v *= scale;
  }
};

struct Block {
  double time = 0, mean = 0, scatter = 0;
};

std::vector<Block> blocks_of(const Signal& s) {
  const auto n = std::max<std::size_t>(8, static_cast<std::size_t>(block_time / s.dt));
  std::vector<Block> out;
  for (std::size_t first = 0; first + n <= s.size(); first += n) {
    double sum = 0, squares = 0, slope = 0, width = 0;
    bool lost = false;
    for (std::size_t i = 0; i < n; ++i) {
      const double v = s.value[first + i], x = static_cast<double>(i) - 0.5 * static_cast<double>(n - 1);
      sum += v, squares += v * v, slope += x * v, width += x * x;
      lost = lost || s.masked[first + i];
    }
    const double mean = sum / static_cast<double>(n);
    const double left = squares - sum * mean - slope * slope / width;  // about a straight line
    const double scatter = std::sqrt(std::max(left, 0.0) / static_cast<double>(n - 2));
    out.push_back({s.time(first) + 0.5 * static_cast<double>(n - 1) * s.dt, mean, lost ? 1e300 : scatter});
  }
  return out;
}

/// What the zero does between and beyond open blocks: level, slope and mains, as far as the blocks on one side of
/// switch-on tell. Amplitudes have Gaussian priors, so that what is not seen is not made up.
class ZeroModel {
 public:
  ZeroModel(const std::vector<Block>& open, bool after, double sigma, double hertz) : w_(2 * pi * hertz) {
    constexpr std::array<double, unknowns> prior{0.5, 0.2, 0.6, 0.6, 0.1, 0.1};  // N
    std::vector<std::vector<double>> columns(unknowns);
    std::vector<double> y;
    for (const Block& b : open) {
      if ((b.time > 0) != after) continue;
      const auto row = basis(b.time);
      for (std::size_t k = 0; k < unknowns; ++k) columns[k].push_back(row[k] * prior[k] / sigma);
      y.push_back(b.mean / sigma);
    }
    if (y.empty()) return;
    for (std::size_t k = 0; k < unknowns; ++k) {
      for (std::size_t j = 0; j < unknowns; ++j) columns[j].push_back(j == k ? 1.0 : 0.0);
      y.push_back(0);
    }
    const LeastSquares fit = linear_least_squares(columns, y);
    for (std::size_t k = 0; k < unknowns; ++k) x_[k] = fit.x[k] * prior[k];
  }

  double operator()(double t) const {
    const auto row = basis(t);
    double sum = 0;
    for (std::size_t k = 0; k < unknowns; ++k) sum += row[k] * x_[k];
    return sum;
  }

 private:
  static constexpr std::size_t unknowns = 6;
  std::array<double, unknowns> basis(double t) const {
    const double a = w_ * t;
    return {1, t / 10e-3, std::sin(a), std::cos(a), std::sin(3 * a), std::cos(3 * a)};
  }
  double w_;
  std::array<double, unknowns> x_{};
};

/// 1: one of some blocks in a row that scatter like noise and lie on a straight line, or one of two or three between
/// contacts. A force that only dips towards zero is level for one block; a trough of vibration for two, and bends: no
/// more than before switch-on is allowed.
std::vector<std::uint8_t> level_blocks(const std::vector<Block>& blocks, double noise, double sigma,
                                       const Reach& reach) {
  const auto bend = [&](std::size_t i) {
    double sum = 0;
    for (std::size_t k = 0; k < in_a_row; ++k)
      sum += (k == 0 || k + 1 == in_a_row ? 1 : -1) * blocks[i + k].mean;
    return sum;
  };
  std::vector<double> idle;
  for (std::size_t i = 0; i + in_a_row <= blocks.size() && blocks[i + in_a_row - 1].time < 0; ++i)
    idle.push_back(bend(i));
  const double most = 4 * std::max(std::sqrt(static_cast<double>(in_a_row)) * sigma, robust_sigma(idle));
  std::vector<std::uint8_t> out(blocks.size());
  const auto calm_step = [&](std::size_t i) {
    return blocks[i].scatter < calm * noise &&
           std::abs(blocks[i].mean - blocks[i - 1].mean) < 4 * sigma + reach.fastest * block_time;
  };
  // to one side and the other of a short run a contact presses far more than the zero can go
  const auto between_contacts = [&](std::size_t first, std::size_t last) {
    const double mean = 0.5 * (blocks[first].mean + blocks[last - 1].mean);
    double left = 0, right = 0;
    for (std::size_t k = 1; k <= beside && k <= first && last + k <= blocks.size(); ++k) {
      const double l = blocks[first - k].mean - mean, r = blocks[last - 1 + k].mean - mean;
      if (std::abs(l) > std::abs(left)) left = l;
      if (std::abs(r) > std::abs(right)) right = r;
    }
    return left * right > 0 && std::min(std::abs(left), std::abs(right)) > reach.farthest;
  };
  for (std::size_t first = 0, last = 0; first < blocks.size(); first = last) {
    last = first + 1;
    if (!(blocks[first].scatter < calm * noise)) continue;
    while (last < blocks.size() && calm_step(last)) ++last;
    const auto mark = [&](std::size_t from, std::size_t count) {
      std::fill_n(out.begin() + static_cast<std::ptrdiff_t>(from), count, std::uint8_t{1});
    };
    for (std::size_t i = first; i + in_a_row <= last; ++i)
      if (std::abs(bend(i)) < most) mark(i, in_a_row);
    if (last - first < in_a_row && last - first > 1 && between_contacts(first, last))
      mark(first, last - first);
  }
  return out;
}

/// Open blocks of the level ones, given what the zero is expected to be.
std::vector<Block> open_blocks(const std::vector<Block>& blocks, const std::vector<std::uint8_t>& level,
                               double sigma, const Reach& reach,
                               const std::function<double(double)>& expected, bool first) {
  std::vector<Block> open;
  for (std::size_t i = 0; i < blocks.size(); ++i) {
    const Block& b = blocks[i];
    const double since = open.empty() ? 1e300 : b.time - open.back().time;
    const double step =
        b.mean - expected(b.time) - (open.empty() ? 0.0 : open.back().mean - expected(open.back().time));
    const bool switched_on = b.time > 0 && b.time < before_touch && !open.empty() && open.back().time < 0;
    const double rate = first ? reach.fastest : reach.unforeseen,
                 most = first ? reach.farthest : 0.5 * reach.farthest;
    if (level[i] && std::abs(step) < (switched_on ? reach.jump : std::min(8 * sigma + rate * since, most)))
      open.push_back(b);
    else if (first && b.time > before_touch && std::abs(step) > reach.farthest)
      break;  // something touches: what comes later waits for the model
  }
  return open;
}

/// Rms of what a millisecond adds to the zero beyond its model, without the share of the noise; 0 where it does not
/// stand out of that.
double wander_of(const std::vector<Block>& quiet, const std::function<double(double)>& expected,
                 double sigma) {
  constexpr double lag = 1e-3;  // s
  constexpr std::size_t few = 30;
  double squares = 0, n = 0;
  for (std::size_t i = 0, k = 0; i < quiet.size(); ++i) {
    while (k < quiet.size() && quiet[k].time < quiet[i].time + lag - 0.5 * block_time) ++k;
    if (k == quiet.size()) break;
    if (quiet[k].time > quiet[i].time + lag + 0.5 * block_time) continue;
    const double step = quiet[k].mean - expected(quiet[k].time) - quiet[i].mean + expected(quiet[i].time);
    squares += step * step, n += 1;
  }
  if (n < few) return 0;
  const double beyond = squares / n - 2 * sigma * sigma;
  return beyond > 4 * sigma * sigma ? std::sqrt(beyond) : 0;
}

}  // namespace

Zero follow_zero(Signal& s, double noise, double mains_hertz) {
  if (s.size() < 64 || !(noise > 0)) return {};
  const auto blocks = blocks_of(s);
  const double sigma = noise / std::sqrt(std::max(8.0, std::floor(block_time / s.dt)));
  const Reach reach(s, noise);
  const auto level = level_blocks(blocks, noise, sigma, reach);
  auto open = open_blocks(
      blocks, level, sigma, reach, [](double) { return 0.0; }, true);
  if (open.size() < together) return {};
  const auto quiet = open;
  double largest = 0;  // mean of a millisecond
  for (std::size_t k = 0; k + together <= open.size(); ++k) {
    double sum = 0;
    for (std::size_t j = k; j < k + together; ++j) sum += open[j].mean;
    largest = std::max(largest, std::abs(sum) / together);
  }
  if (largest < std::max(5 * sigma / std::sqrt(together), 0.5 * noise)) return {};
  // of a block about the model, as large as if no block knew of its neighbours: what is open tells it before the model
  // says what else is
  double spread = sigma;
  std::function<double(double)> expected;
  const auto learn = [&] {
    const ZeroModel before(open, false, spread, mains_hertz), after(open, true, spread, mains_hertz);
    expected = [before, after](double t) { return t > 0 ? after(t) : before(t); };
  };
  learn();
  spread = std::hypot(sigma, std::sqrt(alike) * wander_of(quiet, expected, sigma));
  for (int round = 0; round < 2; ++round) {
    learn();
    open = open_blocks(blocks, level, sigma, reach, expected, false);
  }
  if (open.size() < together) return {};
  std::vector<Block> left;  // of the model, neighbours averaged
  for (std::size_t k = 0; k < open.size(); ++k) {
    double mean = 0, time = 0, n = 0;
    for (std::size_t j = k > 0 ? k - 1 : 0; j < std::min(k + 2, open.size()); ++j)
      if (std::abs(open[j].time - open[k].time) < 1.5 * block_time)
        mean += open[j].mean - expected(open[j].time), time += open[j].time, n += 1;
    left.push_back({time / n, mean / n, 0});
  }
  std::size_t k = 0;
  for (std::size_t i = 0; i < s.size(); ++i) {
    const double t = s.time(i);
    while (k + 1 < left.size() && left[k + 1].time <= t) ++k;
    double zero = left[k].mean;
    if (t > left[k].time && k + 1 < left.size())
      zero += (t - left[k].time) / (left[k + 1].time - left[k].time) * (left[k + 1].mean - left[k].mean);
    s.value[i] -= zero + expected(t);
  }
  return {largest, wander_of(quiet, expected, sigma)};
}

}  // namespace powbench::dsp
