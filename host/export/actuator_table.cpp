#include "host/export/actuator_table.h"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>

#include "host/config/bad_input.h"
#include "host/export/mat_out.h"

namespace powbench::host {
namespace {

/// The state with a given current: the current rises with the flux linkage.
sim::MagneticResponse state_at(const sim::MagneticPotential& potential, double current, double gap,
                               double& psi) {
  double low = 0, high = std::max(psi, 1e-6);
  sim::MagneticState s{high, 0, gap};
  for (int doublings = 0; potential.at(s).current < current; ++doublings) {
    if (doublings > 60)
      throw BadInput({fmt::format("--largest-current = {}: no flux of the magnet needs it", current)});
    low = high, high *= 2, s.psi = high;
  }
  s.psi = std::clamp(psi, low, high);
  sim::MagneticResponse m = potential.at(s);
  for (int pass = 0; pass < 200; ++pass) {
    const double miss = m.current - current;
    (miss > 0 ? high : low) = s.psi;
    double next = s.psi - miss / m.current_psi;
    if (!(next >= low && next <= high)) next = 0.5 * (low + high);
    const bool last = std::fabs(next - s.psi) <= 1e-15 * high;
    s.psi = next;
    m = potential.at(s);
    if (last) break;
  }
  psi = s.psi;
  return m;
}

/// Rows of a table block: axes in the first column and row.
MatVariable with_axes(const ActuatorTable& t, const char* name, const std::vector<double>& values) {
  MatVariable v{name, t.current.size() + 1, t.position.size() + 1, {0}};
  v.values.insert(v.values.end(), t.position.begin(), t.position.end());
  for (std::size_t i = 0; i < t.current.size(); ++i) {
    v.values.push_back(t.current[i]);
    for (std::size_t x = 0; x < t.position.size(); ++x) v.values.push_back(values[t.at(i, x)]);
  }
  return v;
}

double largest(const std::vector<double>& values) {
  double most = 0;
  for (const double v : values) most = std::max(most, std::fabs(v));
  return most;
}

/// What linear interpolation between the rows costs, as table blocks do by default.
void judge_interpolation(const sim::MagneticPotential& potential, double travel, ActuatorTable& t) {
  for (std::size_t i = 0; i + 1 < t.current.size(); ++i)
    for (std::size_t x = 0; x + 1 < t.position.size(); ++x) {
      const auto middle = [&](const std::vector<double>& v) {
        return 0.25 * (v[t.at(i, x)] + v[t.at(i + 1, x)] + v[t.at(i, x + 1)] + v[t.at(i + 1, x + 1)]);
      };
      double psi = middle(t.linkage);
      const double linkage = psi;
      const auto m = state_at(potential, 0.5 * (t.current[i] + t.current[i + 1]),
                              travel - 0.5 * (t.position[x] + t.position[x + 1]), psi);
      t.linear_error_linkage = std::max(t.linear_error_linkage, std::fabs(linkage - psi));
      t.linear_error_force = std::max(t.linear_error_force, std::fabs(middle(t.force) - m.pull));
    }
  t.linear_error_linkage /= largest(t.linkage);
  t.linear_error_force /= largest(t.force);
}

}  // namespace

ActuatorTable actuator_table(const sim::MagneticPotential& potential, double largest_current, double travel,
                             std::size_t currents, std::size_t positions) {
  ActuatorTable t;
  const auto graded = [](std::size_t k, std::size_t n) {
    const double share = static_cast<double>(k) / static_cast<double>(n - 1);
    return share * share;
  };
  for (std::size_t k = 0; k < currents; ++k) t.current.push_back(largest_current * graded(k, currents));
  for (std::size_t k = positions; k-- > 0;) t.position.push_back(travel * (1 - graded(k, positions)));
  const std::size_t states = currents * positions;
  for (auto* v : {&t.linkage, &t.force, &t.linkage_current, &t.linkage_position}) v->resize(states);
  t.extrapolated.resize(states);
  std::size_t beyond = 0;
  for (std::size_t x = 0; x < positions; ++x) {
    double psi = 0;
    for (std::size_t i = 0; i < currents; ++i) {
      const double gap = travel - t.position[x];
      const auto m = i == 0 ? potential.at({0, 0, gap}) : state_at(potential, t.current[i], gap, psi);
      const std::size_t k = t.at(i, x);
      t.linkage[k] = psi;
      t.force[k] = m.pull;
      t.linkage_current[k] = 1 / m.current_psi;
      t.linkage_position[k] = m.current_gap / m.current_psi;  // dx = -dgap
      t.extrapolated[k] = m.beyond ? 1 : 0;
      beyond += t.extrapolated[k];
    }
  }
  t.beyond = static_cast<double>(beyond) / static_cast<double>(states);
  judge_interpolation(potential, travel, t);
  return t;
}

std::string actuator_csv(const ActuatorTable& t) {
  std::string out =
      "current [A],position [m],flux linkage [Wb],force [N],d linkage / d current [H],d linkage / d position "
      "[Wb/m],extrapolated\n";
  for (std::size_t i = 0; i < t.current.size(); ++i)
    for (std::size_t x = 0; x < t.position.size(); ++x) {
      const std::size_t k = t.at(i, x);
      out += fmt::format("{},{},{},{},{},{},{}\n", t.current[i], t.position[x], t.linkage[k], t.force[k],
                         t.linkage_current[k], t.linkage_position[k], t.extrapolated[k]);
    }
  return out;
}

std::string actuator_modelica(const ActuatorTable& t, const std::string& title) {
  std::string out = "#1\n# " + title + "\n";
  for (const auto& [name, values, unit] :
       {std::tuple{"flux_linkage", &t.linkage, "Wb"}, {"force", &t.force, "N"}}) {
    const MatVariable v = with_axes(t, name, *values);
    out += fmt::format("double {}({},{}) # {} over current in A (down) and position in m (across)\n", name,
                       v.rows, v.columns, unit);
    for (std::size_t r = 0; r < v.rows; ++r)
      for (std::size_t c = 0; c < v.columns; ++c)
        out += fmt::format("{}{}", v.values[r * v.columns + c], c + 1 == v.columns ? "\n" : " ");
  }
  return out;
}

std::string actuator_mat(const ActuatorTable& t) {
  const std::size_t n = t.current.size(), m = t.position.size();
  return to_mat({{"i", 1, n, t.current},
                 {"x", 1, m, t.position},
                 {"Phi", n, m, t.linkage},
                 {"dPhi_di", n, m, t.linkage_current},
                 {"dPhi_dx", n, m, t.linkage_position},
                 {"F", n, m, t.force},
                 with_axes(t, "flux_linkage", t.linkage),
                 with_axes(t, "force", t.force)});
}

}  // namespace powbench::host
