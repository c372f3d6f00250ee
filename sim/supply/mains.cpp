#include "sim/supply/mains.h"

#include <algorithm>

#include "sim/supply/refuse.h"

namespace powbench::sim {

MainsPiece mains_piece(const Mains& m, double t, double origin) {
  MainsPiece piece;
  for (const auto& d : m.dips) {
    const double start = origin + d.start;
    const double end = start + d.duration;
    if (!(end > start)) continue;
    if (t < start) piece.end = std::min(piece.end, start);
    if (t < start || t >= end) continue;
    piece.share *= 1 - d.depth;
    piece.jump += d.jump;
    piece.end = std::min(piece.end, end);
  }
  return piece;
}

bool plain(const Mains& m) {
  return m.kind == Mains::Kind::ac && m.resistance == 0 && m.inductance == 0 &&
         std::all_of(m.harmonics.begin(), m.harmonics.end(),
                     [](const Harmonic& h) { return h.share == 0; }) &&
         std::none_of(m.dips.begin(), m.dips.end(), [](const Dip& d) { return d.duration > 0; });
}

void require_valid(const Mains& m) {
  constexpr double turn = 6.3;  // rad, a little more than one
  require_range("mains volts", m.volts, 0, 1e6, "V");
  require_range("mains hertz", m.hertz, 1e-3, 1e5, "Hz");
  require_range("mains phase", m.phase, -1e9, 1e9, "rad");
  require_range("mains resistance", m.resistance, 0, 1e6, "ohm");
  const bool direct = m.kind == Mains::Kind::dc;
  require_range("mains inductance", m.inductance, 0, m.kind == Mains::Kind::ac ? 1e3 : 0,
                m.kind == Mains::Kind::ac ? "H" : "H behind a direct or rectified source");
  require_range("mains rectifier_drop", m.rectifier_drop, 0, 10, "V");
  for (const auto& h : m.harmonics) {
    require_range("harmonic order", h.order, 2, 50, "");
    require_range("harmonic share", h.share, 0, direct ? 0 : 1,
                  "of the fundamental; a direct source has none");
    require_range("harmonic phase", h.phase, -turn, turn, "rad");
  }
  for (const auto& d : m.dips) {
    require_range("dip start", d.start, 0, 1e3, "s");
    require_range("dip duration", d.duration, 0, 1e3, "s");
    require_range("dip depth", d.depth, 0, 1, "of the voltage");
    require_range("dip jump", d.jump, -turn, turn, "rad");
  }
}

}  // namespace powbench::sim
