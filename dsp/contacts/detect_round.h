#pragma once

#include <vector>

#include "dsp/contacts/contact_fit.h"
#include "dsp/contacts/detect.h"
#include "dsp/options.h"
#include "dsp/signal/signal.h"

namespace powbench::dsp {

/// Contacts of one film as far as levels alone show them, and their fits once they are made.
struct Round {
  DetectionLevels levels;
  std::vector<Interval> intervals;
  std::vector<double> smooth;  ///< N: the force the levels were crossed by
  double t0 = 0, dt = 0;       ///< s: its time axis
  std::vector<ContactFit> fits;
  double noise = 0;      ///< N, one sample, ring residue included
  bool overlap = false;  ///< vibration was left in and the levels raised above it

  double smooth_peak(double t1, double t2) const;  ///< N: largest smoothed force in [t1, t2], at least 0
};

/// Contacts above white noise; where the open time rings at a frequency that a wider Gaussian removes and a narrow one
/// does not, the wider one is taken (and the resolution reported with it). In the `final_round` the levels rise above
/// whatever vibration is left, and `overlap` says so.
Round detect_round(const Signal& force, double noise, double settled, double t_end, const ExtractOptions&,
                   bool final_round);

/// The same with the wider Gaussian whatever the open time shows: for a ring that dies before it can be measured there.
Round detect_wide(const Signal& force, double noise, double settled, double t_end, const ExtractOptions&);

}  // namespace powbench::dsp
