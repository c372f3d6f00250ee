#pragma once

#include <cstddef>
#include <cstdint>
#include <memory>
#include <span>

/// Circular convolution of two real blocks at once with the same real taps, for processors with 512-bit vectors.
///
/// z = a + i b has the spectrum product Z H, and because the taps are real its inverse is (a * h) + i (b * h): one complex
/// transform serves two real blocks, nothing has to be taken apart. The order of the bins does not matter to a product, so
/// the transform stops in the order it arrives at (decimation in frequency) and the inverse starts from it. Radix 8
/// and 4 down to pieces of 64 points, which stay in registers through their last six levels, the product with H
/// and the first six levels of the inverse. The first level reads the blocks where they are, the last one writes there.

namespace powbench::dsp {

class PairConvolver {
 public:
  /// Whether this processor has the vectors.
  static bool available();

  /// `length` a power of two, 256 .. 2^22; no more taps than that.
  PairConvolver(std::size_t length, std::span<const double> taps);
  ~PairConvolver();
  PairConvolver(PairConvolver&&) noexcept;
  PairConvolver& operator=(PairConvolver&&) noexcept;

  std::size_t length() const { return length_; }

  /// out_x[j - skip] = sum_k h[k] x[(j - k) mod length] for j = skip .. length - 1, for x = a and x = b, `length` values each.
  /// The outputs must not overlap the inputs. Rounding of the larger block reaches the other one.
  void run(const double* a, const double* b, double* out_a, double* out_b, std::size_t skip);

 private:
  struct Tables;
  std::size_t length_ = 0;
  std::unique_ptr<Tables> tables_;
};

}  // namespace powbench::dsp
