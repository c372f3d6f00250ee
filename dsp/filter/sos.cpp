#include "dsp/filter/sos.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <string>

#include "dsp/filter/cascade.h"

namespace powbench::dsp {

namespace {

/// Time constant of the slowest pole, samples.
double time_constant(std::span<const Section> sections) {
  double radius = 0;
  for (const Section& q : sections) {
    const double a1 = q.a1(), a2 = q.a2(), discriminant = a1 * a1 / 4 - a2;
    radius = std::max(radius, discriminant < 0 ? std::sqrt(a2) : std::abs(a1) / 2 + std::sqrt(discriminant));
  }
  return radius < 1 ? 1.0 / -std::log(std::max(radius, 1e-9)) : 1e300;
}

}  // namespace

FilterMemoryError::FilterMemoryError(std::size_t record_samples, std::size_t memory_samples)
    : std::invalid_argument("record of " + std::to_string(record_samples) +
                            " samples is shorter than the filter's memory of " +
                            std::to_string(memory_samples)) {}

void filter_forward(std::span<const Section> sections, std::span<double> x) {
  const SosProgram program(sections);
  auto state = program.rest();
  best_sos_kernel().run_one(program.loop(), state.data(), x.data(), 1, x.size());
}

std::size_t filter_memory(std::span<const Section> sections, double tolerance, std::size_t limit) {
  const SosProgram program(sections);
  auto state = program.rest();
  // Quiet for several time constants of the slowest pole: nothing can come back.
  const double patience = 5.0 * time_constant(sections) + 8;
  double peak = 0;
  std::size_t last = 0;
  std::array<double, 1024> block{1.0};
  for (std::size_t start = 0; start < limit; start += block.size()) {
    const std::size_t n = std::min(block.size(), limit - start);
    best_sos_kernel().run_one(program.loop(), state.data(), block.data(), 1, n);
    for (std::size_t i = 0; i < n; ++i) {
      const double v = std::abs(block[i]);
      peak = std::max(peak, v);
      if (v > tolerance * peak) last = start + i;
    }
    if (static_cast<double>(start + n - last) > patience) return last + 1;
    block.fill(0.0);
  }
  return limit;
}

ZeroPhase filter_zero_phase(std::span<const Section> sections, const Signal& in) {
  ZeroPhase out{in, filter_memory(sections, 1e-3, in.size() + 1)};
  auto& x = out.signal.value;
  if (!std::all_of(x.begin(), x.end(), [](double v) { return std::isfinite(v); })) bridge_gaps(out.signal);
  if (x.size() < out.memory || x.empty()) throw FilterMemoryError(x.size(), out.memory);
  const SosProgram program(sections);
  const SosKernel& kernel = best_sos_kernel();
  auto state = program.steady(x.front());
  kernel.run_one(program.loop(), state.data(), x.data(), 1, x.size());
  state = program.steady(x.back());
  kernel.run_one(program.loop(), state.data(), x.data() + x.size() - 1, -1, x.size());
  const std::size_t edge = std::min(out.memory, x.size());
  for (std::size_t i = 0; i < edge; ++i) {
    out.signal.masked[i] |= mask_edge;
    out.signal.masked[x.size() - 1 - i] |= mask_edge;
  }
  return out;
}

}  // namespace powbench::dsp
