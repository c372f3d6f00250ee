#pragma once

#include <array>
#include <cmath>
#include <cstddef>
#include <utility>

/// Explicit Runge-Kutta pair of order 5 with embedded order 4 and a dense output of order 4.
/// Source: J. R. Dormand, P. J. Prince, J. Comput. Appl. Math. 6 (1980) 19-26; dense output: E. Hairer, S. P.
/// Norsett, G. Wanner, Solving Ordinary Differential Equations I, 2nd ed., section II.6.

namespace powbench::sim {

/// Quartic y(share), share in [0, 1] of a step, in nested form.
template <int capacity>
struct DenseOutput {
  std::array<std::array<double, capacity>, 5> c{};

  void evaluate(double share, int n, double* out) const {
    const double rest = 1 - share;
    for (int i = 0; i < n; ++i) {
      const auto k = static_cast<std::size_t>(i);
      out[i] = c[0][k] + share * (c[1][k] + rest * (c[2][k] + share * (c[3][k] + rest * c[4][k])));
    }
  }
};

template <int capacity>
class DormandPrince {
 public:
  double* slope(int stage) { return k_[static_cast<std::size_t>(stage)].data(); }
  const double* result() const { return y_.data(); }

  /// Tries a step h from (t, y); slope(0) must hold the derivative there. Afterwards result() is the state at
  /// t + h and slope(6) its derivative. Returns the largest error estimate over its tolerance (<= 1: accept;
  /// infinite: not finite).
  template <class System>
  double attempt(System& system, double t, double h, int n, const double* y, double tolerance) {
    const auto stage = [&](int s, double c, auto... a) {
      combine(h, n, y, std::make_index_sequence<sizeof...(a)>{}, a...);
      system.derivative(t + c * h, y_.data(), slope(s));
    };
    stage(1, 1.0 / 5, 1.0 / 5);
    stage(2, 3.0 / 10, 3.0 / 40, 9.0 / 40);
    stage(3, 4.0 / 5, 44.0 / 45, -56.0 / 15, 32.0 / 9);
    stage(4, 8.0 / 9, 19372.0 / 6561, -25360.0 / 2187, 64448.0 / 6561, -212.0 / 729);
    stage(5, 1.0, 9017.0 / 3168, -355.0 / 33, 46732.0 / 5247, 49.0 / 176, -5103.0 / 18656);
    stage(6, 1.0, 35.0 / 384, 0.0, 500.0 / 1113, 125.0 / 192, -2187.0 / 6784, 11.0 / 84);
    double worst = 0;
    for (int i = 0; i < n; ++i) {
      const double e = h * (71.0 / 57600 * k(0, i) - 71.0 / 16695 * k(2, i) + 71.0 / 1920 * k(3, i) -
                            17253.0 / 339200 * k(4, i) + 22.0 / 525 * k(5, i) - 1.0 / 40 * k(6, i));
      const double ratio = std::fabs(e) / (tolerance * system.scale(i));
      if (!std::isfinite(ratio)) return HUGE_VAL;
      if (ratio > worst) worst = ratio;
    }
    return worst;
  }

  /// Dense output of the step just tried from `y`.
  void dense(double h, int n, const double* y, DenseOutput<capacity>& out) const {
    for (int i = 0; i < n; ++i) {
      const auto s = static_cast<std::size_t>(i);
      const double rise = y_[s] - y[i];
      const double bend = h * k(0, i) - rise;
      out.c[0][s] = y[i];
      out.c[1][s] = rise;
      out.c[2][s] = bend;
      out.c[3][s] = rise - h * k(6, i) - bend;
      out.c[4][s] = h * (-12715105075.0 / 11282082432 * k(0, i) + 87487479700.0 / 32700410799 * k(2, i) -
                         10690763975.0 / 1880347072 * k(3, i) + 701980252875.0 / 199316789632 * k(4, i) -
                         1453857185.0 / 822651844 * k(5, i) + 69997945.0 / 29380423 * k(6, i));
    }
  }

 private:
  double k(int stage, int i) const {
    return k_[static_cast<std::size_t>(stage)][static_cast<std::size_t>(i)];
  }

  template <std::size_t... s, class... A>
  void combine(double h, int n, const double* y, std::index_sequence<s...>, A... a) {
    for (int i = 0; i < n; ++i) {
      const auto j = static_cast<std::size_t>(i);
      y_[j] = y[i] + h * ((a * k_[s][j]) + ...);
    }
  }

  std::array<std::array<double, capacity>, 7> k_{};
  std::array<double, capacity> y_{};
};

}  // namespace powbench::sim
