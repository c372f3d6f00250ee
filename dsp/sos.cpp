#include "dsp/sos.h"

#include <algorithm>
#include <cmath>
#include <string>

namespace powbench::dsp {

namespace {

struct State {
  double s1 = 0, s2 = 0;
};

double step(const Section& q, State& s, double x) {
  const double y = q.b0 * x + s.s1;
  s.s1 = q.b1 * x - q.a1 * y + s.s2;
  s.s2 = q.b2 * x - q.a2 * y;
  return y;
}

/// State of every section after an endless input of `level`.
std::vector<State> steady_state(std::span<const Section> sections, double level) {
  std::vector<State> states;
  for (const Section& q : sections) {
    const double y = level * (q.b0 + q.b1 + q.b2) / (1 + q.a1 + q.a2);
    State s;
    s.s2 = q.b2 * level - q.a2 * y;
    s.s1 = y - q.b0 * level;
    states.push_back(s);
    level = y;
  }
  return states;
}

/// All sections in one sweep over the samples. A silent tail is flushed to zero before it turns subnormal.
template <class Iterator>
void run(std::span<const Section> sections, std::vector<State>& states, Iterator first, Iterator last) {
  std::size_t since_flush = 0;
  for (; first != last; ++first) {
    double v = *first;
    for (std::size_t k = 0; k < sections.size(); ++k) v = step(sections[k], states[k], v);
    *first = v;
    if (++since_flush == 1024) {
      since_flush = 0;
      for (State& s : states) {
        if (std::abs(s.s1) < 1e-280) s.s1 = 0;
        if (std::abs(s.s2) < 1e-280) s.s2 = 0;
      }
    }
  }
}

}  // namespace

FilterMemoryError::FilterMemoryError(std::size_t record_samples, std::size_t memory_samples)
    : std::invalid_argument("record of " + std::to_string(record_samples) +
                            " samples is shorter than the filter's memory of " +
                            std::to_string(memory_samples)) {}

void filter_forward(std::span<const Section> sections, std::span<double> x) {
  std::vector<State> states(sections.size());
  run(sections, states, x.begin(), x.end());
}

std::size_t filter_memory(std::span<const Section> sections, double tolerance, std::size_t limit) {
  std::vector<State> states(sections.size());
  double radius = 0;
  for (const Section& q : sections) {
    const double discriminant = q.a1 * q.a1 / 4 - q.a2;
    radius =
        std::max(radius, discriminant < 0 ? std::sqrt(q.a2) : std::abs(q.a1) / 2 + std::sqrt(discriminant));
  }
  // Quiet for several time constants of the slowest pole: nothing can come back.
  const double patience = radius < 1 ? 5.0 / -std::log(std::max(radius, 1e-9)) : static_cast<double>(limit);
  double peak = 0, x = 1;
  std::size_t last = 0;
  for (std::size_t n = 0; n < limit; ++n) {
    double v = x;
    for (std::size_t k = 0; k < sections.size(); ++k) v = step(sections[k], states[k], v);
    x = 0;
    peak = std::max(peak, std::abs(v));
    if (std::abs(v) > tolerance * peak) last = n;
    if (static_cast<double>(n - last) > patience + 8) return last + 1;
  }
  return limit;
}

ZeroPhase filter_zero_phase(std::span<const Section> sections, const Signal& in) {
  ZeroPhase out{in, filter_memory(sections, 1e-3, in.size() + 1)};
  auto& x = out.signal.value;
  if (x.size() < out.memory || x.empty()) throw FilterMemoryError(x.size(), out.memory);
  auto states = steady_state(sections, x.front());
  run(sections, states, x.begin(), x.end());
  states = steady_state(sections, x.back());
  run(sections, states, x.rbegin(), x.rend());
  const std::size_t edge = std::min(out.memory, x.size());
  for (std::size_t i = 0; i < edge; ++i) {
    out.signal.masked[i] |= mask_edge;
    out.signal.masked[x.size() - 1 - i] |= mask_edge;
  }
  return out;
}

}  // namespace powbench::dsp
