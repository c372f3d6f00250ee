#include "sim/solid/rigid_part.h"

namespace powbench::sim {
namespace {

using Matrix = std::array<Vec3, 3>;

Vec3 times(const Matrix& m, const Vec3& a) {
  return {dot(m[0], a), dot(m[1], a), dot(m[2], a)};
}

Vec3 transposed_times(const Matrix& m, const Vec3& a) {
  return a.x * m[0] + a.y * m[1] + a.z * m[2];
}

/// x of m x = a, by Cramer's rule; m symmetric and regular.
Vec3 solve(const Matrix& m, const Vec3& a) {
  const Vec3 c0 = cross(m[1], m[2]), c1 = cross(m[2], m[0]), c2 = cross(m[0], m[1]);
  const double det = dot(m[0], c0);
  return 1 / det * (a.x * c0 + a.y * c1 + a.z * c2);
}

/// Rotation by the vector w (Rodrigues).
Vec3 rotated(const Vec3& w, const Vec3& a) {
  const double angle = norm(w);
  if (angle == 0) return a;
  const Vec3 e = 1 / angle * w;
  return std::cos(angle) * a + std::sin(angle) * cross(e, a) + (1 - std::cos(angle)) * dot(e, a) * e;
}

}  // namespace

Vec3 RigidPart::spin() const {
  return times(turn, solve(inertia, transposed_times(turn, momentum)));
}

double RigidPart::kinetic() const {
  return held ? 0 : 0.5 * mass * dot(velocity, velocity) + 0.5 * dot(momentum, spin());
}

double RigidPart::kinetic_between(const RigidPart& o) const {
  if (held) return 0;
  return 0.5 * mass * dot(velocity, o.velocity) + 0.25 * (dot(momentum, o.spin()) + dot(o.momentum, spin()));
}

RigidPart freeze(int first, int last, bool held, const NodeView& view, const std::vector<double>& masses) {
  RigidPart part;
  part.first = first;
  part.last = last;
  part.held = held;
  for (int n = first; n < last; ++n) {
    const double m = masses[static_cast<std::size_t>(n)];
    part.mass += m;
    part.centre += m * view.place(n);
    part.velocity += m * view.velocity(n);
  }
  part.centre = 1 / part.mass * part.centre;
  part.velocity = held ? Vec3{} : 1 / part.mass * part.velocity;
  for (int n = first; n < last; ++n) {
    const double m = masses[static_cast<std::size_t>(n)];
    const Vec3 r = view.place(n) - part.centre;
    part.arm.push_back(r);
    if (!held) part.momentum += m * cross(r, view.velocity(n));
    const double square = dot(r, r);
    for (int i = 0; i < 3; ++i) {
      part.inertia[static_cast<std::size_t>(i)] -= m * r[i] * r;
      part.inertia[static_cast<std::size_t>(i)][i] += m * square;
    }
  }
  return part;
}

void advance(RigidPart& part, const NodeForces& forces, const std::vector<Vec3>& reference, double dt,
             double drift, double* u, double* v) {
  if (!part.held) {
    Vec3 force, torque;
    for (const int n : forces.touched()) {
      if (n < part.first || n >= part.last) continue;
      force += forces[n];
      torque += cross(times(part.turn, part.arm[static_cast<std::size_t>(n - part.first)]), forces[n]);
    }
    part.velocity += dt / part.mass * force;
    part.momentum += dt * torque;
    // the spin at mid-step, so that the rotation is of second order
    const Vec3 first = part.spin();
    Matrix half = part.turn;
    for (int j = 0; j < 3; ++j) {
      const Vec3 column = rotated(0.5 * drift * first, {half[0][j], half[1][j], half[2][j]});
      for (std::size_t i = 0; i < 3; ++i) half[i][j] = column[static_cast<int>(i)];
    }
    const Vec3 middle = times(half, solve(part.inertia, transposed_times(half, part.momentum)));
    for (int j = 0; j < 3; ++j) {
      const Vec3 column = rotated(drift * middle, {part.turn[0][j], part.turn[1][j], part.turn[2][j]});
      for (std::size_t i = 0; i < 3; ++i) part.turn[i][j] = column[static_cast<int>(i)];
    }
    part.centre += drift * part.velocity;
  }
  const Vec3 spin = part.held ? Vec3{} : part.spin();
  for (int n = part.first; n < part.last; ++n) {
    const Vec3 arm = times(part.turn, part.arm[static_cast<std::size_t>(n - part.first)]);
    const Vec3 place = part.centre + arm - reference[static_cast<std::size_t>(n)];
    const Vec3 speed = part.held ? Vec3{} : part.velocity + cross(spin, arm);
    for (int i = 0; i < 3; ++i) {
      u[4 * static_cast<std::size_t>(n) + static_cast<std::size_t>(i)] = place[i];
      v[4 * static_cast<std::size_t>(n) + static_cast<std::size_t>(i)] = speed[i];
    }
  }
}

}  // namespace powbench::sim
