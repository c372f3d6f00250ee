#pragma once

#include <limits>
#include <optional>
#include <span>
#include <vector>

#include "dsp/options.h"
#include "dsp/signal/signal.h"

/// Core vibration on a force channel as a sum of damped modes that start together.

namespace powbench::dsp {

struct Pole {
  double hertz = 0.0;
  double decay = 0.0;  ///< 1/s, > 0: exp(-decay t)
};

struct RingMode {
  Pole pole;
  double cosine = 0.0, sine = 0.0;  ///< N at `reference`
};

/// r(t) = sum exp(-decay (t - reference)) (cosine cos + sine sin)(2 pi hertz (t - reference)) for t >= onset,
/// else 0.
struct Ring {
  double onset = 0.0;      ///< s
  double reference = 0.0;  ///< s
  std::vector<RingMode> modes;
  bool ambiguous = false;  ///< a mode was found but its onset could not be placed

  bool empty() const { return modes.empty(); }
  double value(double t) const;
  double amplitude_at(double t) const;  ///< N: root of the sum of the modes' squared envelopes
  double longest_period() const;        ///< s: of the slowest mode; 0 without modes
  /// Adds factor * r(t) to every sample.
  void add_to(Signal&, double factor) const;
};

/// Poles of damped oscillations in uniformly sampled `x` (rotational invariance of the signal subspace, the
/// SVD matrix pencil in its covariance form). Strongest first, at most `max_modes`, `low` < hertz < `high`,
/// damping ratio below 0.12. `noise`: standard deviation of one sample.
std::vector<Pole> find_poles(std::span<const double> x, double dt, double noise, int max_modes, double low,
                             double high);

/// What the ring fit may use: `residual` = force minus modelled contacts.
struct RingInput {
  const Signal& residual;
  const std::vector<std::uint8_t>& usable;  ///< (n) 1 = nothing but ring, smooth settled force and noise
  double from = 0.0;                        ///< s, first sample used
  double closed_from = 0.0;                 ///< s, from here a smooth settled force is fitted beside the ring
  double to = 0.0;                          ///< s
  double noise = 0.0;                       ///< N, one sample
};

/// Amplitudes by linear least squares, poles by Gauss-Newton on top (variable projection). Modes that are not
/// significant (amplitude below 5 standard uncertainties) are left out. The onset is `from`. No modes where all of
/// them together leave more than `hopeless` (reduced sum of squares; twice that before the poles have moved).
Ring fit_ring(const RingInput&, std::vector<Pole> poles, const ExtractOptions&, double* reduced = nullptr,
              double hopeless = std::numeric_limits<double>::infinity());

/// Poles seen in `from` .. `to` after the smooth settled force is taken out.
std::vector<Pole> tail_poles(const RingInput&, const ExtractOptions&);

/// The undamped-to-damped oscillation that explains most of what `ring` and the smooth settled force leave: a
/// scan over frequency and damping. Nothing when the best one is not significant.
/// `gain`: sum of squares it takes out, N^2.
std::optional<Pole> strongest_pole(const RingInput&, const Ring& ring, const ExtractOptions&,
                                   double* gain = nullptr);

/// fit_ring, then modes added one by one by strongest_pole while they are significant. `reduced`: sum of squares left
/// over variance and degree of freedom. Where `start` is hopeless, nothing is added.
Ring grow_ring(const RingInput&, std::vector<Pole> start, const ExtractOptions&, double* reduced = nullptr,
               double hopeless = std::numeric_limits<double>::infinity());

/// The time in [t1, t2] from which on taking the ring out leaves less behind. With `usable` the signal is a
/// residual and compared as it is where usable; without, it is a force, and of both what is slower than `slow` (s,
/// standard deviation of a Gaussian) is taken out first.
double find_onset(const Signal&, const std::vector<std::uint8_t>* usable, const Ring&, double t1, double t2,
                  double slow = 150e-6);

}  // namespace powbench::dsp
