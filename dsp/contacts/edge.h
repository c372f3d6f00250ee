#pragma once

#include <array>

#include "core/events.h"
#include "dsp/contacts/edge_laws.h"
#include "dsp/signal/signal.h"

/// When a contact force leaves zero or comes back to it, without a shape for the whole contact.
///
/// Near the edge, with tau = (t - t0) / span on its closed side and 0 on its open side,
///   F(t) = tau^q (a0 + a1 tau + a2 tau^2) + b.
/// q = 0 is a jump (a damped pad), 1 a linear spring, 1.5 Hertz; the terms bend it to whatever follows, and a jump
/// that no low-pass smooths has a3 tau^3, too. For every q and t0 on a grid the amplitudes have Gaussian priors
/// and are integrated out in closed form; the mean over that posterior is the time, its standard deviation the
/// uncertainty: what the laws disagree about is in it. With a `delay` the powers of tau are those that the amplifier
/// shows (dsp/contacts/amplifier.h).

namespace powbench::dsp {

struct EdgeQuestion {
  double near = 0;    ///< s: a first guess, right to a few samples
  int side = +1;      ///< +1: closed after the edge (touch), -1: closed before it (release)
  double open = 0;    ///< s that nothing else touches on the open side, > 0
  double closed = 0;  ///< s of closed time to begin with, most of the rise, > 0
  double noise = 0;   ///< N, one sample, > 0
  double delay =
      0;  ///< s: group delay of the amplifier's low-pass, already taken out of the time axis; 0 = none
};

/// What one law makes of an edge.
struct EdgeLaw {
  double weight = 0;           ///< of its posterior, over all times; the sum over the laws is 1
  double mean = 0, sigma = 0;  ///< s: of t0, counted from EdgeAnswer::time
};

struct EdgeAnswer {
  bool known = false;     ///< enough samples
  bool followed = false;  ///< the laws leave no more than noise over the span used
  Measured time;          ///< s, mean and standard deviation
  double span = 0;        ///< s of closed time used: as much as the laws can follow
  double reduced_chi2 = 0;
  std::array<EdgeLaw, edge_laws> law;  ///< what the time is made of; from locate_edge
};

/// The span begins with all of `closed` and shrinks until a shorter one agrees, so that what the laws
/// cannot follow does not move the time. Clipped and lost samples end it. Cost: 0.1 .. 1 ms.
EdgeAnswer locate_edge(const Signal& force, const EdgeQuestion&);

/// The same edge from what stands beyond its foot: samples less than `foot` s inside the guess are left out, so that
/// the rise alone, over all of `closed`, says where it began. Known where the laws leave room for no other answer
/// than theirs.
EdgeAnswer locate_edge_beyond(const Signal& force, const EdgeQuestion&, double foot);

}  // namespace powbench::dsp
