#pragma once

#include <functional>
#include <string>
#include <vector>

/// Rules that predict a bounce from measured bounces at other angles, without a model. All work on ln(bounce): a
/// median stays what it is, and errors are relative. Angles in rad, of period pi: 0 and 180 deg differ by
/// polarity alone.

namespace powbench::bench {

struct Known {
  double angle = 0;
  double log_bounce = 0;
  std::vector<double> features;  ///< of the same closing; may be empty
};

/// Predicts ln(bounce) at an angle with features from what is known.
using Rule =
    std::function<double(const std::vector<Known>&, double angle, const std::vector<double>& features)>;

double median_rule(const std::vector<Known>&, double angle, const std::vector<double>&);
double nearest_rule(const std::vector<Known>&, double angle, const std::vector<double>&);
double interpolation_rule(const std::vector<Known>&, double angle, const std::vector<double>&);

/// 1, cos 2 theta, sin 2 theta and, from 10 angles on, cos and sin 4 theta; least squares.
double harmonic_rule(const std::vector<Known>&, double angle, const std::vector<double>&);

/// Linear in the features, standardised over what is known, with the least-squares penalty of one more closing
/// of one deviation (ridge of 1): a single feature is an ordinary line but for that.
double feature_rule(const std::vector<Known>&, double angle, const std::vector<double>& features);

/// ln(bounce) as a mean, a share of what a model says of it, and a process over the angle whose correlation
/// falls with the distance, C = exp(-2 |sin(a - b)| / length), with a scatter of its own.
struct Blend {
  double log_bounce = 0, deviation = 0;
  double share = 0;  ///< of the model, mean over its posterior
};

/// Averaged by posterior weight over lengths, scatters and, where `model` says ln(bounce) at every known angle
/// and `model_at` at the new one, the shares 0, 1/2 and 1. Without a model: the data alone. Mean and scale are
/// integrated out.
Blend blended(const std::vector<Known>&, const std::vector<double>& model, double angle, double model_at);

}  // namespace powbench::bench
