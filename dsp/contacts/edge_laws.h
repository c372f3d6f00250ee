#pragma once

#include <array>
#include <cstddef>
#include <vector>

/// How well the laws of dsp/contacts/edge.h explain the force beside an edge at a given time.

namespace powbench::dsp {

inline constexpr int edge_terms = 3;                  ///< a0 .. a2; a jump, q = 0, has a3, too
inline constexpr std::size_t edge_laws = 7;           ///< exponents q
inline constexpr int edge_unknowns = edge_terms + 1;  ///< and b

/// Means of neighbouring samples; time runs into the contact from the guess on.
struct EdgeRows {
  std::vector<double> t, y;             ///< (n) s, rising; in units of the row's noise
  double step = 0, noise = 0, top = 0;  ///< s; N; N, largest row
  std::size_t closed = 0;               ///< rows with t > 0
  double delay = 0;                     ///< s, of the amplifier; 0 = none
  int side = +1;
};

/// What no edge time changes: rows, sum and sum of squares of the data.
struct EdgeTotals {
  double n = 0, y = 0, yy = 0;
};
EdgeTotals totals_of(const EdgeRows&);

struct EdgeEvidence {
  double log;  ///< of the evidence summed over the laws, up to a constant of the data
  std::array<double, edge_laws> share;  ///< of the evidence, by law: their sum is 1
  double chi2;  ///< what the best law leaves, |y - X x|^2; only where it was asked for
};

/// Of all laws with the edge at `t0`, s, over `span`, s: their amplitudes have Gaussian priors and are integrated out.
/// `breaks`: a jump may begin by pulling (a release).
EdgeEvidence evidence_at(const EdgeRows&, const EdgeTotals&, double t0, double span, bool breaks,
                         bool with_chi2);

/// Weight of a law before anything is seen, not normalised.
double law_prior(std::size_t law);

}  // namespace powbench::dsp
