#include "dsp/contacts/joint_columns.h"

#include <algorithm>
#include <cmath>
#include <utility>

#include "core/units.h"
#include "dsp/contacts/joint_pulse.h"
#include "dsp/vibration/mode_columns.h"

namespace powbench::dsp {

namespace {

constexpr double exponent_middle = exponent_prior, exponent_sigma = exponent_prior_sigma, skew_sigma = 0.3;
constexpr double pedestal_sigma = 0.2;  ///< N
constexpr double smooth_step = 2e-3;    ///< s: half period of the fastest cosine of a free settled force
constexpr double free_rises[] = {1e-4, 2e-4, 4e-4};
constexpr std::size_t rest_terms = 7;  ///< follow 100 Hz over 10 ms to 1 %, and nothing above 0.5 kHz
constexpr double gap_head = 60e-6;     ///< s around an unmodelled contact

std::complex<double> pole_of(const Pole& p) {
  return {-p.decay, 2 * pi * p.hertz};
}

std::complex<double> row_gain(const JointRows& r, const Pole& p) {
  if (r.block == 1) return 1.0;
  const std::complex<double> half = 0.5 * pole_of(p) * r.sample;
  const auto m = static_cast<double>(r.block);
  return std::sinh(m * half) / (m * std::sinh(half));
}

/// Share of row i after the onset.
double after_onset(const JointRows& r, std::size_t i, double onset) {
  const double m = static_cast<double>(r.block), first = r.t[i] - 0.5 * (m - 1) * r.sample;
  return std::clamp(std::floor((first - onset) / r.sample + m + 1e-6), 0.0, m) / m;
}

std::size_t tail_columns(double span) {
  return span > 0 ? 1 + static_cast<std::size_t>(span / smooth_step + 1e-6) + 3 : 0;
}

std::vector<JointBlock> blocks_of(const JointInput& in, const JointModel& m, const JointRows& r) {
  std::vector<JointBlock> out;
  std::size_t column = 0;
  const auto add = [&](JointBlock b) {
    b.column = column;
    column += b.count;
    out.push_back(b);
  };
  for (std::size_t k = 0; k < m.pulses.size(); ++k) {
    const JointPulse& p = m.pulses[k];
    if (!p.modelled) continue;
    const std::size_t first = r.at(p.shape.touch - r.dt), last = r.at(p.shape.release + r.dt);
    add({JointBlock::Kind::pulse, k, first, std::max(last, first), 0, free_numbers(p)});
  }
  if (m.rise) {
    const bool good = m.rise->modelled;
    const double from = m.rise->touch - r.dt;
    add({good ? JointBlock::Kind::rise : JointBlock::Kind::tail, 0, r.at(from), r.size(), 0,
         good ? 2 + rise_terms : settled_terms(in, false)});
  }
  if (!m.ring.modes.empty()) {
    const std::size_t first = r.at(m.ring.onset - r.dt);
    if (!in.ring_fixed) add({JointBlock::Kind::ring, 0, first, r.size(), 0, 4 * m.ring.modes.size()});
    const std::size_t last = m.rise ? std::max(first, r.at(m.rise->touch)) : r.size();
    if (in.pedestal) add({JointBlock::Kind::pedestal, 0, first, last, 0, 3});
  }
  return out;
}

/// One block's share: adds to the model, fills its columns (unweighted).
struct Writer {
  const JointRows& rows;
  JointSystem& out;
  std::vector<double>& model;
  bool derivatives;
  double* column(const JointBlock& b, std::size_t k) const {
    return out.jacobian.data() + (b.column + k) * rows.size();
  }

  void pulse(const JointBlock& b, const JointPulse& p) const {
    const std::size_t bends = p.skewed ? 5 : 4;
    for (std::size_t i = b.first; i < b.last; ++i) {
      const PulseValue v = pulse_row(p, rows, i);
      model[i] += v.force;
      if (!derivatives) continue;
      column(b, 0)[i] = v.touch, column(b, 1)[i] = v.release, column(b, 2)[i] = v.exponent;
      column(b, 3)[i] = v.unit;
      if (p.skewed) column(b, 4)[i] = v.log_skew;
      for (std::size_t j = 0; p.bent && j < joint_bends; ++j) column(b, bends + j)[i] = v.bend[j];
    }
    if (!derivatives) return;
    const auto about = [&](std::size_t k, double off, double sigma) {
      out.prior[b.column + k] = 1 / (sigma * sigma);
      out.pull[b.column + k] = off * out.prior[b.column + k];
    };
    about(2, p.shape.exponent - exponent_middle, exponent_sigma);
    if (p.skewed) about(4, std::log(p.shape.skew), skew_sigma);
    for (std::size_t j = 0; p.bent && j < joint_bends; ++j) about(bends + j, p.bend[j], bend_sigma(j));
  }

  BlockRows rows_of(const JointBlock& b) const {
    return {b.last - b.first, rows.t.data() + b.first, rows.weight.data() + b.first, model.data() + b.first};
  }

  void rise(const JointBlock& b, const JointRise& r) const {
    rise_block(rows_of(b), r.touch, r.rise, rows.dt, joint_tail, r.linear.data(),
               derivatives ? column(b, 0) + b.first : nullptr, rows.size());
  }

  void tail(const JointBlock& b, const JointRise& r) const {
    std::size_t first = b.first;
    while (first < b.last && rows.t[first] <= r.touch) ++first;
    for (std::size_t k = 0; derivatives && k < b.count; ++k)
      std::fill_n(column(b, k) + b.first, first - b.first, 0.0);
    if (first == b.last) return;
    const std::size_t cosines = b.count - 3;
    const double tau = rows.t[first] - r.touch;
    // cos(k a) from the two before: Chebyshev's recurrence.
    std::complex<double> e = std::polar(1.0, pi * tau / joint_tail);
    const std::complex<double> turn = std::polar(1.0, pi * rows.dt / joint_tail);
    double fall[3], step[3];
    for (int k = 0; k < 3; ++k)
      fall[k] = std::exp(-tau / free_rises[k]), step[k] = std::exp(-rows.dt / free_rises[k]);
    for (std::size_t i = first; i < b.last; ++i, e *= turn) {
      double before = 1, now = 1;
      for (std::size_t k = 0; k < b.count; ++k) {
        double basis = 1;
        if (k >= cosines) {
          basis = fall[k - cosines];
          fall[k - cosines] *= step[k - cosines];
        } else if (k > 0) {
          basis = k == 1 ? e.real() : 2 * e.real() * now - before;
          before = now, now = basis;
        }
        model[i] += r.linear[k] * basis;
        if (derivatives) column(b, k)[i] = basis;
      }
    }
  }

  /// The settled force at rest, `from` .. `from` + `span` s after the last touch: Chebyshev polynomials.
  void rest(const JointBlock& b, const JointRise& r, double from, double span) const {
    for (std::size_t i = b.first; i < b.last; ++i) {
      const double x =
          std::max(2 * (rows.t[i] - r.touch - from) / span - 1, -1.0);  // rows before have no weight
      double before = x, now = 1;
      for (std::size_t k = 0; k < b.count; ++k) {
        model[i] += r.linear[k] * now;
        if (derivatives) column(b, k)[i] = now;
        before = std::exchange(now, k == 0 ? x : 2 * x * now - before);
      }
    }
  }

  void pedestal(const JointBlock& b, const JointModel& m) const {
    const double span = std::max(rows.dt, rows.dt * static_cast<double>(b.last - b.first));
    for (std::size_t i = b.first; i < b.last; ++i) {
      const double share = i < b.first + 3 ? after_onset(rows, i, m.ring.onset) : 1.0;
      const double u = std::max(rows.t[i] - m.ring.onset, 0.0) / span;
      const double basis[3] = {share, share * u, share * u * u};
      for (std::size_t k = 0; k < 3; ++k) {
        model[i] += m.pedestal[k] * basis[k];
        if (derivatives) column(b, k)[i] = basis[k];
      }
    }
    if (!derivatives) return;
    for (std::size_t k = 0; k < 3; ++k) {
      out.prior[b.column + k] = 1 / (pedestal_sigma * pedestal_sigma);
      out.pull[b.column + k] = m.pedestal[k] * out.prior[b.column + k];
    }
  }

  void ring(const JointBlock& b, const Ring& ring) const {
    const std::size_t n = b.last - b.first;
    if (n == 0) return;
    std::vector<double> value(derivatives ? 0 : 2 * n);
    for (std::size_t j = 0; j < ring.modes.size(); ++j) {
      const RingMode& mode = ring.modes[j];
      double* c = derivatives ? column(b, 4 * j + 2) + b.first : value.data();
      double* d = derivatives ? column(b, 4 * j + 3) + b.first : value.data() + n;
      mode_columns(pole_of(mode.pole), row_gain(rows, mode.pole), rows.t[b.first] - ring.reference, rows.dt,
                   n, c, d);
      for (std::size_t i = 0; i < std::min<std::size_t>(3, n); ++i) {
        const double share = after_onset(rows, b.first + i, ring.onset);
        c[i] *= share, d[i] *= share;
      }
      if (derivatives)
        mode_block(rows_of(b), ring.reference, mode.cosine, mode.sine, c, d, column(b, 4 * j) + b.first,
                   column(b, 4 * j + 1) + b.first);
      else
        for (std::size_t i = 0; i < n; ++i) model[b.first + i] += mode.cosine * c[i] + mode.sine * d[i];
    }
  }
};

}  // namespace

std::size_t JointRows::at(double time) const {
  if (t.empty()) return 0;
  const double i = std::ceil((time - t.front()) / dt - 1e-9);
  if (!(i > 0)) return 0;
  return i >= static_cast<double>(t.size()) ? t.size() : static_cast<std::size_t>(i);
}

JointRows joint_rows(const JointInput& in, const JointModel& m) {
  JointRows r;
  const Signal& s = in.force;
  r.block = std::max<std::size_t>(1, static_cast<std::size_t>(std::floor(in.row / s.dt + 1e-6)));
  r.sample = s.dt;
  r.dt = static_cast<double>(r.block) * s.dt;
  double from = in.onset_from, to = in.onset_to;
  if (!m.pulses.empty()) {
    from = std::min(from, m.pulses.front().shape.touch);
    to = std::max(to, m.pulses.back().shape.release);
  }
  if (m.rise) {
    from = std::min(from, m.rise->touch);
    to = std::max(to, m.rise->touch + (in.rest > 0 ? in.settling() + in.rest : joint_tail));
  }
  if (!m.ring.modes.empty()) from = std::min(from, m.ring.onset);
  to = std::min(to + joint_margin_before, in.t_end);
  const std::size_t last = s.index_at(to);
  for (std::size_t i = s.index_at(std::max(from - joint_margin_before, in.from)); i + r.block <= last;
       i += r.block) {
    double sum = 0;
    bool good = true;
    for (std::size_t k = i; k < i + r.block; ++k) {
      sum += s.value[k];
      good = good && !s.masked[k];
    }
    r.t.push_back(s.time(i) + 0.5 * static_cast<double>(r.block - 1) * s.dt);
    r.y.push_back(sum / static_cast<double>(r.block));
    r.weight.push_back(good ? 1.0 : 0.0);
  }
  return r;
}

void weigh_rows(const JointInput& in, const JointModel& m, JointRows& r) {
  const double noise = in.noise / std::sqrt(static_cast<double>(r.block));
  const auto scale = [&](double t1, double t2, double factor) {
    for (std::size_t i = r.at(t1), last = r.at(t2); i < last; ++i) r.weight[i] *= factor;
  };
  for (double& w : r.weight) w = w > 0 ? 1 / noise : 0.0;
  if (in.blind_to > in.blind_from) scale(in.blind_from, in.blind_to, 0.0);
  for (const JointPulse& p : m.pulses) {
    if (!p.modelled)
      scale(p.shape.touch - gap_head, p.shape.release + gap_head, 0.0);
    else if (p.reduced_chi2 > 1.3)
      scale(p.shape.touch, p.shape.release, 1 / std::sqrt(p.reduced_chi2));
  }
  if (!m.rise) return;
  if (!m.rise->modelled)
    scale(m.rise->touch - gap_head, m.rise->touch + in.settling(), 0.0);
  else if (m.rise->reduced_chi2 > 1.3)
    scale(m.rise->touch, m.rise->touch + joint_head, 1 / std::sqrt(m.rise->reduced_chi2));
}

void evaluate(const JointInput& in, const JointModel& m, const JointRows& r, JointSystem& out,
              bool derivatives) {
  const std::size_t n = r.size();
  std::vector<double> model(n, 0.0);
  out.blocks = blocks_of(in, m, r);
  out.columns = out.blocks.empty() ? 0 : out.blocks.back().column + out.blocks.back().count;
  if (derivatives) {
    out.jacobian.resize(n * out.columns);
    out.prior.assign(out.columns, 0.0);
    out.pull.assign(out.columns, 0.0);
  }
  const Writer write{r, out, model, derivatives};
  out.cost = 0;
  for (const JointBlock& b : out.blocks) {
    if (b.kind == JointBlock::Kind::pulse) {
      const JointPulse& p = m.pulses[b.which];
      write.pulse(b, p);
      out.cost += std::pow((p.shape.exponent - exponent_middle) / exponent_sigma, 2);
      if (p.skewed) out.cost += std::pow(std::log(p.shape.skew) / skew_sigma, 2);
      for (std::size_t j = 0; p.bent && j < joint_bends; ++j)
        out.cost += std::pow(p.bend[j] / bend_sigma(j), 2);
    } else if (b.kind == JointBlock::Kind::rise) {
      write.rise(b, *m.rise);
    } else if (b.kind == JointBlock::Kind::tail) {
      in.rest > 0 ? write.rest(b, *m.rise, in.settling(), in.rest) : write.tail(b, *m.rise);
    } else if (b.kind == JointBlock::Kind::pedestal) {
      write.pedestal(b, m);
      for (const double v : m.pedestal) out.cost += v * v / (pedestal_sigma * pedestal_sigma);
    } else {
      write.ring(b, m.ring);
    }
  }
  if (in.ring_fixed && !m.ring.modes.empty()) {
    const std::size_t first = r.at(m.ring.onset);
    const auto ring = ring_rows(m.ring, r, first, n);
    for (std::size_t i = first; i < n; ++i) model[i] += ring[i - first];
  }
  out.residual.resize(n);
  for (std::size_t i = 0; i < n; ++i) {
    out.residual[i] = (model[i] - r.y[i]) * r.weight[i];
    out.cost += out.residual[i] * out.residual[i];
  }
  if (!derivatives) return;
  for (const JointBlock& b : out.blocks) {
    if (b.kind == JointBlock::Kind::ring || b.kind == JointBlock::Kind::rise) continue;  // are weighted
    for (std::size_t k = b.column; k < b.column + b.count; ++k)
      for (std::size_t i = b.first; i < b.last; ++i) out.jacobian[k * n + i] *= r.weight[i];
  }
}

namespace {

void move_pulse(JointPulse& p, const double* d, const ExtractOptions& o) {
  PulseShape& f = p.shape;
  const double width = f.release - f.touch, reach = std::max(0.25 * width, 20e-6);
  const double touch = f.touch + std::clamp(d[0], -reach, 0.25 * width);
  const double release = f.release + std::clamp(d[1], -0.25 * width, reach);
  f.touch = touch;
  f.release = std::max(release, touch + 0.3 * width);
  f.exponent = std::clamp(f.exponent + std::clamp(d[2], -0.5, 0.5), o.exponent_min, o.exponent_max);
  f.peak = std::max(f.peak + d[3], 0.1 * f.peak);
  if (p.skewed) f.skew = std::clamp(f.skew * std::exp(std::clamp(d[4], -0.3, 0.3)), 0.25, 4.0);
  for (std::size_t j = 0; p.bent && j < joint_bends; ++j)
    p.bend[j] = std::clamp(p.bend[j] + d[(p.skewed ? 5 : 4) + j], -0.4, 0.4);
}

void move_mode(RingMode& m, const double* d) {
  const double w = 2 * pi * m.pole.hertz;
  m.pole.hertz = (w + std::clamp(d[0], -0.03 * w, 0.03 * w)) / (2 * pi);
  m.pole.decay =
      std::clamp(m.pole.decay + std::clamp(d[1], -0.5 * m.pole.decay, m.pole.decay), 0.001 * w, 0.15 * w);
  m.cosine += d[2];
  m.sine += d[3];
}

}  // namespace

JointModel moved(const JointModel& m, const JointSystem& s, const double* step, const ExtractOptions& o) {
  JointModel out = m;
  for (const JointBlock& b : s.blocks) {
    const double* d = step + b.column;
    if (b.kind == JointBlock::Kind::pulse) {
      move_pulse(out.pulses[b.which], d, o);
    } else if (b.kind == JointBlock::Kind::pedestal) {
      for (std::size_t k = 0; k < 3; ++k) out.pedestal[k] += d[k];
    } else if (b.kind == JointBlock::Kind::ring) {
      for (std::size_t j = 0; j < out.ring.modes.size(); ++j) move_mode(out.ring.modes[j], d + 4 * j);
    } else {
      JointRise& r = *out.rise;
      std::size_t used = 0;
      if (b.kind == JointBlock::Kind::rise) {
        r.touch += std::clamp(d[0], -100e-6, 100e-6);
        r.rise = std::clamp(r.rise * std::exp(std::clamp(d[1], -0.7, 0.7)), 5e-6, 3e-3);
        used = 2;
      }
      for (std::size_t k = used; k < b.count; ++k) r.linear[k - used] += d[k];
    }
  }
  return out;
}

JointMisfit misfit(const JointRows& r, const JointSystem& s, double t1, double t2) {
  JointMisfit m;
  for (std::size_t i = r.at(t1), last = r.at(t2); i < last; ++i) {
    if (r.weight[i] == 0) continue;
    m.chi2 += s.residual[i] * s.residual[i];
    m.rows += 1;
  }
  return m;
}

std::vector<double> ring_rows(const Ring& ring, const JointRows& r, std::size_t i1, std::size_t i2) {
  const std::size_t n = i2 - i1;
  std::vector<double> out(n, 0.0), value(2 * n);
  if (n == 0) return out;
  for (const RingMode& m : ring.modes) {
    mode_columns(pole_of(m.pole), row_gain(r, m.pole), r.t[i1] - ring.reference, r.dt, n, value.data(),
                 value.data() + n);
    for (std::size_t i = 0; i < n; ++i) out[i] += m.cosine * value[i] + m.sine * value[n + i];
  }
  return out;
}

std::size_t settled_terms(const JointInput& in, bool modelled) {
  return modelled ? rise_terms : in.rest > 0 ? rest_terms : tail_columns(joint_tail);
}

}  // namespace powbench::dsp
