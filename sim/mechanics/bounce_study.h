#pragma once

#include <cstdint>

#include "sim/mechanics/bounce_error.h"
#include "sim/specimen/specimen.h"

/// What may be claimed of the bounces of one closing: its error, its condition, and where neither means anything any
/// more, an ensemble.

namespace powbench::sim {

/// Yields the factor for the next mass or gap: always 1 for the closing itself.
using Factor = std::function<double()>;

/// Every mass (and inertia) and every gap times a factor of its own.
Specimen varied(Specimen, const Factor&);
RigidParts varied(RigidParts, const Factor&);

/// The closing at a tolerance, with masses and gaps varied: its events.
using BounceRun = std::function<std::vector<RigidEvent>(double tolerance, const Factor&)>;

struct BounceStudyOptions {
  double tolerance = 1e-8;  ///< that the closing is simulated with
  double truth = 1e-11;     ///< of what counts as true
  double end = 0.08;        ///< s
  double change = 1e-6;     ///< relative: twin and ensemble vary masses and gaps by +- this
  int runs = 64;            ///< of the ensemble, 64 and above
  std::uint64_t seed = 1;
  int contact = 0;  ///< whose first touch, open time and last closing the ensemble gives
};

struct BounceEnsemble {
  int runs = 0;  ///< 0: not needed
  Spread first_touch, open_time, last_closing;
};

struct BounceStudy {
  BounceError error;  ///< at `tolerance`, against `truth`
  BounceCondition
      condition;  ///< of a twin at `truth`, masses and gaps changed at random signs: every motion is excited
  bool computable = false;  ///< neither the tolerance nor the twin changes the sequence
  BounceEnsemble ensemble;  ///< where it is not
};

/// Throws std::invalid_argument for options outside their ranges.
BounceStudy study_bounces(const BounceRun&, const BounceStudyOptions&);

/// The twin alone, with how many events the undisturbed closing has.
struct TwinCondition {
  BounceCondition condition;
  int events = 0;
};
TwinCondition twin_condition(const BounceRun&, const BounceStudyOptions&);

BounceEnsemble bounce_ensemble(const BounceRun&, const BounceStudyOptions&);

}  // namespace powbench::sim
