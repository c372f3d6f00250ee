#include "sim/magnetics/steel_rows.h"

#include <Eigen/Cholesky>
#include <Eigen/Core>
#include <algorithm>
#include <cmath>
#include <cstdio>
#include <stdexcept>

#include "sim/magnetics/circuit/magnetic_circuit.h"

namespace powbench::sim {
namespace {

std::string row_text(double value) {
  char buffer[32];
  std::snprintf(buffer, sizeof buffer, "%.4g", value);
  return buffer;
}

/// A mean of rows that stand close together.
struct Group {
  double h = 0, j = 0, weight = 0;
};

/// At most `most` groups of neighbours, rows with equal H always in one; the origin is left out.
std::vector<Group> grouped(const std::vector<BhRow>& rows, std::size_t most) {
  std::vector<Group> list;
  const double share = static_cast<double>(rows.size()) / static_cast<double>(most);
  double last = -1;
  for (const auto& r : rows) {
    if (r.h <= 0) continue;
    const double j = r.b - mu0 * r.h;
    if (!list.empty() && (r.h == last || list.back().weight + 0.5 < share)) {
      auto& g = list.back();
      g.h += r.h;
      g.j += j;
      g.weight += 1;
    } else {
      list.push_back({r.h, j, 1});
    }
    last = r.h;
  }
  for (auto& g : list) {
    g.h /= g.weight;
    g.j /= g.weight;
  }
  return list;
}

/// min |A x - y|^2 over x >= 0 by the active set of Lawson and Hanson, from normal equations. Columns have unit length.
Eigen::VectorXd least_squares_above_zero(const Eigen::MatrixXd& normal, const Eigen::VectorXd& right) {
  const auto n = normal.rows();
  Eigen::VectorXd x = Eigen::VectorXd::Zero(n);
  std::vector<Eigen::Index> free;
  const double enough = 1e-10 * right.cwiseAbs().maxCoeff();
  const auto solve = [&] {
    const auto m = static_cast<Eigen::Index>(free.size());
    Eigen::MatrixXd part(m, m);
    Eigen::VectorXd rest(m);
    for (Eigen::Index i = 0; i < m; ++i) {
      rest[i] = right[free[static_cast<std::size_t>(i)]];
      for (Eigen::Index k = 0; k < m; ++k)
        part(i, k) = normal(free[static_cast<std::size_t>(i)], free[static_cast<std::size_t>(k)]);
    }
    return Eigen::VectorXd(part.ldlt().solve(rest));
  };
  for (Eigen::Index pass = 0; pass < 6 * n; ++pass) {
    const Eigen::VectorXd gain = right - normal * x;
    Eigen::Index best = -1;
    for (Eigen::Index k = 0; k < n; ++k)
      if (std::find(free.begin(), free.end(), k) == free.end() && gain[k] > enough &&
          (best < 0 || gain[k] > gain[best]))
        best = k;
    if (best < 0) break;
    free.push_back(best);
    for (;;) {
      const Eigen::VectorXd s = solve();
      double step = 1;
      std::size_t stop = free.size();
      for (std::size_t i = 0; i < free.size(); ++i) {
        const double now = x[free[i]], then = s[static_cast<Eigen::Index>(i)];
        if (then <= 0 && now - then > 0 && now / (now - then) < step) {
          step = now / (now - then);
          stop = i;
        } else if (then <= 0 && now <= 0) {
          step = 0;
          stop = i;
        }
      }
      for (std::size_t i = 0; i < free.size(); ++i)
        x[free[i]] += step * (s[static_cast<Eigen::Index>(i)] - x[free[i]]);
      if (stop == free.size()) break;
      x[free[stop]] = 0;
      free.erase(free.begin() + static_cast<std::ptrdiff_t>(stop));
      if (free.empty()) break;
    }
  }
  return x;
}

/// J at the groups under the shape, with the slopes rising up to interval `turn` and falling behind it.
class ShapedFit {
 public:
  explicit ShapedFit(const std::vector<Group>& groups) : g_(groups) {}

  double fit(std::size_t turn, std::vector<double>& j) const {
    const auto n = static_cast<Eigen::Index>(g_.size());
    Eigen::MatrixXd ways(n, n);  // J at each group for one unit of each nonnegative coefficient
    for (Eigen::Index c = 0; c < n; ++c) {
      const auto interval = static_cast<std::size_t>(c);
      double sum = 0;
      for (std::size_t k = 0; k < g_.size(); ++k) {
        const bool rising = interval <= turn && k >= interval && k <= turn;
        const bool falling = interval > turn && k > turn && k <= interval;
        if (rising || falling) sum += g_[k].h - (k == 0 ? 0 : g_[k - 1].h);
        ways(static_cast<Eigen::Index>(k), c) = sum * std::sqrt(g_[k].weight);
      }
    }
    Eigen::VectorXd length(n), target(n);
    for (Eigen::Index c = 0; c < n; ++c) {
      length[c] = ways.col(c).norm();
      ways.col(c) /= length[c];
      const auto& g = g_[static_cast<std::size_t>(c)];
      target[c] = g.j * std::sqrt(g.weight);
    }
    const Eigen::VectorXd x = least_squares_above_zero(ways.transpose() * ways, ways.transpose() * target);
    const Eigen::VectorXd fitted = ways * x;
    j.resize(g_.size());
    for (std::size_t k = 0; k < g_.size(); ++k)
      j[k] = fitted[static_cast<Eigen::Index>(k)] / std::sqrt(g_[k].weight);
    return (fitted - target).squaredNorm();
  }

 private:
  const std::vector<Group>& g_;
};

std::vector<double> shaped(const std::vector<Group>& groups) {
  const ShapedFit fit(groups);
  std::vector<double> best, now;
  double least = 1e300;
  const std::size_t stride = std::max<std::size_t>(1, groups.size() / 20);
  std::size_t at = 0;
  const auto visit = [&](std::size_t turn) {
    const double sum = fit.fit(turn, now);
    if (sum >= least) return;
    least = sum;
    at = turn;
    best = now;
  };
  for (std::size_t turn = 0; turn < groups.size(); turn += stride) visit(turn);
  const std::size_t centre = at;
  for (std::size_t turn = centre > stride ? centre - stride : 0;
       turn < std::min(groups.size(), centre + stride + 1); ++turn)
    visit(turn);
  return best;
}

/// The fit read at even steps of arsinh H and J together: a chord of a curve that bends one way bends that way, too.
std::vector<BhRow> thinned(const std::vector<Group>& groups, const std::vector<double>& j) {
  constexpr int steps = 40;
  double steepest = 0, scale = groups.front().h;
  for (std::size_t k = 0; k < groups.size(); ++k) {
    const double slope = (j[k] - (k == 0 ? 0 : j[k - 1])) / (groups[k].h - (k == 0 ? 0 : groups[k - 1].h));
    if (slope > steepest) {
      steepest = slope;
      scale = groups[k].h;
    }
  }
  const double last = groups.back().h, reach = std::asinh(last / scale), top = j.back();
  const auto way = [&](double h, double height) { return std::asinh(h / scale) / reach + height / top; };
  std::vector<BhRow> rows{{0, 0}};
  std::size_t k = 0;
  for (int step = 1; step <= steps; ++step) {
    const double wanted = 2.0 * step / steps;
    while (k + 1 < groups.size() && way(groups[k].h, j[k]) < wanted) ++k;
    const double h0 = k == 0 ? 0 : groups[k - 1].h, j0 = k == 0 ? 0 : j[k - 1];
    double low = 0, high = 1;  // share of the piece
    for (int half = 0; half < 50; ++half) {
      const double middle = 0.5 * (low + high);
      (way(h0 + middle * (groups[k].h - h0), j0 + middle * (j[k] - j0)) < wanted ? low : high) = middle;
    }
    const double h = step == steps ? last : h0 + high * (groups[k].h - h0);
    rows.push_back({(step == steps ? top : j0 + high * (j[k] - j0)) + mu0 * h, h});
  }
  return rows;
}

void take_residual(FittedRows& f, const std::vector<BhRow>& measured) {
  const Steel curve = Steel::table("", f.rows);
  double squares = 0;
  for (const auto& r : measured) {
    const double miss = r.b - flux_density(curve, std::max(r.h, 0.0));
    squares += miss * miss;
    if (std::fabs(miss) <= f.worst) continue;
    f.worst = std::fabs(miss);
    f.worst_h = r.h;
  }
  f.rms = std::sqrt(squares / static_cast<double>(measured.size()));
}

void check_quadrant(const std::vector<BhRow>& rows, double largest_b, double largest_h) {
  constexpr double blur = 0.02, offset = 0.05;
  double smallest_b = largest_b;
  for (std::size_t k = 0; k < rows.size(); ++k) {
    const auto& r = rows[k];
    if (r.h > 0) smallest_b = std::min(smallest_b, r.b);
    if (!std::isfinite(r.b) || !std::isfinite(r.h)) throw BadRow(k, "a value is not a number");
    if (r.h < -blur * largest_h || r.b < -blur * largest_b)
      throw BadRow(k, "B = " + row_text(r.b) + " T at H = " + row_text(r.h) +
                          " A/m is negative: a loop; allowed the commutation curve, from zero upwards");
    if (std::fabs(r.h) <= 1e-9 * largest_h && r.b > offset * largest_b)
      throw BadRow(k, "B = " + row_text(r.b) +
                          " T at H = 0: a branch of a loop; allowed the commutation curve, from zero "
                          "upwards");
  }
  constexpr double rises = 0.05;
  if (smallest_b > (1 - rises) * largest_b)
    throw std::invalid_argument("B hardly rises: it is " + row_text(smallest_b) + " T at least and " +
                                row_text(largest_b) + " T at most");
}

}  // namespace

double flux_density(const Steel& steel, double h) {
  double low = 0, high = 1;
  while (steel.at(high).h < h) high *= 2;
  for (int k = 0; k < 100 && high - low > 1e-15 * high; ++k)
    (steel.at(0.5 * (low + high)).h < h ? low : high) = 0.5 * (low + high);
  return 0.5 * (low + high);
}

FittedRows fit_rows(std::vector<BhRow> measured) {
  constexpr std::size_t least_rows = 4, most_groups = 150;
  constexpr double most_residual = 0.03;
  double largest_b = 0, largest_h = 0;
  for (const auto& r : measured) {
    largest_b = std::max(largest_b, r.b);
    largest_h = std::max(largest_h, r.h);
  }
  check_quadrant(measured, largest_b, largest_h);
  std::erase_if(measured, [](const BhRow& r) { return r.h < 0; });
  std::stable_sort(measured.begin(), measured.end(),
                   [](const BhRow& a, const BhRow& b) { return a.h != b.h ? a.h < b.h : a.b < b.b; });
  const auto count = std::count_if(measured.begin(), measured.end(), [](auto& r) { return r.h > 0; });
  if (count < static_cast<std::ptrdiff_t>(least_rows))
    throw std::invalid_argument(std::to_string(count) + " rows with H above 0, at least " +
                                std::to_string(least_rows) + " are needed");
  FittedRows f;
  f.rows = measured;
  try {
    static_cast<void>(Steel::table("", f.rows));
    return f;
  } catch (const std::invalid_argument&) {
    f.smoothed = true;
  }
  const auto groups = grouped(measured, most_groups);
  f.rows = thinned(groups, shaped(groups));
  take_residual(f, measured);
  if (f.rms > most_residual * largest_b)
    throw std::invalid_argument("the best curve that rises and saturates misses the rows by " +
                                row_text(f.rms) + " T rms, by " + row_text(f.worst) + " T at H = " +
                                row_text(f.worst_h) + " A/m; allowed up to " + row_text(100 * most_residual) +
                                " % of the largest B, " + row_text(most_residual * largest_b) + " T rms");
  return f;
}

}  // namespace powbench::sim
