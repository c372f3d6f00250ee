#pragma once

#include <cstddef>
#include <cstdint>
#include <span>
#include <vector>

#include "dsp/filter/filter_design.h"
#include "dsp/filter/sos_kernel.h"

/// A designed filter made ready to run: fast on one channel (eight pieces of it side by side in the lanes of a
/// vector), on eight interleaved channels, and block by block on records of any length. Everything here throws
/// std::invalid_argument when a value was not finite: the samples are spoiled then.

namespace powbench::dsp {

/// Sections in the form of the inner loops. When the first section has a zero at z = 1 it is taken as a difference
/// of the input.
class SosProgram {
 public:
  explicit SosProgram(std::span<const Section>);
  SosLoop loop() const { return {coefficients_.data(), coefficients_.size(), difference_}; }
  /// State of one lane: at rest, or after an endless input of `level`.
  std::vector<double> rest() const { return std::vector<double>(1 + 2 * coefficients_.size()); }
  std::vector<double> steady(double level) const;

 private:
  std::vector<Section> sections_;  ///< after the difference
  std::vector<Coefficient> coefficients_;
  bool difference_ = false;
};

class Cascade {
 public:
  /// Measures the memory by running the impulse response. Throws std::invalid_argument without sections.
  explicit Cascade(std::vector<Section>, const SosKernel& = best_sos_kernel());
  explicit Cascade(const FilterSpec& spec) : Cascade(to_sections(spec)) {}

  const std::vector<Section>& sections() const { return sections_; }
  const SosKernel& kernel() const { return *kernel_; }

  /// Samples until the impulse response stays below 1e-6 of its peak.
  std::size_t memory() const { return memory_; }
  /// Samples after which nothing of an earlier state is left, to about 1e-17. A record of at least eight times
  /// this is filtered in eight pieces, each warmed up by so many samples before its own; a shorter one serially.
  std::size_t warm_up() const { return warm_up_; }

  /// One channel, in place, zero initial state. Pieces and serial differ by rounding (1e-13 of the peak).
  void forward(std::span<double>) const;
  /// Eight interleaved channels, in place, zero initial state. Throws std::invalid_argument when the size is no
  /// multiple of 8.
  void forward_frames(std::span<double>) const;

  /// Forward, then backward: zero phase, gain |H|^2. Each pass starts from the steady state of its first sample.
  /// Within memory() of either end the result depends on what was not recorded. Throws FilterMemoryError when
  /// the record is shorter than the memory.
  void zero_phase(std::span<double>) const;
  void zero_phase_frames(std::span<double>) const;

 private:
  friend class CascadeStream;
  friend class ZeroPhaseStream;
  void pass(double* first, std::ptrdiff_t step, std::size_t n, std::vector<double> state) const;
  void pass_pieces(double* first, std::ptrdiff_t step, std::size_t n, const std::vector<double>& state) const;
  void pass_frames(double* first, std::ptrdiff_t step, std::size_t frames, bool steady) const;

  std::vector<Section> sections_;
  SosProgram program_;
  const SosKernel* kernel_;
  std::size_t memory_ = 0, warm_up_ = 0;
};

/// Causal filtering of a stream: the state is carried from block to block, memory is O(1).
class CascadeStream {
 public:
  explicit CascadeStream(const Cascade& cascade);
  /// The next block, in place. The result does not depend on where blocks begin.
  void push(std::span<double>);
  std::int64_t position() const { return position_; }  ///< samples so far

 private:
  const Cascade* cascade_;
  std::vector<double> state_;
  std::int64_t position_ = 0;
};

/// Zero-phase filtering of a stream with memory for one block and the filter's warm-up: the backward pass of a
/// block starts warm_up() samples after its end. The cascade must outlive the stream.
class ZeroPhaseStream {
 public:
  /// `block` = 0: four times the warm-up, at least 65536 samples.
  explicit ZeroPhaseStream(const Cascade& cascade, std::size_t block = 0);
  /// Takes samples, appends those that are finished to `out`.
  void push(std::span<const double>, std::vector<double>& out);
  /// The rest of the record. Throws FilterMemoryError when all of it was shorter than the memory.
  void finish(std::vector<double>& out);

  std::int64_t position() const { return position_; }                               ///< samples taken
  std::int64_t finished() const { return finished_; }                               ///< samples given back
  std::size_t held_samples() const { return work_.capacity() + held_.capacity(); }  ///< memory in use

 private:
  void release(std::size_t samples, bool at_end, std::vector<double>& out);

  const Cascade* cascade_;
  std::size_t block_;
  std::vector<double> state_;  ///< of the forward pass
  std::vector<double> held_;   ///< after the forward pass, not yet given back
  std::vector<double> work_;
  std::int64_t position_ = 0, finished_ = 0;
};

}  // namespace powbench::dsp
