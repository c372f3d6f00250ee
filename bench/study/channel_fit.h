#pragma once

#include <array>
#include <cstdint>
#include <limits>
#include <span>
#include <vector>

#include "bench/study/synthetic_device.h"
#include "sim/study/misfit.h"
#include "sim/study/parameter.h"
#include "sim/team.h"

/// The posterior of `powbench fit` (sim/study/posterior.h) with more channels than touch and seat, and a cheaper
/// search.

namespace powbench::bench {

/// What the least squares see beside touch and seat.
struct Channels {
  const char* name = "";
  bool overtravel = false;  ///< gauged once, 2 %
  bool force = false;       ///< peak of the first touch
  bool speeds = false;      ///< at touch and seat
};

struct Campaign {
  std::vector<Shot> shots;
  double overtravel = 0;  ///< m, as gauged
};

/// Sum of squares of the smooth quantities, of the ranges of the kind and of the prior. Deviations: 3 % of touch
/// and seat, as `powbench fit` has; 5 % of speeds, 10 % of the force, 2 % of the overtravel.
class ChannelMisfit {
 public:
  ChannelMisfit(const Campaign&, const Channels&);

  std::size_t dimension() const { return kind_.dimension(); }
  sim::Specimen specimen(std::span<const double> point) const { return kind_.specimen(point); }
  std::vector<double> residuals(std::span<const double> point) const;
  double value(std::span<const double> point, double give_up) const;

  /// Data and prior moved at random by their deviations.
  ChannelMisfit shifted(Random&) const;

 private:
  static constexpr std::size_t quantities = 5;  ///< touch, seat, speed at touch, at seat, force
  struct Row {
    double angle = 0;
    std::array<Measured, quantities> of;
  };
  double rows(const sim::Specimen&, double sum, double give_up, std::vector<double>* out) const;

  std::vector<Row> rows_;
  Measured overtravel_;
  bool force_ = false;
  double duration_ = 0;
  sim::Misfit kind_;
};

/// A point to start from: coarse search of touch and seat, then least squares.
std::vector<double> start_point(const Campaign&, std::uint64_t seed, sim::Team&);

/// Posterior samples: least squares from `start`, then each from the best point with data and prior shifted.
std::vector<std::vector<double>> channel_samples(const ChannelMisfit&, std::vector<double> start, int samples,
                                                 std::uint64_t seed, sim::Team&);

}  // namespace powbench::bench
