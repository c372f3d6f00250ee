#pragma once

#include <optional>
#include <span>
#include <string>
#include <vector>

#include "sim/mechanics/bounce_study.h"
#include "sim/study/ladder.h"

/// How far the bounces of simulated closings can be believed, for people and for programs.

namespace powbench::host {

/// What break A of the measured pole does in a closing, s.
struct BounceTimes {
  double touch = 0, open = 0, last = 0;  ///< first touch, time open after it, last closing
  int bounces = 0;
};

struct BounceRow {
  std::string name;  ///< of the closing
  sim::BounceStudy study;
  std::optional<BounceTimes> times = {};  ///< where the table of them is not printed elsewhere
  std::vector<sim::StageTime> stages = {};
};

/// One case on one rung that takes tolerances, with its times.
BounceRow bounce_row(const sim::Rung&, const std::string& name, const sim::Case&,
                     const sim::BounceStudyOptions&);

/// The bounces of one case on every rung that takes tolerances and no seconds: a table of its times says little without
/// them.
std::vector<BounceRow> bounces_of(std::span<const sim::Rung>, const sim::Case&,
                                  const sim::BounceStudyOptions&);

/// One line a closing: events that agree with the truth's, largest time difference among them, for how long contact
/// states differ, and the condition; below a line that is not computable its ensemble. Above them the times and
/// stages of the closings that have any.
std::string bounce_text(const std::vector<BounceRow>&, const sim::BounceStudyOptions&);
std::string bounce_json(const std::vector<BounceRow>&);

}  // namespace powbench::host
