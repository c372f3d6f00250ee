#pragma once

#include <span>

#include "dsp/contacts/edge.h"

namespace powbench::dsp {

/// The touches of one film meet one pad, hence one law: what the other edges say about the exponent counts in each.
/// (Losses bend every release in a way of its own.) Of an edge's posterior over times and laws, the weight of law l is
/// multiplied by
///   e + (1 - e) V_l / max V,   ln V_l = sum over the other edges of max(-4, ln(w_l / prior_l) / 2 - its maximum),
/// with w_l that edge's own weight. Only an edge that follows the laws has a vote; half of its evidence counts, since
/// three terms follow no pad exactly, and e = 0.02 stays for a pad that changes. Value and u become those of the new
/// posterior. Without another edge that follows the laws nothing changes.
void agree_on_law(std::span<EdgeAnswer* const>);

}  // namespace powbench::dsp
