#pragma once

#include <cstddef>
#include <cstdint>
#include <optional>
#include <span>
#include <vector>

#include "dsp/fft.h"
#include "dsp/filter_design.h"
#include "dsp/large_fft.h"
#include "dsp/pair_convolver.h"
#include "dsp/signal.h"

/// Linear-phase FIR filters by overlap-save, and filters that multiply the spectrum of a whole record. Both have
/// zero phase here: the delay of the FIR is taken out.

namespace powbench::dsp {

/// Windowed sinc with a Hamming window (-53 dB, transition about 3.3 rate / taps), scaled to exactly one at 0,
/// rate / 2 or the middle of the band. -6 dB at the edges. Edges as in FilterSpec. Throws FilterDesignError for
/// an even number of taps or fewer than 3, and for bad edges.
std::vector<double> design_fir(FilterKind, double low_hertz, double high_hertz, double rate,
                               std::size_t taps);

/// y[n] = sum h[k] x[n + (M - 1) / 2 - k], with zeros outside the record: a block of spectra at a time, or two of them in one
/// complex transform (pair_convolver.h). Both ways differ by rounding: below 1e-15 of the largest sample in the blocks.
class OverlapSave {
 public:
  /// An odd number M of taps. Throws std::invalid_argument otherwise, or when one is not finite.
  explicit OverlapSave(std::vector<double> taps, FftEffort = FftEffort::quick);

  std::size_t taps() const { return taps_.size(); }
  std::size_t edge() const { return (taps_.size() - 1) / 2; }  ///< samples at either end that saw the outside
  std::size_t block() const { return length_; }

  /// Any lengths, also below M; `out` as long as `in` and not the same memory.
  void run(std::span<const double> in, std::span<double> out);

 private:
  void run_pairs(std::span<const double> in, std::span<double> out);
  void run_one(std::span<const double> in, std::span<double> out);

  std::vector<double> taps_;
  std::size_t length_;                          ///< of a block
  std::optional<PairConvolver> pair_;           ///< where the processor has its vectors, else
  std::optional<RealFft> fft_;                  ///< with
  std::vector<std::complex<double>> response_;  ///< of the taps, with 1 / block
  std::vector<double> edge_;  ///< pairs only: two blocks at the ends of a record, and their results
};

/// OverlapSave on a signal: `mask_edge` on the invalid edges; FilterMemoryError when the record has no more
/// samples than there are taps.
Signal filter_linear_phase(OverlapSave&, const Signal&);

/// Multiplies the spectrum of records of one length by a real gain.
class SpectralFilter {
 public:
  /// `gain` (good_length(samples + padding) / 2 + 1) at the frequencies k rate / length. The padding bridges the
  /// end and the beginning of the record by a straight line and takes up what would wrap around.
  SpectralFilter(std::size_t samples, std::size_t padding, std::span<const double> gain,
                 FftEffort = FftEffort::quick);

  std::size_t length() const { return length_; }
  /// In place, `samples` long. Throws std::invalid_argument for another size.
  void run(std::span<double>);

 private:
  std::size_t samples_, length_;
  std::vector<double> gain_;
  std::optional<RealFft> fft_;              ///< up to 2^17 samples, or
  std::optional<LargeSpectralGain> large_;  ///< beyond
};

/// |H|^2 of a cascade at the frequencies k rate / length: what forward-backward filtering does.
std::vector<double> two_pass_gain(std::span<const Section>, std::size_t length);

}  // namespace powbench::dsp
