#pragma once

#include <cstddef>
#include <memory>

#include "dsp/signal/fft.h"

/// Equal complex transforms in place inside one buffer: the parts of large_fft.

namespace powbench::dsp {

class FftBatch {
 public:
  /// `count` transforms of n values, `stride` apart, each `distance` from the one before, in a buffer of `size`
  /// complex values (interleaved real and imaginary parts).
  FftBatch(std::size_t n, std::size_t count, std::size_t stride, std::size_t distance, std::size_t size,
           FftEffort);
  ~FftBatch();
  FftBatch(const FftBatch&) = delete;
  FftBatch& operator=(const FftBatch&) = delete;

  double* data();
  void run(std::size_t offset, bool forward);  ///< at complex value `offset`, a multiple of 4; not scaled

 private:
  struct Plans;
  std::unique_ptr<Plans> plans_;
};

}  // namespace powbench::dsp
