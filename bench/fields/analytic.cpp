#include "bench/fields/analytic.h"

#include <cmath>
#include <complex>

#include "bench/fields/case_mesh.h"
#include "bench/fields/harmonic.h"
#include "core/units.h"
#include "sim/magnetics/circuit/magnetic_circuit.h"
#include "sim/magnetics/plane/newton.h"

namespace powbench::bench {
namespace {

using namespace sim;
using Complex = std::complex<double>;
using Complexes = std::vector<Complex>;

std::size_t index(int i) {
  return static_cast<std::size_t>(i);
}

std::vector<double> joined(std::vector<double> a, const std::vector<double>& b) {
  a.insert(a.end(), b.begin() + 1, b.end());
  return a;
}

/// B (its second component) in the triangle at the smallest distance from the origin.
template <class Value>
Value field_at_centre(const FieldProblem& p, const std::vector<Value>& a) {
  const Mesh& m = p.space().mesh;
  for (std::size_t t = 0; t < m.triangle.size(); ++t)
    for (std::size_t c = 0; c < 3; ++c) {
      const auto v = index(m.triangle[t][c]);
      if (m.x[v] > 1e-12 || m.y[v] > 1e-12) continue;
      std::array<double, 3> l{};
      l[c] = 1;
      const auto shape = shape_at(p.space(), t, l);
      Value b{};
      for (int n = 0; n < p.space().nodes; ++n) {
        b += shape.curl_y[index(n)] * a[index(p.space().unknowns(t)[n])];
        // on the axis A/r is dA/dr
      }
      return b;
    }
  return {};
}

/// Solenoid of a thin sheet: half of it, z >= 0.
std::vector<AnalyticResult> solenoid(double length, double exact_l, double exact_b) {
  constexpr double a = 10e-3, thick = 0.04e-3, turns = 1000;
  const double half = length / 2;
  const auto r = joined(
      graded_lines({{0, 1e-3}, {a - thick / 2, 0.1e-3}}, 1.6, 2e-3),
      joined({a - thick / 2, a + thick / 2}, graded_lines({{a + thick / 2, 0.1e-3}, {0.4, 0}}, 1.6, 60e-3)));
  const auto z = joined(graded_lines({{0, 1e-3}, {half, 0.05e-3}}, 1.6, 2e-3),
                        graded_lines({{half, 0.05e-3}, {0.4, 0}}, 1.6, 60e-3));
  FieldSetup f;
  f.axisymmetric = true;
  f.windings = {{{{1, turns / 2}}}};  // half of the turns in the half model
  FieldProblem p(
      tensor_mesh(r, z, [&](double x, double y) { return std::fabs(x - a) < thick / 2 && y < half ? 1 : 0; },
                  {true, true, false, true}),
      f);
  Newton newton(p);
  std::vector<double> u(index(p.size()) + 1, 0), current;
  newton.solve({{false, 1, 0}}, u, current);
  double psi = 0;
  for (std::size_t k = 0; k < u.size(); ++k) psi += 2 * p.winding(0)[k] * u[k];
  const std::string name =
      "solenoid sheet, " + std::to_string(static_cast<int>(length * 1e3 + 0.5)) + " mm long";
  return {{name, "L, H", exact_l, psi, p.size()},
          {name, "Bz at the centre, T", exact_b, field_at_centre(p, u), p.size()}};
}

/// Uniform field of 1 T along y on all nodes.
std::vector<double> uniform_field(const FieldProblem& p) {
  std::vector<double> a(index(p.size()) + 1, 0);
  for (std::size_t k = 0; k + 1 < a.size(); ++k)
    a[k] = p.space().node_x[k] * (p.setup().axisymmetric ? 0.5 : -1);
  return a;
}

/// Sphere or cylinder of the permeability mu in a uniform field: the answer to what the body adds to K.
AnalyticResult round_body(bool sphere, double mu) {
  constexpr double radius = 0.05;
  FieldSetup f;
  f.axisymmetric = sphere;
  f.steels = {Steel::linear(mu)};
  f.steel_of_region = {-1, 0};
  const auto mesh = quarter_disc(radius, 40 * radius, 24, 28);
  FieldProblem p(mesh, f);
  FieldSetup bare = f;
  bare.steel_of_region = {-1, -1};
  FieldProblem air(mesh, bare);
  const auto a0 = uniform_field(p);
  const std::size_t n = a0.size();
  std::vector<double> zero(n, 0), gradient(n, 0), matrix(p.linear()), with(n, 0), without(n, 0);
  p.add_steel(zero.data(), gradient.data(), matrix.data());
  multiply(p.space().pattern, matrix, a0.data(), with.data());
  multiply(p.space().pattern, air.linear(), a0.data(), without.data());
  Cholesky cholesky(p.space().pattern);
  cholesky.factor(matrix.data());
  for (std::size_t k = 0; k + 1 < n; ++k) without[k] -= with[k];
  cholesky.solve(without.data());
  for (std::size_t k = 0; k + 1 < n; ++k) without[k] += a0[k];
  without.back() = 0;
  const double exact = sphere ? 3 * mu / (mu + 2) : 2 * mu / (mu + 1);
  return {std::string(sphere ? "sphere" : "cylinder") + " in a uniform field, mu_r " +
              std::to_string(static_cast<int>(mu)),
          "B inside, T", exact, field_at_centre(p, without), p.size()};
}

/// Slot of the width s across a gap g between faces of infinite permeability.
AnalyticResult carter(double s, double g) {
  const double reach = s / 2 + 8 * g, depth = 4 * s, end = reach * (1 + 1e-5);
  const double fine = 0.02 * g;
  auto x = joined(graded_lines({{0, 0}, {s / 2, fine}}, 1.8, s / 6),
                  graded_lines({{s / 2, fine}, {reach, 0}}, 1.8, g));
  x.push_back(end);
  const auto y = joined(graded_lines({{0, 0}, {g, fine}}, 1.8, g / 2),
                        graded_lines({{g, fine}, {g + depth, 0}}, 1.8, s / 3));
  FieldSetup f;
  f.windings = {{{{1, 1.0}}}};
  FieldProblem p(tensor_mesh(x, y,
                             [&](double u, double v) {
                               if (v < g) return u > reach ? 1 : 0;
                               return u < s / 2 ? 0 : -1;
                             },
                             {true, false, false, false}),
                 f);
  Newton newton(p);
  std::vector<double> a(index(p.size()) + 1, 0), current;
  newton.solve({{false, 1, 0}}, a, current);
  double psi = 0;
  for (std::size_t k = 0; k < a.size(); ++k) psi += p.winding(0)[k] * a[k];
  const double width = std::fabs(psi) * g / mu0;
  const double half = s / (2 * g);
  const double exact = 2 / pi * (std::atan(half) - std::log1p(half * half) / (2 * half));
  char name[160];
  std::snprintf(name, sizeof name, "slot of %g mm, gap %g mm", s * 1e3, g * 1e3);
  return {name, "lost width / slot", exact, 2 * (reach - width) / s, p.size()};
}

Complex bessel_ratio(Complex x) {  // I0(x) / I1(x)
  Complex term = 1, i0 = 1, i1 = 0.5, first = 0.5;
  for (int k = 1; k < 400; ++k) {
    const double n = k;
    term *= x * x / (4 * n * n);
    first *= x * x / (4 * n * (n + 1));
    i0 += term;
    i1 += first;
  }
  return i0 / (i1 * x);
}

Complex bessel0(Complex x) {
  Complex term = 1, sum = 1;
  for (int k = 1; k < 400; ++k) sum += term *= x * x / (4.0 * k * k);
  return sum;
}

void add(std::vector<AnalyticResult>& all, const std::string& name, const std::string& quantity,
         Complex exact, Complex found, int unknowns) {
  all.push_back({name, "Re " + quantity, exact.real(), found.real(), unknowns});
  all.push_back({name, "Im " + quantity, exact.imag(), found.imag(), unknowns});
}

/// A round wire with a given field strength at its surface: impedance a metre.
void wire(std::vector<AnalyticResult>& all, double radius, double sigma, double mu, double hertz) {
  constexpr double degrees_of_wedge = 1;
  const double skin = std::sqrt(2 / (2 * pi * hertz * mu0 * mu * sigma));
  auto radii = graded_lines({{0, 0}, {radius, std::min(0.1 * radius, skin / 4)}}, 1.4, radius / 8);
  FieldSetup f;
  f.depth = 360 / degrees_of_wedge;
  f.steels = {Steel::linear(mu)};
  f.steel_of_region = {0};
  f.conductivity = {sigma};
  f.windings = {{{{0, 1.0}}}};
  FieldProblem p(disc_wedge(degrees_of_wedge, radii), f);
  const Harmonic field(p, hertz);
  const double area = region_area(p.space().mesh, 0);
  Complexes load(index(p.size()) + 1);
  for (std::size_t k = 0; k < load.size(); ++k) load[k] = sigma * area * p.winding(0)[k];  // 1 V/m
  const auto a = field.solve(load);
  Complex flux = 0;
  for (std::size_t k = 0; k < load.size(); ++k) flux += p.winding(0)[k] * a[k];
  const double omega = 2 * pi * hertz;
  const Complex current = sigma * area * (f.depth - Complex(0, omega) * flux);
  const Complex z = 1.0 / current;
  const Complex kappa = std::sqrt(Complex(0, omega * mu0 * mu * sigma));
  const Complex exact = kappa / (2 * pi * radius * sigma) * bessel_ratio(kappa * radius);
  const double dc = 1 / (pi * radius * radius * sigma);
  char name[160];
  std::snprintf(name, sizeof name, "wire, radius %g mm, %g MS/m, mu_r %g, %g Hz", radius * 1e3, sigma * 1e-6,
                mu, hertz);
  all.push_back({name, "Rac/Rdc", exact.real() / dc, z.real() / dc, p.size()});
  all.push_back({name, "L inside, H/m", exact.imag() / omega, z.imag() / omega, p.size()});
}

/// A sheet with the field strength 1 A/m at its surface.
void lamination(std::vector<AnalyticResult>& all, double d, double sigma, double mu, double hertz) {
  const double half = d / 2, height = d / 10;
  const double skin = std::sqrt(2 / (2 * pi * hertz * mu0 * mu * sigma));
  auto x = graded_lines({{0, 0}, {half, std::min(half / 8, skin / 5)}}, 1.4, half / 6);
  x.push_back(half * 1.02);
  FieldSetup f;
  f.steels = {Steel::linear(mu)};
  f.steel_of_region = {0, -1};
  f.conductivity = {sigma, 0};
  f.windings = {{{{1, 1.0}}}};
  FieldProblem p(tensor_mesh(x, {0, height}, [&](double u, double) { return u < half ? 0 : 1; },
                             {true, false, false, false}),
                 f);
  const Harmonic field(p, hertz);
  Complexes load(index(p.size()) + 1);
  for (std::size_t k = 0; k < load.size(); ++k) load[k] = height * p.winding(0)[k];
  const auto a = field.solve(load);
  Complex edge = 0;
  int count = 0;
  for (std::size_t k = 0; k + 1 < a.size(); ++k)
    if (std::fabs(p.space().node_x[k] - half) < 1e-9 * half) {
      edge += a[k];
      ++count;
    }
  const Complex mean = edge / static_cast<double>(count) / half / (mu * mu0);
  const Complex k = std::sqrt(Complex(0, 2 * pi * hertz * mu0 * mu * sigma));
  char name[160];
  std::snprintf(name, sizeof name, "sheet of %g mm, %g MS/m, mu_r %g, %g Hz", d * 1e3, sigma * 1e-6, mu,
                hertz);
  add(all, name, "mean B / (mu H)", std::tanh(k * half) / (k * half), mean, p.size());
}

/// A long cylinder in an axial field: B on the axis over B at the surface.
void long_cylinder(std::vector<AnalyticResult>& all, double hertz) {
  constexpr double radius = 0.05, sigma = 1.6e7, height = 5e-3;
  const double skin = std::sqrt(2 / (2 * pi * hertz * mu0 * sigma));
  auto r = graded_lines({{0, 0}, {radius, std::min(radius / 80, skin / 5)}}, 1.4, radius / 80);
  r.push_back(radius * 1.0002);
  FieldSetup f;
  f.axisymmetric = true;
  f.conductivity = {sigma, 0};
  f.windings = {{{{1, 1.0}}}};
  FieldProblem p(tensor_mesh(r, {0, height}, [&](double u, double) { return u < radius ? 0 : 1; },
                             {true, false, false, false}),
                 f);
  const Harmonic field(p, hertz);
  Complexes load(index(p.size()) + 1);
  for (std::size_t k = 0; k < load.size(); ++k) load[k] = height / mu0 * p.winding(0)[k];
  const auto a = field.solve(load);
  char name[160];
  std::snprintf(name, sizeof name, "cylinder in an axial field, %g Hz", hertz);
  add(all, name, "Bz on the axis, T",
      1.0 / bessel0(std::sqrt(Complex(0, 2 * pi * hertz * mu0 * sigma)) * radius), field_at_centre(p, a),
      p.size());
}

void alternating_sphere(std::vector<AnalyticResult>& all, double hertz) {
  constexpr double radius = 0.05, sigma = 1.6e7;
  FieldSetup f;
  f.axisymmetric = true;
  f.conductivity = {0, sigma};
  FieldProblem p(quarter_disc(radius, 40 * radius, 36, 28), f);
  const Harmonic field(p, hertz);
  const auto a0 = uniform_field(p);
  auto load = field.mass_times(Complexes(a0.begin(), a0.end()));
  const double omega = 2 * pi * hertz;
  for (auto& value : load) value *= Complex(0, -omega);
  auto a = field.solve(load);
  for (std::size_t k = 0; k + 1 < a.size(); ++k) a[k] += a0[k];
  const Complex q = std::sqrt(Complex(0, omega * mu0 * sigma)) * radius;
  char name[160];
  std::snprintf(name, sizeof name, "sphere in a uniform field, %g Hz", hertz);
  add(all, name, "Bz at the centre, T", q / std::sinh(q), field_at_centre(p, a), p.size());
}

/// A ring of round wire, as a square one with the same mean geometric distance and the same resistance.
void ring(std::vector<AnalyticResult>& all, double hertz) {
  constexpr double a = 10e-3, wire_radius = 0.5e-3, copper = 5.8e7;
  const double side = wire_radius * std::exp(-0.25) / 0.44705;
  const double sigma = copper * pi * wire_radius * wire_radius / (side * side);
  const double fine = side / 12;
  const auto r = joined(graded_lines({{0, 1e-3}, {a - side / 2, fine}}, 1.5, 1e-3),
                        joined(graded_lines({{a - side / 2, fine}, {a + side / 2, fine}}, 1.5, fine * 2),
                               graded_lines({{a + side / 2, fine}, {0.3, 0}}, 1.5, 40e-3)));
  const auto z = joined(graded_lines({{0, fine}, {side / 2, fine}}, 1.5, fine * 2),
                        graded_lines({{side / 2, fine}, {0.3, 0}}, 1.5, 40e-3));
  FieldSetup f;
  f.axisymmetric = true;
  f.windings = {{{{1, 1.0}}}};
  FieldProblem p(
      tensor_mesh(r, z,
                  [&](double u, double v) { return std::fabs(u - a) < side / 2 && v < side / 2 ? 1 : 0; },
                  {true, true, false, true}),
      f);
  Newton newton(p);
  std::vector<double> u(index(p.size()) + 1, 0), current;
  newton.solve({{false, 1, 0}}, u, current);  // half of the wire's section in the half model
  double psi = 0, own = 0;
  const auto a0 = uniform_field(p);
  for (std::size_t k = 0; k < u.size(); ++k) {
    psi += p.winding(0)[k] * u[k];
    own += p.winding(0)[k] * a0[k];
  }
  const double inductance = psi / 2;  // 1 A in each half: 2 A in the wire
  const double resistance = 2 * pi * a / (sigma * side * side);
  const double omega = 2 * pi * hertz;
  const double exact_l = mu0 * a * (std::log(8 * a / wire_radius) - 1.75),
               exact_r = 2 * pi * a / (copper * pi * wire_radius * wire_radius);
  const Complex exact = Complex(0, -omega) * pi * a * a / Complex(exact_r, omega * exact_l);
  const Complex found = Complex(0, -omega) * own / Complex(resistance, omega * inductance);
  char name[160];
  std::snprintf(name, sizeof name, "ring in an alternating field, %g Hz", hertz);
  all.push_back({name, "L, H", exact_l, inductance, p.size()});
  add(all, name, "current, A", exact, found, p.size());
}

}  // namespace

std::vector<AnalyticResult> static_cases() {
  auto all = solenoid(40e-3, 0.00807467622, 0.0280992589);
  for (auto& r : solenoid(20e-3, 0.0135889176, 0.0444288294)) all.push_back(r);
  for (const double mu : {10., 100., 1000., 10000.}) all.push_back(round_body(true, mu));
  for (const double mu : {10., 1000.}) all.push_back(round_body(false, mu));
  all.push_back(carter(2e-3, 0.5e-3));
  all.push_back(carter(5e-3, 0.5e-3));
  all.push_back(carter(3e-3, 0.1e-3));
  return all;
}

std::vector<AnalyticResult> alternating_cases() {
  std::vector<AnalyticResult> all;
  for (const double hertz : {10., 50., 200.}) long_cylinder(all, hertz);
  wire(all, 5e-3, 5.8e7, 1, 50);
  wire(all, 5e-3, 5.8e7, 1, 1000);
  wire(all, 2e-3, 5.8e7, 1, 50);
  wire(all, 10e-3, 5e6, 500, 50);
  lamination(all, 0.5e-3, 2e6, 2000, 50);
  lamination(all, 0.5e-3, 2e6, 2000, 1000);
  lamination(all, 2e-3, 5e6, 1000, 50);
  alternating_sphere(all, 50);
  ring(all, 50);
  ring(all, 1000);
  return all;
}

}  // namespace powbench::bench
