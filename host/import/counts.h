#pragma once

#include <span>
#include <vector>

#include "core/record.h"

/// Numbers as the counts of a converter, which is how a record keeps them.

namespace powbench::host {

struct CountsNote {
  bool grid = false;        ///< the numbers lie on a converter's grid, which was found: nothing is lost
  double step = 0.0;        ///< SI unit of one count
  std::size_t clipped = 0;  ///< samples recognised as saturated
};

/// Fills raw, scale, offset and the clip limits of `to` from `values` (SI, none of them NaN where `valid`). When the
/// values lie on a grid of fewer than 65 000 steps, as those of a converter do, the counts are that converter's; else
/// the range is divided into 64 000 steps. Counts of samples that are not valid are filled from their neighbours'
/// level and mean nothing. With `find_clipping`, saturation is recognised where many samples in a row share the value
/// furthest from the beginning's, leave it again, and the values beside it are rare.
///
/// `known_step`: SI, not 0; the values are counts of this step, if they are multiples of it that fit 16 bits. NaN:
/// not known.
CountsNote to_counts(std::span<const double> values, const std::vector<bool>& valid, bool find_clipping,
                     double known_step, ChannelRecord& to);

/// Marks values at or beyond these limits as saturated, SI; NaN = no such limit.
void set_clip(ChannelRecord&, double low, double high);

}  // namespace powbench::host
