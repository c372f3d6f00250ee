#pragma once

#include <complex>
#include <stdexcept>
#include <string>
#include <vector>

/// Filter design in zeros, poles and gain; never through expanded polynomials, which diverge in double
/// precision below about 1 % of the sample rate.

namespace powbench::dsp {

enum class FilterKind { low, high, band, stop };
enum class FilterFamily { butterworth, chebyshev1, chebyshev2, elliptic };

/// A filter that cannot be designed: which key, its value, what would be allowed.
class FilterDesignError : public std::invalid_argument {
 public:
  FilterDesignError(const std::string& key, double value, const std::string& allowed);
};

/// What the edges mean: Butterworth -3 dB; Chebyshev I and elliptic: end of the ripple, -ripple_db;
/// Chebyshev II: begin of the stop band, -stop_db.
struct FilterSpec {
  FilterKind kind = FilterKind::low;
  int order = 4;  ///< of the analog low-pass prototype, 1 .. 16; band and stop have twice as many poles
  double low_hertz = 0.0;   ///< lower band edge (band, stop) or the cut-off (high)
  double high_hertz = 0.0;  ///< upper band edge (band, stop) or the cut-off (low)
  double rate = 0.0;        ///< Hz, sample rate
  bool two_pass = false;    ///< true: edges and decibels hold after forward and backward filtering
  FilterFamily family = FilterFamily::butterworth;
  double ripple_db = 0.1;  ///< dB > 0, loss allowed in the pass band (Chebyshev I, elliptic)
  double stop_db = 60.0;   ///< dB > ripple_db, loss reached in the stop band (Chebyshev II, elliptic)
};

/// Digital zeros, poles and overall gain: H(z) = gain prod(z - zeros) / prod(z - poles).
struct Zpk {
  std::vector<std::complex<double>> zeros;
  std::vector<std::complex<double>> poles;
  double gain = 1.0;
};

/// One second-order section in powers of delta = z - 1:
/// H = (b0 delta^2 + n1 delta + n0) / (delta^2 + d1 delta + d0).
/// Poles and zeros near z = 1 (low frequencies) keep their full relative precision in d0, d1, n0, n1, where
/// the usual 1 + a1 + a2 loses (rate / frequency)^2 of it.
struct Section {
  double b0 = 1, n1 = 2, n0 = 1, d1 = 2, d0 = 1;

  double b1() const { return n1 - 2 * b0; }
  double b2() const { return n0 - n1 + b0; }
  double a1() const { return d1 - 2; }
  double a2() const { return 1 - d1 + d0; }
};

/// Bilinear transform with the edges prewarped, tan(pi f / rate). With `two_pass` a Butterworth edge moves so
/// that |H|^2 = sqrt(1/2) there (the cut-off of a low-pass of order N is divided by (sqrt(2) - 1)^(1 / 2N),
/// 1.117 for N = 4), and the other families are designed with half of ripple_db and stop_db.
/// Throws FilterDesignError for order outside 1 .. 16, edges outside (0, rate / 2), low >= high,
/// ripple_db <= 0, stop_db <= ripple_db, or NaN.
Zpk design_zpk(const FilterSpec&);

/// Sections with conjugate pole pairs, most resonant first. Band-pass sections without finite zeros have one
/// zero at +1 and one at -1; finite zeros go to the nearest poles. Every section has the same gain where the
/// filter has its reference (0, rate / 2, or the band centre), so none is tiny. Throws like design_zpk.
std::vector<Section> to_sections(const FilterSpec&);

/// Complex response at `hertz`.
std::complex<double> response(const std::vector<Section>&, double hertz, double rate);

}  // namespace powbench::dsp
