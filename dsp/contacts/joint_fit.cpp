#include "dsp/contacts/joint_fit.h"

#include <Eigen/Dense>
#include <algorithm>
#include <cmath>
#include <utility>

#include "core/units.h"
#include "dsp/contacts/joint_columns.h"
#include "dsp/contacts/joint_pulse.h"
#include "dsp/signal/gram.h"

namespace powbench::dsp {

namespace {

using Eigen::Index;
using Matrix = Eigen::MatrixXd;
using Vector = Eigen::VectorXd;
using View = Eigen::Map<const Matrix, 0, Eigen::OuterStride<>>;

Index signed_of(std::size_t i) {
  return static_cast<Index>(i);
}

/// Rows first .. last - 1 of the columns of a block.
View columns(const JointSystem& s, const JointRows& r, const JointBlock& b, std::size_t first,
             std::size_t last) {
  return {s.jacobian.data() + b.column * r.size() + first, signed_of(last - first), signed_of(b.count),
          Eigen::OuterStride<>(signed_of(r.size()))};
}

Eigen::Map<const Vector> part(const std::vector<double>& v, std::size_t first, std::size_t last) {
  return {v.data() + first, signed_of(last - first)};
}

struct Normal {
  Matrix gram;
  Vector gradient;
};

/// J^T J and J^T r; blocks meet only where their rows overlap.
Normal normal_of(const JointSystem& s, const JointRows& r) {
  const Index p = signed_of(s.columns);
  Normal n{Matrix::Zero(p, p), Vector::Zero(p)};
  for (std::size_t a = 0; a < s.blocks.size(); ++a) {
    const JointBlock& x = s.blocks[a];
    if (x.last > x.first)
      n.gradient.segment(signed_of(x.column), signed_of(x.count)) =
          cross<Matrix>(columns(s, r, x, x.first, x.last), part(s.residual, x.first, x.last));
    for (std::size_t b = a; b < s.blocks.size(); ++b) {
      const JointBlock& y = s.blocks[b];
      const std::size_t first = std::max(x.first, y.first), last = std::min(x.last, y.last);
      if (last <= first) continue;
      auto block =
          n.gram.block(signed_of(x.column), signed_of(y.column), signed_of(x.count), signed_of(y.count));
      block = cross<Matrix>(columns(s, r, x, first, last), columns(s, r, y, first, last));
      if (a != b)
        n.gram.block(signed_of(y.column), signed_of(x.column), signed_of(y.count), signed_of(x.count)) =
            block.transpose();
    }
  }
  n.gram.diagonal() += part(s.prior, 0, s.columns);
  n.gradient += part(s.pull, 0, s.columns);
  return n;
}

/// Solves (G + damping diag G) x = g with G scaled to a unit diagonal.
Vector damped_solve(const Matrix& G, const Vector& g, double damping) {
  const Vector scale = G.diagonal().cwiseMax(1e-30).cwiseSqrt().cwiseInverse();
  Matrix N = scale.asDiagonal() * G * scale.asDiagonal();
  N.diagonal().array() += damping + 1e-11;
  return scale.cwiseProduct(Vector(N.ldlt().solve(scale.cwiseProduct(g))));
}

/// Gauss-Newton step and the variances of the parameters.
struct Solved {
  Vector step, variance;
};
Solved solve(const Normal& n) {
  const Vector scale = n.gram.diagonal().cwiseMax(1e-30).cwiseSqrt().cwiseInverse();
  Matrix N = scale.asDiagonal() * n.gram * scale.asDiagonal();
  N.diagonal().array() += 1e-11;
  const Matrix inverse = N.ldlt().solve(Matrix::Identity(N.rows(), N.cols()));
  return {-scale.cwiseProduct(inverse * scale.cwiseProduct(n.gradient)),
          inverse.diagonal().cwiseProduct(scale.cwiseProduct(scale))};
}

/// The span of derivatives of a contact on rows i1 .. i2 - 1, to be projected out while the onset is moved there.
struct Subspace {
  std::size_t first = 0, last = 0;
  Matrix q;       ///< (rows, k) orthonormal
  Vector inside;  ///< (k) component of the residual
};

std::vector<Subspace> contact_subspaces(const JointSystem& s, const JointRows& r, std::size_t i1,
                                        std::size_t i2) {
  std::vector<Subspace> out;
  for (const JointBlock& b : s.blocks) {
    if (b.kind == JointBlock::Kind::ring || b.kind == JointBlock::Kind::pedestal ||
        b.last < b.first + b.count + 2 || b.last <= i1 || b.first >= i2)
      continue;
    Subspace u{b.first, b.last, {}, {}};
    const Matrix A = columns(s, r, b, b.first, b.last);
    Matrix G = cross<Matrix>(A, A);
    G.diagonal() += part(s.prior, b.column, b.column + b.count);
    const Vector scale = G.diagonal().cwiseMax(1e-30).cwiseSqrt().cwiseInverse();
    G = scale.asDiagonal() * G * scale.asDiagonal();
    G.diagonal().array() += 1e-9;
    const Eigen::LLT<Matrix> llt(G);
    // (A S) L^-T has orthonormal columns; with a prior slightly shorter ones, as it should be.
    const Matrix scaled = A * scale.asDiagonal();
    u.q = llt.matrixL().solve(scaled.transpose()).transpose();
    u.inside = Vector::Zero(signed_of(b.count));
    out.push_back(std::move(u));
  }
  return out;
}

/// Where the ring starts with the least sum of squares, every sample in [onset_from, onset_to] tried.
double best_onset(const JointInput& in, const JointModel& m, const JointRows& r, const JointSystem& s) {
  const std::size_t i1 = r.at(in.onset_from), i2 = r.at(in.onset_to);
  if (i2 <= i1 + 2) return m.ring.onset;
  const auto ring = ring_rows(m.ring, r, i1, i2);
  std::vector<double> left = s.residual;  // as if the ring had not started before i2
  const std::size_t now = std::clamp(r.at(m.ring.onset - 0.5 * r.dt), i1, i2);
  for (std::size_t i = now; i < i2; ++i) left[i] -= ring[i - i1] * r.weight[i];
  // The row of the onset itself shows the ring in part.
  if (now < i2) {
    const double m_rows = static_cast<double>(r.block);
    const double first = r.t[now] - 0.5 * (m_rows - 1) * r.sample;
    const double share =
        std::clamp(std::floor((first - m.ring.onset) / r.sample + m_rows + 1e-6), 0.0, m_rows) / m_rows;
    left[now] += (1 - share) * ring[now - i1] * r.weight[now];
  }
  auto spaces = contact_subspaces(s, r, i1, i2);
  double raw = 0;
  for (Subspace& u : spaces) u.inside = cross<Matrix>(u.q, part(left, u.first, u.last));
  const auto inside = [&] {
    double sum = 0;
    for (const Subspace& u : spaces) sum += u.inside.squaredNorm();
    return sum;
  };
  double projected = inside(), lowest = raw - projected, at = in.onset_to;
  for (std::size_t i = i2; i-- > i1;) {
    const double d = ring[i - i1] * r.weight[i];
    // Samples of the row one by one, then the whole row for good.
    double by_unit = 0, by_square = 0;
    for (Subspace& u : spaces) {
      if (i < u.first || i >= u.last) continue;
      const auto q = u.q.row(signed_of(i - u.first));
      by_unit += q.dot(u.inside);
      by_square += q.squaredNorm();
    }
    for (std::size_t k = 1; k <= r.block; ++k) {
      const double f = d * static_cast<double>(k) / static_cast<double>(r.block);
      const double cost = raw + 2 * f * left[i] + f * f - (projected + 2 * f * by_unit + f * f * by_square);
      if (cost < lowest) {
        lowest = cost;
        at = r.t[i] + (0.5 * static_cast<double>(r.block) - static_cast<double>(k)) * r.sample;
      }
    }
    raw += 2 * d * left[i] + d * d;
    projected += 2 * d * by_unit + d * d * by_square;
    for (Subspace& u : spaces)
      if (i >= u.first && i < u.last) u.inside += d * u.q.row(signed_of(i - u.first)).transpose();
  }
  return at;
}

/// Two evaluations whose memory a whole fit uses again.
struct Work {
  JointSystem now, next;
};

/// Reduced sums of squares of each contact, against the noise and not against raised weights.
void judge(const JointInput& in, JointModel& m, const JointRows& rows, Work& work) {
  JointRows r = rows;
  JointModel flat = m;
  for (JointPulse& p : flat.pulses) p.reduced_chi2 = 0;
  if (flat.rise) flat.rise->reduced_chi2 = 0;
  weigh_rows(in, flat, r);
  JointSystem& s = work.now;
  evaluate(in, m, r, s, false);
  for (JointPulse& p : m.pulses) {
    if (!p.modelled) continue;
    const auto own = misfit(r, s, p.shape.touch - r.dt, p.shape.release + r.dt);
    p.reduced_chi2 = own.chi2 / std::max(own.rows - static_cast<double>(free_numbers(p)), 1.0);
  }
  if (m.rise && m.rise->modelled) {
    const auto own = misfit(r, s, m.rise->touch - 2 * r.dt, m.rise->touch + joint_head);
    m.rise->reduced_chi2 = own.chi2 / std::max(own.rows - 2.0, 1.0);
  }
  m.chi2 = m.left_out = m.settling_out = 0;
  m.parameters = static_cast<double>(s.columns) + 1;
  m.dof = -static_cast<double>(s.columns);
  for (const JointPulse& p : m.pulses)
    if (!p.modelled) m.left_out += (p.shape.release - p.shape.touch) / r.dt;
  if (m.rise && !m.rise->modelled) m.settling_out = in.settling() / r.dt;
  m.left_out += m.settling_out;
  for (std::size_t i = 0; i < r.size(); ++i) {
    if (r.weight[i] == 0) continue;
    m.chi2 += s.residual[i] * s.residual[i];
    m.dof += 1;
  }
}

/// The settled force becomes free; its level stays.
void unmodel(const JointInput& in, JointRise& r) {
  const double level = r.linear.front();
  r.modelled = false;
  r.linear.assign(settled_terms(in, false), 0.0);
  r.linear.front() = level;
}

/// Descends from `m`; true when it still moved in the last iteration.
void descend(const JointInput& in, JointModel& m, JointRows& r, int iterations, Work& work) {
  weigh_rows(in, m, r);
  JointSystem &s = work.now, &t = work.next;
  evaluate(in, m, r, s, true);
  const auto rows = std::max(
      1.0, static_cast<double>(r.size() -
                               static_cast<std::size_t>(std::count(r.weight.begin(), r.weight.end(), 0.0))));
  double damping = 1e-3;
  for (int k = 0; k < iterations; ++k) {
    if (!m.ring.modes.empty() && in.onset_to > in.onset_from && !in.ring_fixed) {
      const double onset = best_onset(in, m, r, s);
      if (onset != m.ring.onset) {
        m.ring.onset = onset;
        evaluate(in, m, r, s, true);
      }
    }
    const Normal n = normal_of(s, r);
    double gain = 0;
    for (int tries = 0; tries < 5 && gain <= 0; ++tries) {
      const Vector step = -damped_solve(n.gram, n.gradient, damping);
      if (step.allFinite()) {
        JointModel next = moved(m, s, step.data(), in.options);
        evaluate(in, next, r, t, true);
        if (t.cost < s.cost) {
          gain = s.cost - t.cost;
          m = std::move(next);
          std::swap(s, t);
        }
      }
      damping = gain > 0 ? std::max(damping * 0.2, 1e-9) : damping * 8;
    }
    // where more is left than noise, standard uncertainties are larger too
    if (gain < in.enough * std::max(1.0, s.cost / rows)) break;
  }
}

/// Contacts of another shape than any pulse must not bend the ring: with the ring as it is, those go whose misfit is
/// larger than the ring itself could be.
void leave_out_misfits(JointInput in, JointModel& m, JointRows& r, Work& work) {
  in.ring_fixed = true;
  in.onset_to = in.onset_from;
  descend(in, m, r, 4, work);
  judge(in, m, r, work);
  const double noise = in.noise / std::sqrt(static_cast<double>(r.block));
  const auto gross = [&](double reduced, double t) {
    return std::sqrt(reduced) * noise > 4 * noise + 2 * m.ring.amplitude_at(t);
  };
  for (JointPulse& p : m.pulses)
    if (gross(p.reduced_chi2, std::max(p.shape.touch, m.ring.onset))) p.modelled = false;
  if (m.rise && m.rise->modelled && gross(m.rise->reduced_chi2, std::max(m.rise->touch, m.ring.onset)))
    unmodel(in, *m.rise);
}

/// Frees the skew of pulses where it is worth its parameter (Schwarz): the gain in the sum of squares, to second
/// order from the symmetric solution, above the logarithm of the pulse's rows. True when any was freed.
bool free_skews(const JointInput& in, JointModel& m, JointRows& r, Work& work) {
  JointModel free = m;
  const auto rows_of = [&](const JointPulse& p) { return (p.shape.release - p.shape.touch) / r.dt; };
  bool candidate = false;
  for (JointPulse& p : free.pulses) {
    candidate = candidate || (p.modelled && !p.skewed && rows_of(p) > 8);
    p.skewed = p.modelled && (p.skewed || rows_of(p) > 8);
  }
  if (!candidate) return false;
  weigh_rows(in, free, r);
  JointSystem& s = work.now;
  evaluate(in, free, r, s, true);
  const Normal n = normal_of(s, r);
  const Solved x = solve(n);
  bool any = false;
  for (const JointBlock& b : s.blocks) {
    if (b.kind != JointBlock::Kind::pulse || b.count < 5 || m.pulses[b.which].skewed) continue;
    const Index skew = signed_of(b.column + 4);
    if (!(x.step[skew] * x.step[skew] > std::log(rows_of(m.pulses[b.which])) * x.variance[skew])) continue;
    m.pulses[b.which].skewed = any = true;
    m.pulses[b.which].reduced_chi2 = 0;  // what was left belonged to the symmetric shape: full weight again
  }
  return any;
}

void fill_uncertainties(const JointInput& in, JointModel& m, JointRows& r, Work& work) {
  weigh_rows(in, m, r);
  JointSystem& s = work.now;
  evaluate(in, m, r, s, true);
  const Solved x = solve(normal_of(s, r));
  const auto u = [&](std::size_t c) { return std::sqrt(std::max(x.variance[signed_of(c)], 0.0)); };
  for (const JointBlock& b : s.blocks) {
    if (b.kind == JointBlock::Kind::pulse) {
      JointPulse& p = m.pulses[b.which];
      p.u_touch = u(b.column), p.u_release = u(b.column + 1), p.u_peak = u(b.column + 3);
      p.u_exponent = u(b.column + 2);
    } else if (b.kind == JointBlock::Kind::rise) {
      m.rise->u_touch = u(b.column);
    }
  }
}

}  // namespace

JointModel fit_joint(const JointInput& in, JointModel m, int iterations) {
  if (in.open_below > 0)
    for (JointPulse& p : m.pulses) p.modelled = p.modelled && p.shape.peak < in.open_below;
  if (!in.settles && m.rise && m.rise->modelled && !m.rise->linear.empty()) unmodel(in, *m.rise);
  if (m.rise && m.rise->linear.size() != settled_terms(in, m.rise->modelled)) {
    const double level = m.rise->linear.empty() ? 0.0 : m.rise->linear.front();
    m.rise->linear.assign(settled_terms(in, m.rise->modelled), 0.0);
    m.rise->linear.front() = level;
  }
  JointRows r = joint_rows(in, m);
  if (r.size() < 40) return m;
  Work work;
  if (!in.keep_all && !in.judged && !m.ring.modes.empty()) leave_out_misfits(in, m, r, work);
  descend(in, m, r, iterations, work);
  judge(in, m, r, work);
  if (free_skews(in, m, r, work)) {
    descend(in, m, r, std::min(iterations, 5), work);
    judge(in, m, r, work);
  }
  if (in.keep_all) {
    for (JointPulse& p : m.pulses) p.reduced_chi2 = 0;
    if (m.rise) m.rise->reduced_chi2 = 0;
    return m;
  }
  bool changed = false;
  for (JointPulse& p : m.pulses)
    if (in.bend && p.modelled && !p.bent && p.reduced_chi2 > 1.2) p.bent = changed = true, p.reduced_chi2 = 0;
  if (std::exchange(changed, false)) {
    descend(in, m, r, iterations, work);
    judge(in, m, r, work);
  }
  for (JointPulse& p : m.pulses)
    if (p.modelled && p.reduced_chi2 > 3.0) p.modelled = false, changed = true;
  if (m.rise && m.rise->modelled && m.rise->reduced_chi2 > 3.0) {
    unmodel(in, *m.rise);
    changed = true;
  }
  if (changed) {
    descend(in, m, r, iterations, work);
    judge(in, m, r, work);
  }
  if (!in.times_only) fill_uncertainties(in, m, r, work);
  m.pedestal_span = !in.pedestal ? 0.0 : m.rise ? m.rise->touch - m.ring.onset : r.t.back() - m.ring.onset;
  return m;
}

JointResidual joint_residual(const JointInput& in, const JointModel& m) {
  JointRows r = joint_rows(in, m);
  weigh_rows(in, m, r);
  JointSystem s;
  evaluate(in, m, r, s, false);
  JointResidual out;
  out.noise = in.noise / std::sqrt(static_cast<double>(r.block));
  out.signal.dt = r.dt;
  out.signal.t0 = r.t.empty() ? 0.0 : r.t.front();
  for (std::size_t i = 0; i < r.size(); ++i) {
    const bool good = r.weight[i] > 0;
    out.signal.value.push_back(good ? -s.residual[i] / r.weight[i] : 0.0);
    out.signal.masked.push_back(good ? mask_none : mask_gap);
    out.usable.push_back(good);
  }
  return out;
}

}  // namespace powbench::dsp
