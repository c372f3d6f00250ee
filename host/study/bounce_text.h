#pragma once

#include <span>
#include <string>
#include <vector>

#include "sim/mechanics/bounce_study.h"
#include "sim/study/ladder.h"

/// How far the bounces of simulated closings can be believed, for people and for programs.

namespace powbench::host {

struct BounceRow {
  std::string name;  ///< of the closing
  sim::BounceStudy study;
};

/// The bounces of one case on every rung that takes tolerances and no seconds: a table of its times says little without
/// them.
std::vector<BounceRow> bounces_of(std::span<const sim::Rung>, const sim::Case&,
                                  const sim::BounceStudyOptions&);

/// One line a closing: events that agree with the truth's, largest time difference among them, for how long contact
/// states differ, and the condition; below a line that is not computable its ensemble.
std::string bounce_text(const std::vector<BounceRow>&, const sim::BounceStudyOptions&);
std::string bounce_json(const std::vector<BounceRow>&);

}  // namespace powbench::host
