#pragma once

#include <functional>
#include <span>
#include <vector>

#include "core/events.h"
#include "dsp/contacts/detect.h"
#include "dsp/options.h"
#include "dsp/signal/signal.h"

/// Touch and release by a fit of the force's own shape, with standard uncertainties from the fit.

namespace powbench::dsp {

/// F(t) = peak sin(pi v^skew)^exponent on [touch, release], v = (t - touch) / (release - touch); 0 outside.
/// exponent 1, skew 1 = half sine; exponent 1.5 = Hertz contact; skew < 1 leans forward.
struct PulseShape {
  double touch = 0, release = 0, peak = 0, exponent = 1, skew = 1;
  double operator()(double t) const;
};

/// d F / d parameter at t, 0 outside. Next to the ends, where an exponent below 1 has no finite slope, the slope is
/// held.
struct PulseGradient {
  double touch = 0, release = 0, peak = 0, exponent = 0, log_skew = 0;
};
PulseGradient pulse_gradient(const PulseShape&, double t);

/// Weak knowledge of the exponent (half sine to Hertz), so that a pulse of ten samples stays determined: mean and
/// standard deviation.
inline constexpr double exponent_prior = 1.25, exponent_prior_sigma = 0.5;

/// What surrounds a contact: its fit must not look beyond.
struct Neighbours {
  double previous_release = -1e300;  ///< s
  double next_touch = 1e300;         ///< s
};

/// Force as the fits see it: contact force with its noise, and the smoothed copy used for landmarks.
struct FitInput {
  const Signal& force;
  std::span<const double> smooth;  ///< N, same length
  double noise = 0.0;              ///< N, one sample, ring residue included
  const DetectionLevels& levels;
  const ExtractOptions& options;
  bool quick = false;  ///< only what the ring fit needs: no skew, no single edges, few iterations
};

struct ContactFit {
  Contact contact;
  std::function<double(double)> shape;  ///< N at t; empty when no model describes the whole contact
  double reduced_chi2 = 0.0;            ///< of the touch's fit
};

/// Half sine with free exponent; with free skew where that is worth its parameter (BIC). Where neither
/// describes the contact, touch and release are fitted one by one (`fit_edge`).
ContactFit fit_contact(const FitInput&, const Interval&, const Neighbours&);

/// Contact from a pulse that some other fit found, with the impulse, the flags of its samples and the part of the
/// uncertainty that sampling adds; `grow`: factor on the fit's own uncertainties.
Contact contact_from(const PulseShape&, const Measured& touch, const Measured& release, const Measured& peak,
                     const Signal& force, double noise, double grow);

/// Standard uncertainty that sampling at `dt` adds to an edge of duration `rise`, s.
double shape_uncertainty(double dt, double rise);

/// Bits of lost or clipped samples in [t1, t2] as flags.
std::uint32_t flags_of_mask(const Signal&, double t1, double t2);

struct EdgeFit {
  Measured kink;      ///< s: where the force leaves (side +1) or reaches (side -1) zero
  double peak = 0.0;  ///< N, of the fitted edge
  double reduced_chi2 = 0.0;
  bool poor = false;  ///< reduced chi-square outside its confidence band
  std::function<double(double)> shape;
};

/// One edge from open to closed (side = +1) or from closed to open (side = -1) near `kink`: the better of
/// a sin(pi/2 v)^p up to the first maximum and a (1 - exp(-v)) + b v, both zero before the kink.
/// `open_span`, `closed_span`: s, how far the fit may look.
EdgeFit fit_edge(const FitInput&, double kink, int side, double open_span, double closed_span);

}  // namespace powbench::dsp
