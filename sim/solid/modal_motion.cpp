#include "sim/solid/modal_motion.h"

#include <Eigen/Dense>
#include <algorithm>
#include <cmath>

#include "core/units.h"

namespace powbench::sim {
namespace {

/// A spring of the whole contact from the law of one of its two halves.
double both(double half) {
  return 2 * half;
}

}  // namespace

ModalContactor::ModalContactor(const RigidParts& parts, const ModalParts& modal, double damping)
    : parts_(parts), zeta_(damping) {
  mass_ = {parts.core_mass, parts.static_mass};
  square_ = {parts.return_rate, parts.buffer_rate};
  drag_ = {parts.core_damping, parts.buffer_damping};
  for (std::size_t j = 0; j < parts.bridges.size(); ++j) {
    mass_.push_back(parts.bridges[j].mass);
    mass_.push_back(parts.bridges[j].inertia);
    square_.insert(square_.end(), {0.0, parts.bridges[j].turning_rate});
    drag_.insert(drag_.end(), {0.0, 0.0});
  }
  const auto elastic = [&](const ElasticPart& part) {
    for (const double omega : part.omega) {
      mass_.push_back(1);
      square_.push_back(omega * omega);
      drag_.push_back(2 * zeta_ * omega);
    }
  };
  const int base_elastic = size();
  elastic(modal.base);
  std::vector<Term> face{{core, 1}};
  place(face, {{base, 1}}, modal.base, base_elastic, static_cast<int>(modal.base.shape.size()) - 1, -1);
  add_contact(face, parts.travel, both(parts.pole.stiffness), both(parts.pole.damping));
  add_contact({{core, -1}}, 0, both(parts.stop.stiffness), both(parts.stop.damping));
  pad_ = contacts_.size();
  for (int j = 0; j < static_cast<int>(parts.bridges.size()); ++j) {
    const int first = size();
    elastic(modal.bridge);
    const RigidBridge& b = parts.bridges[static_cast<std::size_t>(j)];
    const int y = first_bridge + 2 * j, theta = y + 1;
    for (int end = 0; end < 2; ++end) {
      const double side = end == 0 ? -1 : 1;
      std::vector<Term> pad;
      place(pad, {{y, 1}, {theta, side * b.pad_arm}}, modal.bridge, first, pad_place + end, 1);
      place(pad, {{base, parts.pads_follow}}, modal.base, base_elastic, 2 * j + end, -1);
      add_contact(pad, b.gap[end], parts.pad.stiffness, parts.pad.damping);
    }
    for (int end = 0; end < 2; ++end) {
      const double side = end == 0 ? -1 : 1;
      std::vector<Term> seat{{core, -1}};
      place(seat, {{y, 1}, {theta, side * b.seat_arm}}, modal.bridge, first, seat_place + end, 1);
      add_contact(seat, 0, parts.seat.stiffness, parts.seat.damping);
    }
    std::vector<Term> spring{{core, 1}};  // stretched as the core overtakes the bridge
    place(spring, {{y, 1}}, modal.bridge, first, spring_place, -1);
    springs_.push_back({add_terms(spring), static_cast<int>(spring.size()), b.preload, b.rate});
  }
}

void ModalContactor::place(std::vector<Term>& terms, std::vector<Term> rigid, const ElasticPart& part,
                           int first, int at, double sign) {
  for (const Term& t : rigid) terms.push_back({t.coordinate, sign * t.weight});
  for (int r = 0; r < part.modes(); ++r)
    terms.push_back(
        {first + r, sign * part.shape[static_cast<std::size_t>(at)][static_cast<std::size_t>(r)]});
}

int ModalContactor::add_terms(const std::vector<Term>& terms) {
  const int first = static_cast<int>(terms_.size());
  terms_.insert(terms_.end(), terms.begin(), terms.end());
  return first;
}

void ModalContactor::add_contact(const std::vector<Term>& terms, double clearance, double stiffness,
                                 double damping) {
  contacts_.push_back(
      {add_terms(terms), static_cast<int>(terms.size()), clearance, stiffness, damping, 0, 0, 0});
}

double ModalContactor::sum(int first, int count, const double* u) const {
  double s = 0;
  for (int k = first; k < first + count; ++k) {
    const Term& t = terms_[static_cast<std::size_t>(k)];
    s += t.weight * u[t.coordinate];
  }
  return s;
}

void ModalContactor::spread(int first, int count, double force, double* f) const {
  for (int k = first; k < first + count; ++k) {
    const Term& t = terms_[static_cast<std::size_t>(k)];
    f[t.coordinate] -= t.weight * force;
  }
}

void ModalContactor::forces(const double* u, const double* v, double pull, double* f) {
  for (int k = 0; k < size(); ++k) {
    const auto i = static_cast<std::size_t>(k);
    f[k] = -square_[i] * u[k] - drag_[i] * v[k];
  }
  f[core] += pull - parts_.return_preload;
  f[base] -= pull;
  for (const Spring& s : springs_) spread(s.first, s.count, s.preload + s.rate * sum(s.first, s.count, u), f);
  for (Contact& c : contacts_) {
    c.depth = sum(c.first, c.count, u) - c.clearance;
    c.force = c.rate = 0;
    if (!(c.depth > 0)) continue;
    c.rate = sum(c.first, c.count, v);
    c.force = std::max(0.0, c.stiffness * c.depth + c.damping * c.rate);
    if (c.force > 0) spread(c.first, c.count, c.force, f);
  }
}

std::vector<double> ModalContactor::equilibrium() {
  const int n = size();
  std::vector<double> u(static_cast<std::size_t>(n), 0.0), still(u), f(u), moved(u);
  u[core] = -parts_.return_preload / (both(parts_.stop.stiffness) + parts_.return_rate);
  for (int j = 0; j < static_cast<int>(parts_.bridges.size()); ++j) {
    const RigidBridge& b = parts_.bridges[static_cast<std::size_t>(j)];
    u[static_cast<std::size_t>(first_bridge + 2 * j)] =
        u[core] + b.preload / (2 * parts_.seat.stiffness + b.rate);
  }
  // the contacts that press do not change near this guess, so the forces are linear: two passes reach rounding
  for (int pass = 0; pass < 3; ++pass) {
    forces(u.data(), still.data(), 0, f.data());
    Eigen::MatrixXd slope(n, n);
    for (int k = 0; k < n; ++k) {
      const double h = k < first_bridge ? 1e-9 : 1e-10;
      auto there = u;
      there[static_cast<std::size_t>(k)] += h;
      forces(there.data(), still.data(), 0, moved.data());
      for (int i = 0; i < n; ++i)
        slope(i, k) = (moved[static_cast<std::size_t>(i)] - f[static_cast<std::size_t>(i)]) / h;
    }
    const Eigen::VectorXd step = slope.fullPivLu().solve(Eigen::Map<Eigen::VectorXd>(f.data(), n));
    for (int k = 0; k < n; ++k) u[static_cast<std::size_t>(k)] -= step[k];
  }
  forces(u.data(), still.data(), 0, f.data());
  return u;
}

double ModalContactor::critical_step() const {
  double highest = 0;
  for (std::size_t k = 0; k < mass_.size(); ++k) highest = std::max(highest, square_[k] / mass_[k]);
  double added = 0;  // what all contacts together add at most: their trace in the masses
  for (const Contact& c : contacts_)
    for (int k = c.first; k < c.first + c.count; ++k) {
      const Term& t = terms_[static_cast<std::size_t>(k)];
      added += c.stiffness * t.weight * t.weight / mass(t.coordinate);
    }
  return 2 / std::sqrt(highest + added);
}

double ModalContactor::stored(const double* u, const double* v) const {
  double e = parts_.return_preload * u[core];
  for (int k = 0; k < size(); ++k) {
    const auto i = static_cast<std::size_t>(k);
    e += 0.5 * (mass_[i] * v[k] * v[k] + square_[i] * u[k] * u[k]);
  }
  for (const Spring& s : springs_) {
    const double x = sum(s.first, s.count, u);
    e += s.preload * x + 0.5 * s.rate * x * x;
  }
  for (const Contact& c : contacts_)
    if (c.depth > 0) e += 0.5 * c.stiffness * c.depth * c.depth;
  return e;
}

double ModalContactor::loss(const double* v) const {
  double p = 0;
  for (int k = 0; k < size(); ++k) p += drag_[static_cast<std::size_t>(k)] * v[k] * v[k];
  for (const Contact& c : contacts_)
    if (c.depth > 0) p += (c.force - c.stiffness * c.depth) * c.rate;
  return p;
}

}  // namespace powbench::sim
