#pragma once

#include <span>
#include <string>

#include "sim/study/ladder.h"

/// What a ladder says of the errors of its rungs.

namespace powbench::host {

/// Model error of a rung, s: the largest difference to a rung above it, in the order fields and mechanics are named in.
/// `whole`: there was one above in fields and one above in mechanics; else it is the part that is known. NaN: none.
struct ModelError {
  sim::LadderTimes part{};
  bool whole = false;
  sim::LadderTimes known() const;  ///< NaN where it is not whole
};
ModelError model_error_of(std::size_t rung, std::span<const sim::Rung>, const sim::Ladder&);

/// "not known", or us.
std::string or_not_known(double seconds);

/// Three errors of every rung at its finest setting but one, as a table.
std::string three_errors_text(const sim::Ladder&, std::span<const sim::Rung>, const sim::LadderTimes& input);

}  // namespace powbench::host
