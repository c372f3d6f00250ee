#pragma once

#include <array>
#include <vector>

#include "bench/dsp_synth.h"
#include "core/events.h"

/// Found events against the truth, and how true their stated uncertainties are.

namespace powbench::bench {

/// QuantityErrors of one quantity. Shares and moments are NaN where there is nothing.
struct QuantityErrors {
  std::vector<double> error, z;  ///< found - true; the same over u
  double rms() const;
  double median() const;  ///< of |error|
  double bias() const;    ///< median of the errors: a few that match the wrong edge do not move it
  double spread() const;  ///< rms of z
  double beyond() const;  ///< share of |z| > 3
  void add(const Measured& found, double truth);
  void add(const QuantityErrors&);
};

struct Tally {
  int records = 0, exact = 0, matched = 0, missed = 0, invented = 0;
  int flagged = 0, contacts = 0;  ///< contacts found, and those that carry a flag
  /// Contacts listed with a probability below 0.9: how many, the sum of their probabilities, how many are real.
  struct Doubted {
    int listed = 0, real = 0;
    double expected = 0;
  } doubted;
  QuantityErrors touch, release, peak, settled;
  /// Openings between two contacts by how long they truly are, ms: up to each of these.
  static constexpr std::array<double, 5> longest_opening{0.1, 0.2, 0.3, 0.5, 1e9};
  std::array<QuantityErrors, longest_opening.size()> beside_opening;  ///< the release before, the touch after
  double recall() const;
  double precision() const;
  double exact_share() const;
  /// One-to-one on touch within 300 us.
  void add(const std::vector<TrueContact>& truth, const ContactTrain& found);
  void add(const Tally&);
};

}  // namespace powbench::bench
