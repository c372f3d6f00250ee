#pragma once

#include <cstddef>
#include <memory>
#include <span>

#include "dsp/fft.h"

/// Circular filtering of a long real record by a real gain, for lengths beyond the caches: the transform is cut into
/// rows and columns that fit them (Bailey's four steps), and since a filter needs no ordered spectrum, nothing is
/// transposed. Only small transforms are planned, so planning takes a fraction of a second for any length.

namespace powbench::dsp {

class LargeSpectralGain {
 public:
  /// True from 2^17 on for lengths with enough factors of two: 2 N1 N2 with N1 a power of two >= 64 and N2 >= N1 a
  /// multiple of 16.
  static bool serves(std::size_t length);

  /// `gain` (length / 2 + 1) at the frequencies k / length.
  LargeSpectralGain(std::size_t length, std::span<const double> gain, FftEffort);
  ~LargeSpectralGain();
  LargeSpectralGain(LargeSpectralGain&&) noexcept;
  LargeSpectralGain& operator=(LargeSpectralGain&&) noexcept;

  std::span<double> time();  ///< (length), in and out
  void run();                ///< time = inverse transform of gain times transform of time

 private:
  struct Work;
  std::unique_ptr<Work> work_;
};

}  // namespace powbench::dsp
