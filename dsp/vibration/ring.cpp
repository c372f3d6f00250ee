#include "dsp/vibration/ring.h"

#include <Eigen/Dense>
#include <algorithm>
#include <cmath>
#include <complex>
#include <utility>

#include "core/units.h"
#include "dsp/signal/gram.h"
#include "dsp/vibration/mode_columns.h"
#include "dsp/vibration/ring_rows.h"

namespace powbench::dsp {

namespace {

using Eigen::Index;
using Matrix = Eigen::MatrixXd;
using Vector = Eigen::VectorXd;

constexpr double ring_rate = 100e3;   ///< Hz: the ring needs no more; faster records are block-averaged
constexpr double smooth_step = 2e-3;  ///< s: half period of the fastest smooth term of the settled force
constexpr double rise_times[] = {1e-4, 2e-4, 4e-4};  ///< s: exponential rises a settling contact may show

}  // namespace

RingRows ring_rows(const Signal& s, const std::vector<std::uint8_t>* usable, double t1, double t2) {
  RingRows r;
  const auto m =
      std::max<std::size_t>(1, static_cast<std::size_t>(std::floor(1.0 / (ring_rate * s.dt) + 1e-6)));
  r.block = static_cast<double>(m);
  r.dt = r.block * s.dt;
  const std::size_t last = s.index_at(t2);
  for (std::size_t i = s.index_at(t1); i + m <= last; i += m) {
    double sum = 0;
    std::uint8_t good = 1;
    for (std::size_t k = i; k < i + m; ++k) {
      sum += s.value[k];
      if (s.masked[k] || (usable && !(*usable)[k])) good = 0;
    }
    r.t.push_back(s.time(i) + 0.5 * (r.block - 1) * s.dt);
    r.y.push_back(sum / r.block);
    r.good.push_back(good);
  }
  return r;
}

std::complex<double> pole_s(const Pole& p) {
  return {-p.decay, 2 * pi * p.hertz};
}

namespace {

RingRows only_good(const RingRows& in) {
  RingRows out;
  out.block = in.block;
  out.dt = in.dt;
  for (std::size_t i = 0; i < in.t.size(); ++i) {
    if (!in.good[i]) continue;
    out.t.push_back(in.t[i]);
    out.y.push_back(in.y[i]);
  }
  out.good.assign(out.t.size(), 1);
  return out;
}

/// Factor by which averaging a block changes exp(s t): sinh(m s dt / 2) / (m sinh(s dt / 2)).
std::complex<double> block_gain(const RingRows& r, const Pole& p) {
  if (r.block == 1) return 1.0;
  const std::complex<double> half = 0.5 * pole_s(p) * (r.dt / r.block);
  return std::sinh(r.block * half) / (r.block * std::sinh(half));
}

/// gain exp(s (t - reference)) of the rows from `first` on, over stretches without a gap.
void fill_modes(const RingRows& r, std::size_t first, std::complex<double> s, std::complex<double> gain,
                double reference, double* real, double* imaginary) {
  for (std::size_t i = first, last = 0; i < r.t.size(); i = last) {
    for (last = i + 1; last < r.t.size() && r.t[last] - r.t[last - 1] < 1.5 * r.dt;) ++last;
    mode_columns(s, gain, r.t[i] - reference, r.dt, last - i, real + i, imaginary + i);
  }
}

/// Smooth settled force: cosines up to 1 / (2 smooth_step) and a few exponential rises. Zero before
/// `closed_from`.
Matrix smooth_columns(const RingRows& r, double closed_from, double to) {
  const double span = to - closed_from;
  // the usual span is a whole number of steps: which side of it rounding falls on may not decide
  const int cosines = span > 0 ? 1 + static_cast<int>(span / smooth_step + 1e-6) : 0;
  Matrix M = Matrix::Zero(static_cast<Index>(r.t.size()), cosines ? cosines + 3 : 0);
  if (!cosines) return M;
  const auto open =
      static_cast<std::size_t>(std::lower_bound(r.t.begin(), r.t.end(), closed_from) - r.t.begin());
  std::vector<double> unused(r.t.size());
  for (int k = 0; k < cosines; ++k)
    fill_modes(r, open, {0, pi * k / span}, 1.0, closed_from, M.col(k).data(), unused.data());
  for (int k = 0; k < 3; ++k)
    fill_modes(r, open, -1 / rise_times[k], 1.0, closed_from, M.col(cosines + k).data(), unused.data());
  return M;
}

struct Solution {
  Matrix modes;     ///< (rows x 2 K) cosine and sine of each mode
  Matrix gram;      ///< normal equations of modes and smooth columns
  Vector rhs;       ///< their right-hand side
  Vector linear;    ///< (2 K + smooth) amplitudes
  Vector variance;  ///< of the amplitudes, unit noise
  double chi2 = 0;
};

/// Least squares from normal equations G c = q, scaled to a unit diagonal; well conditioned after scaling because the
/// modes are distinct.
Vector gram_solve(const Matrix& G, const Vector& q, Vector* variance) {
  const Vector scale = G.diagonal().cwiseSqrt().cwiseMax(1e-12).cwiseInverse();
  Matrix N = scale.asDiagonal() * G * scale.asDiagonal();
  N.diagonal().array() += 1e-10;
  const Eigen::LDLT<Matrix> ldlt(N);
  if (variance) {
    const Matrix inverse = ldlt.solve(Matrix::Identity(N.rows(), N.cols()));
    *variance = inverse.diagonal().cwiseProduct(scale.cwiseProduct(scale));
  }
  return scale.cwiseProduct(Vector(ldlt.solve(scale.cwiseProduct(q))));
}

Vector normal_solve(const Matrix& A, const Vector& y, Vector* variance) {
  return gram_solve(cross<Matrix>(A, A), cross<Matrix>(A, y), variance);
}

/// The smooth columns with their share of the normal equations, which no pole changes.
struct Smooth {
  Matrix columns;
  Matrix gram;
  Vector rhs;
};

/// Amplitudes for given poles: columns 2j, 2j + 1 are the cosine and sine of mode j, the smooth columns follow.
Solution solve(const RingRows& r, const std::vector<Pole>& poles, double reference, const Smooth& smooth) {
  const auto n = static_cast<Index>(r.t.size()), k = static_cast<Index>(poles.size()),
             m = smooth.columns.cols();
  Solution s;
  s.modes.resize(n, 2 * k);
  for (Index j = 0; j < k; ++j) {
    const Pole& p = poles[static_cast<std::size_t>(j)];
    fill_modes(r, 0, pole_s(p), block_gain(r, p), reference, s.modes.col(2 * j).data(),
               s.modes.col(2 * j + 1).data());
  }
  const Eigen::Map<const Vector> y(r.y.data(), n);
  s.gram.resize(2 * k + m, 2 * k + m);
  s.gram.topLeftCorner(2 * k, 2 * k) = cross<Matrix>(s.modes, s.modes);
  s.gram.topRightCorner(2 * k, m) = cross<Matrix>(s.modes, smooth.columns);
  s.gram.bottomLeftCorner(m, 2 * k) = s.gram.topRightCorner(2 * k, m).transpose();
  s.gram.bottomRightCorner(m, m) = smooth.gram;
  s.rhs.resize(2 * k + m);
  s.rhs << cross<Matrix>(s.modes, y), smooth.rhs;
  s.linear = gram_solve(s.gram, s.rhs, &s.variance);
  s.chi2 = (y - s.modes * s.linear.head(2 * k) - smooth.columns * s.linear.tail(m)).squaredNorm();
  return s;
}

/// Gauss-Newton step of all poles (2 per mode: angular frequency, decay) from a solution.
Vector pole_step(const RingRows& r, const Solution& s, double reference, const Smooth& smooth) {
  const Index n = s.modes.rows(), k2 = s.modes.cols(), m = smooth.columns.cols(), old = k2 + m;
  Matrix D(n, k2);
  for (Index j = 0; j < k2; j += 2) {
    const double a = s.linear[j], b = s.linear[j + 1];
    for (Index i = 0; i < n; ++i) {
      const double tau = r.t[static_cast<std::size_t>(i)] - reference, c = s.modes(i, j),
                   d = s.modes(i, j + 1);
      D(i, j) = tau * (b * c - a * d);
      D(i, j + 1) = -tau * (a * c + b * d);
    }
  }
  const Eigen::Map<const Vector> y(r.y.data(), n);
  Matrix G(old + k2, old + k2);
  G.topLeftCorner(old, old) = s.gram;
  G.block(0, old, k2, k2) = cross<Matrix>(s.modes, D);
  G.block(k2, old, m, k2) = cross<Matrix>(smooth.columns, D);
  G.bottomLeftCorner(k2, old) = G.topRightCorner(old, k2).transpose();
  G.bottomRightCorner(k2, k2) = cross<Matrix>(D, D);
  Vector q(old + k2);
  q << s.rhs, cross<Matrix>(D, y);
  return gram_solve(G, q, nullptr).tail(k2);
}

std::vector<Pole> stepped(const std::vector<Pole>& poles, const Vector& step, double factor) {
  std::vector<Pole> out = poles;
  for (std::size_t j = 0; j < out.size(); ++j) {
    const auto i = static_cast<Index>(2 * j);
    const double w = 2 * pi * poles[j].hertz;
    const double dw = std::clamp(factor * step[i], -0.05 * w, 0.05 * w);
    const double dd = std::clamp(factor * step[i + 1], -0.5 * poles[j].decay, poles[j].decay);
    out[j].hertz = (w + dw) / (2 * pi);
    out[j].decay = std::clamp(poles[j].decay + dd, 0.001 * w, 0.15 * w);
  }
  return out;
}

/// Poles closer together than the record can tell apart make the amplitudes explode: keep one of each.
std::vector<Pole> distinct(std::vector<Pole> poles) {
  std::vector<Pole> out;
  for (const Pole& p : poles) {
    const bool twin = std::any_of(out.begin(), out.end(), [&](const Pole& q) {
      return std::abs(p.hertz - q.hertz) < 0.15 * (p.decay + q.decay) / pi;
    });
    if (!twin) out.push_back(p);
  }
  return out;
}

}  // namespace

std::vector<double> without_smooth(const RingRows& r, double closed_from, double to) {
  const Matrix smooth = smooth_columns(r, closed_from, to);
  std::vector<double> x = r.y;
  if (smooth.cols() > 0) {
    const Eigen::Map<const Eigen::Matrix<std::uint8_t, Eigen::Dynamic, 1>> good_rows(r.good.data(),
                                                                                     smooth.rows());
    const Vector weight = good_rows.cast<double>();
    const Eigen::Map<const Vector> y(r.y.data(), smooth.rows());
    const Vector c = normal_solve(weight.asDiagonal() * smooth, weight.cwiseProduct(y), nullptr);
    Eigen::Map<Vector>(x.data(), smooth.rows()) -= smooth * c;
  }
  return x;
}

double Ring::value(double t) const {
  if (t < onset) return 0.0;
  double v = 0;
  for (const RingMode& m : modes) {
    const auto e = std::exp(pole_s(m.pole) * (t - reference));
    v += m.cosine * e.real() + m.sine * e.imag();
  }
  return v;
}

double Ring::longest_period() const {
  double longest = 0;
  for (const RingMode& m : modes) longest = std::max(longest, 1 / m.pole.hertz);
  return longest;
}

double Ring::amplitude_at(double t) const {
  double sum = 0;
  for (const RingMode& m : modes) {
    const double a = std::hypot(m.cosine, m.sine) * std::exp(-m.pole.decay * (t - reference));
    sum += a * a;
  }
  return std::sqrt(sum);
}

void Ring::add_to(Signal& s, double factor) const {
  const std::size_t first = s.index_at(onset), n = s.size() - first;
  if (n == 0) return;
  std::vector<double> value(2 * n);
  for (const RingMode& m : modes) {
    mode_columns(pole_s(m.pole), factor, s.time(first) - reference, s.dt, n, value.data(), value.data() + n);
    for (std::size_t i = 0; i < n; ++i) s.value[first + i] += m.cosine * value[i] + m.sine * value[n + i];
  }
}

std::vector<Pole> tail_poles(const RingInput& in, const ExtractOptions& o) {
  const RingRows r = ring_rows(in.residual, nullptr, in.from, in.to);
  if (r.t.size() < 60) return {};
  const Matrix smooth = smooth_columns(r, in.closed_from, in.to);
  const Eigen::Map<const Vector> y(r.y.data(), static_cast<Index>(r.y.size()));
  Vector x = y;
  if (smooth.cols() > 0) x -= smooth * normal_solve(smooth, y, nullptr);
  const double noise = in.noise / std::sqrt(r.block);
  const double high = std::min(o.ring_high_hertz, 0.45 / r.dt);
  return find_poles({x.data(), static_cast<std::size_t>(x.size())}, r.dt, noise, o.ring_modes,
                    o.ring_low_hertz, high);
}

Ring fit_ring(const RingInput& in, std::vector<Pole> poles, const ExtractOptions& o, double* reduced,
              double hopeless) {
  Ring ring;
  ring.onset = ring.reference = in.from;
  const RingRows r = only_good(ring_rows(in.residual, &in.usable, in.from, in.to));
  const double noise = in.noise / std::sqrt(r.block);
  Smooth smooth{.columns = smooth_columns(r, in.closed_from, in.to), .gram = {}, .rhs = {}};
  const Eigen::Map<const Vector> y(r.y.data(), static_cast<Index>(r.y.size()));
  smooth.gram = cross<Matrix>(smooth.columns, smooth.columns);
  smooth.rhs = cross<Matrix>(smooth.columns, y);
  poles = distinct(std::move(poles));
  while (!poles.empty() &&
         static_cast<Index>(r.t.size()) > 6 * static_cast<Index>(poles.size()) + smooth.columns.cols()) {
    Solution s = solve(r, poles, ring.reference, smooth);
    const auto left = [&] { return s.chi2 / (noise * noise * static_cast<double>(r.t.size())); };
    if (left() > 2 * hopeless) return ring;
    for (int i = 0; i < 8; ++i) {
      bool better = false;
      const Vector step = pole_step(r, s, ring.reference, smooth);
      for (const double factor : {1.0, 0.4, 0.1}) {
        const auto next = stepped(poles, step, factor);
        Solution t = solve(r, next, ring.reference, smooth);
        if (!(t.chi2 < s.chi2)) continue;
        better = s.chi2 - t.chi2 > 1e-4 * s.chi2;
        poles = next;
        s = std::move(t);
        break;
      }
      if (!better) break;
    }
    if (left() > hopeless) return ring;
    // The weakest mode goes while it is not significant or not a core mode; then fit again.
    std::size_t weakest = poles.size();
    double lowest = 5.0;
    for (std::size_t j = 0; j < poles.size(); ++j) {
      const auto i = static_cast<Index>(2 * j);
      const double u = noise * std::sqrt(0.5 * (s.variance[i] + s.variance[i + 1]));
      double z = std::hypot(s.linear[i], s.linear[i + 1]) / std::max(u, 1e-300);
      if (poles[j].hertz < o.ring_low_hertz || poles[j].hertz > o.ring_high_hertz ||
          poles[j].decay > o.ring_damping_max * 2 * pi * poles[j].hertz)
        z = 0;
      if (!(z >= lowest)) lowest = z, weakest = j;
    }
    if (weakest == poles.size()) {
      if (reduced) *reduced = left();
      for (std::size_t j = 0; j < poles.size(); ++j)
        ring.modes.push_back(
            {poles[j], s.linear[static_cast<Index>(2 * j)], s.linear[static_cast<Index>(2 * j + 1)]});
      break;
    }
    poles.erase(poles.begin() + static_cast<std::ptrdiff_t>(weakest));
  }
  return ring;
}

}  // namespace powbench::dsp
