#pragma once

#include <complex>
#include <string_view>
#include <vector>

/// Butterworth design in zeros, poles and gain; never through expanded polynomials, which diverge in double
/// precision below about 1 % of the sample rate.

namespace powbench::dsp {

enum class FilterKind { low, high, band, stop };

struct FilterSpec {
  FilterKind kind = FilterKind::low;
  int order = 4;  ///< of the analog low-pass prototype, 1 .. 16; band and stop have twice as many poles
  double low_hertz = 0.0;   ///< lower band edge (band, stop) or the cut-off (high)
  double high_hertz = 0.0;  ///< upper band edge (band, stop) or the cut-off (low)
  double rate = 0.0;        ///< Hz, sample rate
  bool two_pass = false;    ///< true: the -3 dB points hold after forward and backward filtering
};

/// Digital zeros, poles and overall gain: H(z) = gain prod(z - zeros) / prod(z - poles).
struct Zpk {
  std::vector<std::complex<double>> zeros;
  std::vector<std::complex<double>> poles;
  double gain = 1.0;
};

/// y[n] = b0 x[n] + b1 x[n-1] + b2 x[n-2] - a1 y[n-1] - a2 y[n-2]
struct Section {
  double b0 = 1, b1 = 0, b2 = 0, a1 = 0, a2 = 0;
};

/// Bilinear transform with the edges prewarped, 2 rate tan(pi f / rate). With `two_pass` each edge moves so
/// that |H|^2 = 1/2 there: the analog cut-off of a low-pass of order N is divided by (sqrt(2) - 1)^(1 / 2N)
/// (1.117 for N = 4). Throws std::invalid_argument for order outside 1 .. 16, edges outside (0, rate / 2),
/// low >= high, or NaN.
Zpk design_butterworth(const FilterSpec&);

/// Sections with conjugate pole pairs, most resonant first; every band-pass section has one zero at +1 and
/// one at -1; every section has unit gain where the filter has (0, rate / 2, or the band centre), so no
/// section gain is tiny.
std::vector<Section> to_sections(const FilterSpec&);

/// Complex response at `hertz`.
std::complex<double> response(const std::vector<Section>&, double hertz, double rate);

}  // namespace powbench::dsp
