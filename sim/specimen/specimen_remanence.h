#pragma once

#include "sim/magnetics/circuit/remanence.h"
#include "sim/specimen/specimen.h"

namespace powbench::sim {

/// Of a specimen: magnet.coercive_field over the whole iron path.
inline Remanence remanence(const Specimen& s) {
  const auto& m = s.magnet;
  return {m.coercive_field * m.iron_length / s.coil.turns, s.coil.turns * m.pole_area * m.coercive_span,
          m.remanence};
}

}  // namespace powbench::sim
