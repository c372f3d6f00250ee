#pragma once

#include <complex>
#include <cstdint>
#include <vector>

#include "dsp/vibration/ring.h"

/// What the fit of a ring at given poles (ring.cpp) and the search for new ones (ring_search.cpp) both stand on.

namespace powbench::dsp {

/// A stretch of force as means of whole blocks of samples, about 100 kS/s: the ring needs no more.
struct RingRows {
  std::vector<double> t, y;        ///< s, N
  std::vector<std::uint8_t> good;  ///< 1 = usable and not masked
  double block = 1;                ///< samples averaged per row
  double dt = 0;                   ///< s between rows
};

/// Whole blocks within [t1, t2]. Without `usable` only the masks count.
RingRows ring_rows(const Signal&, const std::vector<std::uint8_t>* usable, double t1, double t2);

/// 1/s: -decay + 2 pi i hertz.
std::complex<double> pole_s(const Pole&);

/// The rows less a smooth settled force: cosines and a few exponential rises from `closed_from` to `to`, fitted to
/// the good rows.
std::vector<double> without_smooth(const RingRows&, double closed_from, double to);

}  // namespace powbench::dsp
