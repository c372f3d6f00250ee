#pragma once

#include <cstddef>
#include <span>
#include <vector>

#include "dsp/signal/fft.h"

/// Power spectra and coherence: averaged over pieces of one record (Welch 1967), or over closings.

namespace powbench::dsp {

/// One-sided density against frequency k rate / n.
struct Spectrum {
  double bin_hertz = 0;         ///< Hz between bins
  std::vector<double> density;  ///< (n / 2 + 1), unit^2 / Hz
  std::size_t averages = 0;

  double hertz(std::size_t bin) const { return bin_hertz * static_cast<double>(bin); }
  double power(double low,
               double high) const;  ///< unit^2, sum of the bins with low <= f < high times their width
};

/// |Sxy|^2 / (Sxx Syy), 0 .. 1; and Sxx, Syy.
struct Coherence {
  double bin_hertz = 0;
  std::vector<double> value;  ///< (n / 2 + 1); 0 where one of the spectra is empty
  Spectrum x, y;
  std::size_t averages = 0;  ///< independent for shot_coherence; halves overlap in coherence()
};

/// Pieces of `n` samples, overlapping by half, mean removed, Hann window.
class SpectrumEstimator {
 public:
  /// n >= 8. Throws std::invalid_argument otherwise, or for a rate that is not positive.
  SpectrumEstimator(std::size_t n, double rate, FftEffort = FftEffort::quick);

  std::size_t size() const { return fft_.size(); }
  /// Throws std::invalid_argument when the record is shorter than one piece or has a value that is not finite.
  Spectrum welch(std::span<const double>);
  Coherence coherence(std::span<const double> x, std::span<const double> y);

  /// Averaged over closings, one piece of each: `x[k]` and `y[k]` begin at the same instant relative to the core's
  /// impact and have n samples. With K closings the values of unrelated signals exceed
  /// coherence_threshold(K, p) with probability p. Throws std::invalid_argument for fewer than 3 closings or
  /// other sizes.
  Coherence shot_coherence(std::span<const std::span<const double>> x,
                           std::span<const std::span<const double>> y);

 private:
  void load(std::span<const double>);
  void add(std::span<const double> x, std::span<const double> y);
  void clear();
  Coherence result(std::size_t averages);

  RealFft fft_;
  double rate_;
  std::vector<double> window_;
  std::vector<std::complex<double>> first_;
  std::vector<double> xx_, yy_;
  std::vector<std::complex<double>> xy_;
};

/// 1 - p^(1 / (K - 1)): exceeded with probability p by the coherence of unrelated Gaussian signals from K
/// independent averages (Carter 1987). K >= 2.
double coherence_threshold(std::size_t averages, double probability);

}  // namespace powbench::dsp
