#pragma once

#include <array>
#include <optional>
#include <vector>

#include "core/events.h"
#include "dsp/contacts/contact_fit.h"
#include "dsp/options.h"
#include "dsp/signal/signal.h"
#include "dsp/vibration/ring.h"

/// Contacts, settled rise and core vibration in one least-squares fit: what each of them takes is taken once.

namespace powbench::dsp {

inline constexpr std::size_t joint_bends = 6;

/// One closed interval in the joint fit: F = shape(t) (1 + sum bend[j] cos((j + 1) pi v)), v = 0 .. 1 from touch to
/// release. The bends are what a lossy pad changes in the shape, each with a prior about 0.
struct JointPulse {
  PulseShape shape;
  bool skewed = false;  ///< the skew is free
  bool bent = false;    ///< the bends are free
  std::array<double, joint_bends> bend{};
  bool modelled = true;  ///< false: no pulse describes it; its samples are left out
  double reduced_chi2 = 0.0;
  double u_touch = 0, u_release = 0, u_peak = 0;  ///< standard uncertainties, the ring's share included
  double u_exponent = 0;
};

/// The contact that stays closed: polynomial in time times 1 - exp(-(t - touch) / rise).
struct JointRise {
  double touch = 0.0, rise = 2e-4;  ///< s
  bool modelled = true;             ///< false: its first 0.5 ms are left out, a free smooth force follows
  std::vector<double> linear;       ///< N
  double reduced_chi2 = 0.0;        ///< of its first 0.5 ms
  double u_touch = 0.0;
};

struct JointModel {
  std::vector<JointPulse> pulses;  ///< in order of touch
  std::optional<JointRise> rise;
  Ring ring;
  std::array<double, 3>
      pedestal{};  ///< N: constant, slope, bend of the core's static force from the onset to the last touch
  double pedestal_span = 0.0;    ///< s: from the onset to its end
  double chi2 = 0.0, dof = 0.0;  ///< against the noise alone
  double left_out = 0.0;         ///< rows of contacts that no model describes
  double settling_out = 0.0;     ///< of these, after the last touch
  double parameters = 0.0;
  double reduced() const { return dof > 0 ? chi2 / dof : 1e300; }
  /// What two explanations of one record are compared by (Schwarz): excess of the sum of squares over its
  /// expectation, plus ln(rows) a parameter; a row left unexplained counts like one that is 2 standard deviations
  /// off. Smaller is better.
  double cost() const;
  /// The same but for what is left out after the last touch: between models that leave out more or less of it.
  double cost_before_settling() const;
};

inline constexpr double left_out_cost = 4;  ///< of a row, in JointModel::cost
inline constexpr double joint_tail = 5e-3;  ///< s of closed time after the last touch that is used
inline constexpr double joint_rest =
    3e-3;  ///< s after the last touch: from then on a contact shows nothing of its own that is fast

struct JointInput {
  const Signal& force;
  double noise = 0.0;                       ///< N, one sample
  double t_end = 0.0;                       ///< s, end of the closing
  double onset_from = 0.0, onset_to = 0.0;  ///< s: where the ring may start; equal = it stays where it is
  const ExtractOptions& options;
  double from = -1e300;  ///< s: nothing before is used
  double row = 5e-6;     ///< s: samples are averaged up to here
  bool pedestal =
      false;  ///< a static share of the core's force from the onset to the last touch is fitted too
  bool ring_fixed = false;                  ///< the ring is taken out as it is
  double blind_from = 0.0, blind_to = 0.0;  ///< s: samples left out while the core is still landing
  bool keep_all = false;  ///< pulses that do not fit stay in (what does not fit may be ring)
  double enough = 0.01;   ///< gain of an iteration in the sum of squares: a tenth of a standard uncertainty
  bool judged = false;    ///< the contacts of the start were judged by a fit like this one
  /// N, > 0: contacts of a larger peak are left out, so that the ring is what open time shows.
  double open_below = 0.0;
  bool bend = false;    ///< contacts that the pulses do not fit may be bent
  bool settles = true;  ///< false: the settled contact still moves and is left out
  double rest = 0.0;    ///< s of closed time used behind what is left out of it: smooth force and ring
  /// s of closed time left out where the rise is not modelled
  double settling() const { return settles ? 1e-3 : rest > 0 ? joint_rest : joint_tail; }
  bool times_only = false;  ///< nobody asks for the standard uncertainties: they stay 0
};

inline constexpr double joint_margin_before =
    0.3e-3;  ///< s of open time before the first event that a fit uses

/// Levenberg-Marquardt over all parameters of `start` on samples averaged to rows. In each iteration the onset of the
/// ring moves to where the sum of squares is least, once the parameters of the contact it lies in are projected out
/// (their linear span at the present solution): a scan over every sample for the price of one sum. Pulses that do not
/// fit get a free skew, then are left out.
JointModel fit_joint(const JointInput&, JointModel start, int iterations);

/// Takes ring and pedestal of the model out of a signal; beyond the last touch the pedestal stays for 0.1 ms and
/// fades in 0.2.
void take_out(const JointModel&, Signal&);

/// What `model` leaves of the samples it uses, on the rows of the fit. `usable`: 1 where the model claims to be
/// complete.
struct JointResidual {
  Signal signal;
  std::vector<std::uint8_t> usable;
  double noise = 0.0;  ///< N, one row
};
JointResidual joint_residual(const JointInput&, const JointModel&);

}  // namespace powbench::dsp
