#pragma once

#include <array>
#include <cstdint>
#include <span>
#include <vector>

#include "core/channels.h"
#include "core/random.h"
#include "core/record.h"
#include "rigs/sim_rig_config.h"
#include "sim/models/plant.h"

/// The virtual sensor chain. It turns what the plant does into what the converters give; the simulated rig
/// and the simulator both record through it, so that a sensor's artefact stands on both sides of a
/// comparison.

namespace powbench::rigs {

/// Plant samples per converter sample: the chain runs this much faster than the converters, so that a contact
/// pulse of 0.1 ms and the amplifier's low-pass are resolved.
inline constexpr int oversampling = 2;

/// What a client needs to turn counts into SI: (raw + offset) * scale, less the delay.
struct ChannelScale {
  double si_per_count = 1.0;
  double delay = 0.0;         ///< s
  double corner_hertz = 0.0;  ///< 0 = coupled down to DC
};

/// Scale of each channel, as a calibration certificate would state it. `sample_rate` in Hz.
std::array<ChannelScale, channel_count> channel_scales(const SensorConfig&, double sample_rate);

/// Two-pole Butterworth low-pass by the bilinear transform, y = b0 (x + 2 x1 + x2) - a1 y1 - a2 y2. Unit gain
/// at DC.
class LowPass {
 public:
  LowPass(double hertz, double rate);
  double step(double x);

 private:
  double b0_, a1_, a2_, s1_ = 0.0, s2_ = 0.0;
};

/// One-pole high-pass by the bilinear transform: the charge amplifier's low corner.
/// y[n] = (x[n] - x[n-1] + (1 - w) y[n-1]) / (1 + w), w = tan(pi f / rate).
class HighPass {
 public:
  HighPass(double hertz, double rate);
  double step(double x);

 private:
  double gain_, feedback_, x1_ = 0.0, y1_ = 0.0;
};

/// Structural mode q'' + 2 zeta w q' + w^2 q = w^2 F, propagated exactly for F constant over a step.
class Resonator {
 public:
  Resonator(double hertz, double damping, double rate);
  void step(double force);
  double value() const { return q_; }              ///< N: static-equivalent force
  double acceleration() const { return second_; }  ///< N/s2, second derivative of value()

 private:
  double m_[2][2], n_[2], w2_, c_;
  double q_ = 0.0, v_ = 0.0, second_ = 0.0;
};

class SensorChain {
 public:
  SensorChain(const SensorConfig&, double sample_rate, double mains_hertz, std::uint64_t seed);

  /// `plant`: the `oversampling` samples that end at the converter instant; `scan`: channel_count values.
  void convert(std::span<const sim::PlantSample> plant, std::span<std::int16_t> scan);

  /// Values converted so far: what the wanted channels cost.
  std::int64_t conversions() const { return conversions_; }

  /// How the inputs differ from their scales.
  void set_front_end(const FrontEndConfig&);
  /// The input shows this quantity (SI) in place of the plant's until it is taken away (channel_count).
  void set_reference(std::size_t channel, double value) {
    reference_channel_ = channel;
    reference_ = value;
  }
  /// The laser holds its last value while set.
  void drop_laser(bool dropped) { laser_dropped_ = dropped; }

 private:
  std::int16_t quantise(Channel, double value, double noise);
  double laser(const sim::PlantSample&);
  void force_step(const sim::PlantSample&);
  bool wants(Channel c) const { return contains(config_.channels, c); }

  SensorConfig config_;
  double mains_hertz_;
  Random random_;
  std::array<double, channel_count> counts_per_si_{}, zero_counts_{};
  std::size_t reference_channel_ = channel_count;
  double reference_ = 0.0;
  LowPass low_a_, low_b_;
  HighPass high_a_, high_b_;
  std::vector<Resonator> modes_;
  double force_a_ = 0.0, force_b_ = 0.0;
  std::vector<double> travel_;  ///< history for the laser's transport delay, one entry a plant sample
  std::size_t travel_next_ = 0;
  double plant_dt_;
  double next_laser_ = 0.0, laser_value_ = 0.0;
  bool laser_started_ = false, laser_dropped_ = false;
  std::int64_t conversions_ = 0;
};

}  // namespace powbench::rigs
