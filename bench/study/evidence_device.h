#pragma once

#include <cstdint>
#include <string>
#include <vector>

#include "bench/study/synthetic_device.h"

/// One synthetic device through all campaigns of the study `bench_bounce_evidence`.

namespace powbench::bench {

struct EvidenceOptions {
  Model model = Model::other;
  int samples = 8;       ///< of each posterior; `powbench fit` has 96
  std::size_t sets = 5;  ///< of channels, from the published ones on
  std::uint64_t seed = 1;
};

struct EvidenceRow {
  std::string channels, angles;
  std::vector<double> cells;  ///< shares, by column
};

struct DeviceResult {
  std::vector<EvidenceRow> rules, fits, seen;
  double spread = 0;  ///< rms of ln(bounce) about its mean over the angles
  double bounce = 0;  ///< s, its median
  long tried = 0;     ///< devices drawn until one was of its kind
  double cpu = 0;     ///< s
};

/// Rules without a model; process: `blended` without one, and the share of bounces in its band of 16 .. 84 %;
/// floor: median of the other shots at the very angle.
std::vector<std::string> rule_columns();
/// fit: the prediction of `powbench fit`, and the share of bounces in its band of 16 .. 84 %; samples: without
/// the plain median; blend: the process with the median sample, its band, its error less that of the process
/// alone, the posterior share of the model; touch: error of the touch.
std::vector<std::string> fit_columns();
/// A line of ln(bounce) on what was measured of the held-out closing itself.
std::vector<std::string> seen_columns();

/// Equal for any number of threads: all that is random depends on the seed and the number of the device. Without
/// samples: no fits.
DeviceResult study_device(const EvidenceOptions&, int number);

}  // namespace powbench::bench
