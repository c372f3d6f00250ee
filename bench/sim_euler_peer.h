#pragma once

#include "core/conditions.h"
#include "sim/specimen/specimen.h"

/// The peer of `sim_closing`: the usual way to simulate a contactor, semi-implicit Euler with a fixed step
/// and contacts tested once a step. Written on its own, so that it also checks the equations of the product.

namespace powbench::bench {

struct EulerClosing {
  double touch = -1;    ///< s, first contact touch; < 0: none
  double settled = -1;  ///< s, last contact touch
  double seat = -1;     ///< s, first core touch
  int openings = 0;
  long steps = 0;
};

EulerClosing euler_closing(const sim::Specimen&, const Conditions&, double duration, double step);

}  // namespace powbench::bench
