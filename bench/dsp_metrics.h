#pragma once

#include <vector>

#include "bench/dsp_synth.h"
#include "core/events.h"

/// How well found contacts agree with the truth.

namespace powbench::bench {

/// One-to-one matching on touch within 300 us. Times in seconds. NaN where nothing was matched.
struct Score {
  int records = 0;
  double recall = 0, precision = 0;
  double exact = 0;  ///< share of records with exactly the true sequence
  double touch_rmse = 0, touch_bias = 0, touch_median = 0;  ///< median of |error|
  double release_rmse = 0, release_bias = 0;
  double duration_bias = 0;  ///< contact duration
  double peak_bias = 0;      ///< relative
  double z_std = 0;          ///< standard deviation of (touch and release error) / stated uncertainty
  double bound_ratio = 0;    ///< rms of (touch error / Cramer-Rao bound) over the bounces
  double cpu_ms = 0;         ///< per record; filled by the caller
};

/// Cramer-Rao bound on the touch of a bounce, s: touch, release, peak and exponent unknown, white noise of `noise` N
/// a sample, no ringing. NaN for a contact that stays closed.
double touch_bound(const TrueContact&, PulseForm, double noise, double rate);

class Scorer {
 public:
  void add(const std::vector<TrueContact>& truth, const std::vector<Contact>& found,
           const std::vector<double>& bounds = {});
  Score score() const;

 private:
  int records_ = 0, exact_ = 0, matched_ = 0, missed_ = 0, invented_ = 0;
  std::vector<double> touch_, release_, duration_, peak_, z_, bound_;
};

}  // namespace powbench::bench
