#include "dsp/signal/signal.h"

#include <algorithm>
#include <cmath>
#include <stdexcept>
#include <string>

namespace powbench::dsp {

std::size_t Signal::index_at(double t) const {
  if (empty()) return 0;
  const double i = std::ceil((t - t0) / dt - 1e-9);
  if (!(i > 0)) return 0;
  return i >= static_cast<double>(size()) ? size() : static_cast<std::size_t>(i);
}

std::uint8_t Signal::mask_within(double t1, double t2) const {
  std::uint8_t bits = mask_none;
  for (std::size_t i = index_at(t1); i < size() && time(i) <= t2; ++i) bits |= masked[i];
  return bits;
}

void bridge_gaps(Signal& s) {
  const std::size_t n = s.size();
  for (std::size_t i = 0; i < n; ++i)
    if (!std::isfinite(s.value[i])) s.masked[i] |= mask_gap;
  for (std::size_t i = 0; i < n;) {
    if (!(s.masked[i] & mask_gap)) {
      ++i;
      continue;
    }
    std::size_t j = i;
    while (j < n && (s.masked[j] & mask_gap)) ++j;
    const bool before = i > 0, after = j < n;
    const double left = before ? s.value[i - 1] : (after ? s.value[j] : 0.0);
    const double right = after ? s.value[j] : left;
    const double span = static_cast<double>(j - i + 1);
    for (std::size_t k = i; k < j; ++k)
      s.value[k] = left + (right - left) * static_cast<double>(k - i + 1) / span;
    i = j;
  }
}

Signal to_signal(const Record& record, Channel channel) {
  Signal s;
  const ChannelRecord* c = record.find(channel);
  if (!c || c->raw.empty()) return s;
  if (!(record.sample_rate > 0) || !std::isfinite(record.sample_rate))
    throw std::invalid_argument("sample_rate = " + std::to_string(record.sample_rate) + ": allowed > 0 Hz");
  if (c->scale == 0.0 || !std::isfinite(c->scale) || !std::isfinite(c->offset) || !std::isfinite(c->delay))
    throw std::invalid_argument("channel " + std::string(info(channel).name) + ": scale = " +
                                std::to_string(c->scale) + ", offset = " + std::to_string(c->offset) +
                                ", delay = " + std::to_string(c->delay) + ": allowed finite, scale not 0");
  const std::size_t n = c->raw.size();
  s.dt = 1.0 / record.sample_rate;
  s.t0 = record.time(0) - c->delay;
  s.value.resize(n);
  s.masked.assign(n, mask_none);
  for (std::size_t i = 0; i < n; ++i) {
    s.value[i] = c->value(i);
    if (c->raw[i] <= c->clip_low || c->raw[i] >= c->clip_high) s.masked[i] = mask_clipped;
  }
  for (const auto* gaps : {&record.gaps, &c->gaps})
    for (const Gap& gap : *gaps) {
      const auto last = std::min<std::int64_t>(gap.first + gap.count, static_cast<std::int64_t>(n));
      for (std::int64_t i = std::max<std::int64_t>(gap.first, 0); i < last; ++i)
        s.masked[static_cast<std::size_t>(i)] = mask_gap;
    }
  bridge_gaps(s);
  return s;
}

}  // namespace powbench::dsp
