#pragma once

#include <cstddef>
#include <cstdint>
#include <functional>
#include <optional>
#include <span>
#include <vector>

#include "sim/models/closing.h"
#include "sim/study/axis.h"
#include "sim/team.h"

/// Closings without samples, several at a time in the lanes of vector instructions (sim/models/lanes).

namespace powbench::sim {

struct LaneClosing {
  std::size_t number = 0;  ///< what its caller knows it by
  Case what;
  double duration = 0;  ///< s
  double tolerance = 0;
};

enum class OnFailure : std::uint8_t {
  raise,      ///< as `simulate` does
  no_closing  ///< the empty truth, as `tried_closing` gives it
};

/// The truth of each to the bit what `simulate` gives, in the order in which they end. `next` is asked again after each
/// `done`: nothing means nothing at the moment.
void closings_in_lanes(const std::function<std::optional<LaneClosing>()>& next,
                       const std::function<void(std::size_t number, const ClosingTruth&)>& done, OnFailure);

/// One try.
struct Attempt {
  const Specimen* specimen = nullptr;
  const Conditions* conditions = nullptr;
  double duration = 0;  ///< s
};
/// `tried_closing` of each, in order; with a `model`: its own, one by one.
std::vector<ClosingTruth> tried_closings(std::span<const Attempt>, double tolerance, Team&,
                                         const ClosingModel& model = {});

}  // namespace powbench::sim
