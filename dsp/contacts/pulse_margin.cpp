#include "dsp/contacts/pulse_margin.h"

#include <algorithm>
#include <cmath>
#include <optional>
#include <vector>

#include "dsp/signal/least_squares.h"

namespace powbench::dsp {

namespace {

constexpr double row = 5e-6;    ///< s
constexpr double step = 0.125;  ///< between exponents
constexpr double farthest =
    14.0;  ///< in the sum of squares above the best: one part in a thousand of the weight

struct Rows {
  std::vector<double> t, x;
  double noise = 0;
};

Rows rows_of(const Signal& s, double from, double to, double noise) {
  Rows r;
  const auto block = static_cast<std::size_t>(std::max(1.0, std::floor(row / s.dt + 1e-6)));
  r.noise = noise / std::sqrt(static_cast<double>(block));
  for (std::size_t i = s.index_at(from), last = s.index_at(to); i + block <= last; i += block) {
    double sum = 0;
    bool good = true;
    for (std::size_t k = i; k < i + block; ++k) sum += s.value[k], good = good && !s.masked[k];
    if (!good) continue;
    r.t.push_back(s.time(i) + 0.5 * static_cast<double>(block - 1) * s.dt);
    r.x.push_back(sum / static_cast<double>(block));
  }
  return r;
}

/// The fit at one exponent.
struct Node {
  PulseShape shape;
  double touch_u = 0, release_u = 0, peak_u = 0;  ///< given the exponent
  double cost = 0;                                ///< chi2 + prior
};

std::optional<Node> at_exponent(const Rows& r, const PulseShape& start) {
  const double width = start.release - start.touch;
  const auto shape_of = [&](std::span<const double> q) {
    return PulseShape{start.touch + q[0] * width, start.release + q[1] * width, start.peak * q[2],
                      start.exponent, start.skew};
  };
  const std::size_t n = r.t.size();
  const auto residuals = [&](std::span<const double> q, std::span<double> e) {
    const PulseShape f = shape_of(q);
    for (std::size_t i = 0; i < n; ++i) e[i] = (f(r.t[i]) - r.x[i]) / r.noise;
  };
  const auto derivatives = [&](std::span<const double> q, std::span<double> j) {
    const PulseShape f = shape_of(q);
    for (std::size_t i = 0; i < n; ++i) {
      const PulseGradient d = pulse_gradient(f, r.t[i]);
      j[i] = d.touch * width / r.noise;
      j[n + i] = d.release * width / r.noise;
      j[2 * n + i] = d.peak * start.peak / r.noise;
    }
  };
  const FreeParameter p[] = {{0, 1e-4, -0.3, 0.3}, {0, 1e-4, -0.3, 0.3}, {1, 1e-4, 0.2, 5}};
  const LeastSquares ls = levenberg_marquardt(residuals, n, p, 15, derivatives, 1e-3);
  for (std::size_t i = 0; i < 3; ++i)
    if (!std::isfinite(ls.u(i))) return std::nullopt;
  Node node{shape_of(ls.x), ls.u(0) * width, ls.u(1) * width, ls.u(2) * start.peak, 0};
  const double known = (start.exponent - exponent_prior) / exponent_prior_sigma;
  node.cost = ls.chi2 + known * known;
  return node;
}

/// Nodes from `best` in direction `side` (+1, -1) until they stop counting.
void walk(const Rows& r, const PulseShape& best, int side, const ExtractOptions& o, std::vector<Node>& out) {
  PulseShape at = best;
  const double first = out.front().cost;
  for (int k = 1; k < 40; ++k) {
    at.exponent = best.exponent + side * k * step;
    if (at.exponent < o.exponent_min || at.exponent > o.exponent_max) return;
    const auto node = at_exponent(r, at);
    if (!node || node->cost > first + farthest) return;
    at = node->shape;
    out.push_back(*node);
  }
}

/// Mean and standard deviation over the nodes; `value` and `u` of each.
template <class Value, class Spread>
Measured mixed(const std::vector<Node>& nodes, const std::vector<double>& weight, Value value, Spread u) {
  double mean = 0, square = 0;
  for (std::size_t k = 0; k < nodes.size(); ++k) mean += weight[k] * value(nodes[k]);
  for (std::size_t k = 0; k < nodes.size(); ++k) {
    const double d = value(nodes[k]) - mean;
    square += weight[k] * (d * d + u(nodes[k]) * u(nodes[k]));
  }
  return {mean, std::sqrt(square)};
}

}  // namespace

PulseMargin over_exponents(const Signal& force, double noise, const PulseShape& best, double from, double to,
                           const ExtractOptions& o) {
  PulseMargin out;
  const Rows r = rows_of(force, from, to, noise);
  if (r.t.size() < 7) return out;
  std::vector<Node> nodes;
  const auto middle = at_exponent(r, best);
  if (!middle) return out;
  nodes.push_back(*middle);
  walk(r, middle->shape, -1, o, nodes);
  walk(r, middle->shape, +1, o, nodes);
  if (nodes.size() < 2) return out;
  double least = 1e300, sum = 0;
  for (const Node& n : nodes) least = std::min(least, n.cost);
  std::vector<double> weight;
  for (const Node& n : nodes) weight.push_back(std::exp(0.5 * (least - n.cost))), sum += weight.back();
  for (double& w : weight) w /= sum;
  out.touch = mixed(
      nodes, weight, [](const Node& n) { return n.shape.touch; }, [](const Node& n) { return n.touch_u; });
  out.release = mixed(
      nodes, weight, [](const Node& n) { return n.shape.release; },
      [](const Node& n) { return n.release_u; });
  out.peak = mixed(
      nodes, weight, [](const Node& n) { return n.shape.peak; }, [](const Node& n) { return n.peak_u; });
  out.known = true;
  return out;
}

void use_margin(Contact& c, const PulseMargin& m, double grow) {
  const auto use = [grow](Measured& to, const Measured& with) {
    to.u = std::max(to.u, std::hypot(with.u, with.value - to.value) * grow);
  };
  use(c.touch, m.touch);
  use(c.release, m.release);
  use(c.peak, m.peak);
}

}  // namespace powbench::dsp
