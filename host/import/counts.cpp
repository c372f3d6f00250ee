#include "host/import/counts.h"

#include <algorithm>
#include <cmath>
#include <limits>

namespace powbench::host {

namespace {

constexpr double most_steps = 65'000;
constexpr double own_steps = 64'000;
constexpr std::int16_t no_low = std::numeric_limits<std::int16_t>::min();
constexpr std::int16_t no_high = std::numeric_limits<std::int16_t>::max();

struct Grid {
  double step = 0, origin = 0;  ///< value = origin + k step
};

/// The step all values are multiples of, to 5 % of it; step 0 when there is none of at most `most_steps`.
Grid find_grid(const std::vector<double>& sorted) {
  const double range = sorted.back() - sorted.front();
  // texts carry digits, not bits: values closer than this are the same one
  const double same =
      std::max(1e-12 * std::max(std::abs(sorted.front()), std::abs(sorted.back())), range / most_steps / 20);
  double step = range;
  std::vector<double> distinct{sorted.front()};
  for (const double v : sorted) {
    if (v - distinct.back() <= same) continue;
    step = std::min(step, v - distinct.back());
    distinct.push_back(v);
  }
  if (distinct.size() < 2 || range / step > most_steps) return {};
  // the smallest difference is a rough step; it sharpens as the values further out are reached
  for (std::size_t i = 1; i < distinct.size(); ++i) {
    const double away = distinct[i] - distinct.front(), k = std::round(away / step);
    if (std::abs(away - k * step) > 0.05 * step) return {};
    if (k > 0) step += (away / k - step) * std::min(1.0, k / 100.0);
  }
  return range / step <= most_steps ? Grid{step, distinct.front()} : Grid{};
}

/// All values are multiples of `step`, to 5 % of it, and their counts fit 16 bits.
bool counts_of_step(const std::vector<double>& sorted, double step) {
  if (!std::isfinite(step) || step == 0) return false;
  return std::all_of(sorted.begin(), sorted.end(), [step](double v) {
    const double k = v / step;
    return std::abs(k) < 32'767 && std::abs(k - std::round(k)) < 0.05;
  });
}

/// True where nearly every sample of the first twentieth differs from the one before it.
bool noisy_beginning(const std::vector<std::int16_t>& raw, const std::vector<bool>& valid) {
  std::size_t pairs = 0, differ = 0;
  for (std::size_t i = 1; i < raw.size() / 20; ++i)
    if (valid[i] && valid[i - 1]) ++pairs, differ += raw[i] != raw[i - 1];
  return pairs >= 50 && 5 * differ > 4 * pairs;
}

/// Samples stuck at one end: they leave it again, and the counts next to it are rare. `end` +1: the largest count.
std::size_t stuck(const std::vector<std::int16_t>& raw, const std::vector<bool>& valid, int end) {
  int extreme = end > 0 ? no_low : no_high;
  for (std::size_t i = 0; i < raw.size(); ++i)
    if (valid[i]) extreme = end > 0 ? std::max<int>(extreme, raw[i]) : std::min<int>(extreme, raw[i]);
  std::size_t at = 0, beside = 0, run = 0, longest = 0, last = 0;
  for (std::size_t i = 0; i < raw.size(); ++i) {
    if (!valid[i]) continue;
    const int depth = end * (extreme - raw[i]);
    run = depth == 0 ? run + 1 : 0;
    longest = std::max(longest, run);
    if (depth == 0) ++at, last = i;
    if (depth >= 1 && depth <= 4) ++beside;
  }
  const bool noisy = noisy_beginning(raw, valid);
  // a force that is saturated for most of the record, to its end, is told from a made one without noise by the rest
  const bool leaves = last + raw.size() / 20 < raw.size() || noisy;
  const bool few = at < raw.size() / 4 || noisy;
  return longest >= 8 && leaves && few && static_cast<double>(at) > 5.0 * static_cast<double>(beside) ? at
                                                                                                      : 0;
}

/// Median of the first hundredth.
double beginning(std::span<const double> values, const std::vector<bool>& valid) {
  std::vector<double> first;
  for (std::size_t i = 0; i < values.size() && (first.empty() || i < values.size() / 100); ++i)
    if (valid[i]) first.push_back(values[i]);
  const auto middle = first.begin() + static_cast<std::ptrdiff_t>(first.size() / 2);
  std::nth_element(first.begin(), middle, first.end());
  return *middle;
}

}  // namespace

CountsNote to_counts(std::span<const double> values, const std::vector<bool>& valid, bool find_clipping,
                     double known_step, ChannelRecord& to) {
  CountsNote note;
  std::vector<double> sorted;
  for (std::size_t i = 0; i < values.size(); ++i)
    if (valid[i]) sorted.push_back(values[i]);
  to.raw.assign(values.size(), 0);
  if (sorted.empty()) return note;
  std::sort(sorted.begin(), sorted.end());
  const double low = sorted.front(), range = sorted.back() - low;
  Grid grid;
  const bool known = counts_of_step(sorted, known_step);
  if (known)
    grid = {known_step, 0.0};
  else if (range > 0)
    grid = find_grid(sorted);
  note.grid = grid.step != 0;
  if (!note.grid) {
    const double size = std::max(std::abs(low), std::abs(sorted.back()));
    grid = {range > 0 ? range / own_steps : (size > 0 ? size / own_steps : 1.0), low};
  }
  const double half = known ? 0.0 : range > 0 ? std::round(0.5 * range / grid.step) : 0.0;
  to.scale = note.step = grid.step;
  to.offset = grid.origin / grid.step + half;
  for (std::size_t i = 0; i < values.size(); ++i)
    if (valid[i])
      to.raw[i] = static_cast<std::int16_t>(
          std::clamp(std::round((values[i] - grid.origin) / grid.step) - half, -32'767.0, 32'766.0));
  to.clip_low = no_low;
  to.clip_high = no_high;
  if (!find_clipping || !(range > 0)) return note;
  const double high = sorted.back() - beginning(values, valid), deep = beginning(values, valid) - low;
  note.clipped = stuck(to.raw, valid, high >= deep ? +1 : -1);
  if (note.clipped == 0) return note;
  if (high >= deep)
    to.clip_high = static_cast<std::int16_t>(std::lround((sorted.back() - grid.origin) / grid.step - half));
  else
    to.clip_low = static_cast<std::int16_t>(std::lround((low - grid.origin) / grid.step - half));
  return note;
}

void set_clip(ChannelRecord& c, double low, double high) {
  double a = (low / c.scale) - c.offset, b = (high / c.scale) - c.offset;
  if (c.scale < 0) std::swap(a, b);
  if (!std::isnan(a))
    c.clip_low = static_cast<std::int16_t>(std::clamp(std::floor(a + 0.01), -32'768.0, 32'767.0));
  if (!std::isnan(b))
    c.clip_high = static_cast<std::int16_t>(std::clamp(std::ceil(b - 0.01), -32'768.0, 32'767.0));
}

}  // namespace powbench::host
