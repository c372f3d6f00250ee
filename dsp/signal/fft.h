#pragma once

#include <complex>
#include <cstddef>
#include <memory>
#include <span>

/// Real Fourier transforms by FFTW. Planning is serialised by one mutex, since only execution is thread safe
/// there; what planning learned stays in the process.

namespace powbench::dsp {

enum class FftEffort { quick, thorough };

/// Transforms of one length between two own buffers. Movable, not shared between threads.
class RealFft {
 public:
  /// n >= 1. `thorough` times the candidate algorithms once a process and length: about 0.2 s for 16384 samples,
  /// many seconds for a million, and then two to three times faster than `quick`. Throws std::invalid_argument
  /// for n = 0.
  explicit RealFft(std::size_t n, FftEffort = FftEffort::quick);
  ~RealFft();
  RealFft(RealFft&&) noexcept;
  RealFft& operator=(RealFft&&) noexcept;

  std::size_t size() const { return n_; }
  std::span<double> time();                    ///< (n)
  std::span<std::complex<double>> spectrum();  ///< (n / 2 + 1)

  void forward();  ///< spectrum[k] = sum time[i] exp(-2 pi i k / n); keeps `time`
  void inverse();  ///< time[i] = sum over all k, without 1 / n; destroys `spectrum`

 private:
  struct Plans;
  std::size_t n_ = 0;
  std::unique_ptr<Plans> plans_;
};

/// Smallest 2^a 3^b 5^c >= n that is even: a prime length is 30 times slower. n <= 2^40.
std::size_t good_length(std::size_t n);

}  // namespace powbench::dsp
