#pragma once

#include <array>
#include <cstddef>

#include "dsp/contacts/joint_columns.h"

/// The force of one contact of the joint fit and its derivatives.

namespace powbench::dsp {

struct PulseValue {
  double force = 0, touch = 0, release = 0, exponent = 0, log_skew = 0, unit = 0;
  std::array<double, joint_bends> bend{};
  void add(const PulseValue&, double share);
};

/// Force and its derivatives at t, s. Where an exponent below 1 has no finite slope the slope is held.
PulseValue pulse_value(const JointPulse&, double t);

/// Mean over the samples of row i; one sample stands for all where the force has no kink.
PulseValue pulse_row(const JointPulse&, const JointRows&, std::size_t i);

/// Standard deviation of bend j about 0: what lossy and denting pads change, and a vibration of their size does not.
double bend_sigma(std::size_t j);

/// Numbers of a contact that the fit may move.
std::size_t free_numbers(const JointPulse&);

}  // namespace powbench::dsp
