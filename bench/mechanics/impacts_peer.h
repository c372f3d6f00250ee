#pragma once

#include <string>
#include <vector>

/// Simbody as a peer, in the same process. Both scenes have exact answers.

namespace powbench::bench {

/// A mass that falls on a Hertz contact under a constant force, without loss: it bounces for ever.
struct Bounces {
  double mass = 5e-3;      ///< kg
  double force = 4;        ///< N, towards the contact
  double stiffness = 1e8;  ///< N/m^1.5
  double height = 1e-3;    ///< m
  int touches = 17;
};

/// A mass of 1 kg on a spring of 1 N/m with dry friction of 1 N, let go at 8.5 m: half cycles of pi s lose 2 m each; it
/// stops at 4 pi s and 0.5 m, and stays.
struct DryStop {
  double start = 8.5, place = 0.5;  ///< m
  double end = 100;                 ///< s, when it is looked at
};

struct PeerRow {
  std::string method;
  double setting = 0;  ///< accuracy or transition speed
  double error = 0;    ///< s of the last touch, or m of the place
  double cpu = 0;      ///< s
};

bool simbody_is_here();
std::vector<PeerRow> simbody_bounces(const Bounces&, double last_touch);
std::vector<PeerRow> simbody_dry_stop(const DryStop&);

}  // namespace powbench::bench
