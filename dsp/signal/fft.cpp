#include "dsp/signal/fft.h"

#include <fftw3.h>

#include <algorithm>
#include <cstdlib>
#include <limits>
#include <mutex>
#include <new>
#include <stdexcept>

#include "dsp/signal/fft_batch.h"

namespace powbench::dsp {

namespace {

std::mutex& planning() {
  static std::mutex m;
  return m;
}

}  // namespace

struct RealFft::Plans {
  double* time = nullptr;
  fftw_complex* spectrum = nullptr;
  fftw_plan forward = nullptr, inverse = nullptr;

  Plans(std::size_t n, FftEffort effort) {
    time = fftw_alloc_real(n);
    spectrum = fftw_alloc_complex(n / 2 + 1);
    if (!time || !spectrum) {
      release();
      throw std::bad_alloc();
    }
    const unsigned flags = effort == FftEffort::thorough ? FFTW_MEASURE : FFTW_ESTIMATE;
    {
      const std::scoped_lock lock(planning());
      forward = fftw_plan_dft_r2c_1d(static_cast<int>(n), time, spectrum, flags | FFTW_PRESERVE_INPUT);
      inverse = fftw_plan_dft_c2r_1d(static_cast<int>(n), spectrum, time, flags | FFTW_DESTROY_INPUT);
    }
    if (!forward || !inverse) {
      release();
      throw std::runtime_error("no FFT plan for " + std::to_string(n) + " samples");
    }
    std::fill_n(time, n, 0.0);
  }
  ~Plans() { release(); }
  Plans(const Plans&) = delete;
  Plans& operator=(const Plans&) = delete;

  void release() {
    const std::scoped_lock lock(planning());
    if (forward) fftw_destroy_plan(forward);
    if (inverse) fftw_destroy_plan(inverse);
    fftw_free(time);
    fftw_free(spectrum);
  }
};

RealFft::RealFft(std::size_t n, FftEffort effort) : n_(n) {
  if (n == 0 || n > static_cast<std::size_t>(std::numeric_limits<int>::max()))
    throw std::invalid_argument("n = " + std::to_string(n) + ": allowed 1 .. 2147483647 samples");
  plans_ = std::make_unique<Plans>(n, effort);
}
RealFft::~RealFft() = default;
RealFft::RealFft(RealFft&&) noexcept = default;
RealFft& RealFft::operator=(RealFft&&) noexcept = default;

std::span<double> RealFft::time() {
  return {plans_->time, n_};
}
std::span<std::complex<double>> RealFft::spectrum() {
  // std::complex<double> has the layout of double[2] by the standard
  return {reinterpret_cast<std::complex<double>*>(plans_->spectrum), n_ / 2 + 1};
}
void RealFft::forward() {
  fftw_execute(plans_->forward);
}
void RealFft::inverse() {
  fftw_execute(plans_->inverse);
}

struct FftBatch::Plans {
  fftw_complex* data = nullptr;
  fftw_plan forward = nullptr, inverse = nullptr;

  ~Plans() {
    const std::scoped_lock lock(planning());
    if (forward) fftw_destroy_plan(forward);
    if (inverse) fftw_destroy_plan(inverse);
    fftw_free(data);
  }
};

FftBatch::FftBatch(std::size_t n, std::size_t count, std::size_t stride, std::size_t distance,
                   std::size_t size, FftEffort effort)
    : plans_(std::make_unique<Plans>()) {
  plans_->data = fftw_alloc_complex(size);
  if (!plans_->data) throw std::bad_alloc();
  const unsigned flags = effort == FftEffort::thorough ? FFTW_MEASURE : FFTW_ESTIMATE;
  const int length = static_cast<int>(n), s = static_cast<int>(stride), d = static_cast<int>(distance);
  const auto plan = [&](int sign) {
    return fftw_plan_many_dft(1, &length, static_cast<int>(count), plans_->data, nullptr, s, d, plans_->data,
                              nullptr, s, d, sign, flags);
  };
  {
    const std::scoped_lock lock(planning());
    plans_->forward = plan(FFTW_FORWARD);
    plans_->inverse = plan(FFTW_BACKWARD);
  }
  if (!plans_->forward || !plans_->inverse) throw std::runtime_error("no FFT plan for " + std::to_string(n));
  std::fill_n(&plans_->data[0][0], 2 * size, 0.0);
}
FftBatch::~FftBatch() = default;

double* FftBatch::data() {
  return &plans_->data[0][0];
}
void FftBatch::run(std::size_t offset, bool forward) {
  fftw_complex* at = plans_->data + offset;
  fftw_execute_dft(forward ? plans_->forward : plans_->inverse, at, at);
}

std::size_t good_length(std::size_t n) {
  std::size_t best = std::numeric_limits<std::size_t>::max();
  for (std::size_t five = 1; five < 10 * n + 10; five *= 5)
    for (std::size_t three = five; three < 10 * n + 10; three *= 3) {
      std::size_t length = 2 * three;
      while (length < n) length *= 2;
      best = std::min(best, length);
    }
  return best;
}

}  // namespace powbench::dsp
