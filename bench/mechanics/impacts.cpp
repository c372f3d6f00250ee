// Impacts and dry friction with exact answers: error against CPU time of the event solver of the rigid rung and of
// Simbody in the same process, where it is installed. Bounces: a mass of 5 g falls 1 mm on a Hertz contact under 4 N
// and loses nothing; the error is that of its seventeenth touch, 56 ms later. Dry stop: a mass on a spring with dry
// friction; the error is that of its place at 100 s, when it has stood for 87 s.
//   bench_mechanics_impacts [--json PATH]

#include <algorithm>
#include <boost/math/quadrature/tanh_sinh.hpp>
#include <cmath>
#include <cstdio>
#include <cstring>
#include <fstream>
#include <nlohmann/json.hpp>
#include <vector>

#include "bench/mechanics/chain.h"
#include "bench/mechanics/friction.h"
#include "bench/mechanics/impacts_peer.h"
#include "bench/mechanics/smooth.h"
#include "core/cpu_time.h"

namespace {

using namespace powbench;
using namespace powbench::bench;
using Json = nlohmann::ordered_json;

/// Fall, then contact and flight in turn; all of them alike.
///   contact: 2 int_0^D dx / sqrt(v^2 + 2 (F x - k x^2.5 / 2.5) / m), D its deepest; with x = D (1 - u^2)
double last_touch(const Bounces& b) {
  using R = long double;
  const R m = b.mass, force = b.force, k = b.stiffness;
  const R fall = std::sqrt(2 * R(b.height) * m / force), v = force / m * fall;
  const auto square = [&](R x) { return v * v + 2 * (force * x - k * x * x * std::sqrt(x) / R(2.5L)) / m; };
  R low = 0, high = 1e-3L;
  for (int n = 0; n < 200; ++n) {
    const R middle = (low + high) / 2;
    (square(middle) > 0 ? low : high) = middle;
  }
  boost::math::quadrature::tanh_sinh<R> integrate;
  const R deepest = low;
  const R contact = 2 * integrate.integrate(
                            [&](R u) {
                              const R q = square(deepest * (1 - u * u));
                              return q > 0 ? 2 * deepest * u / std::sqrt(q) : R(0);
                            },
                            R(0), R(1));
  return static_cast<double>(fall + (b.touches - 1) * (2 * fall + contact));
}

/// CPU time of one of many runs, s: the median.
template <class Run>
double cpu_of_one(const Run& run) {
  std::vector<double> all;
  for (int k = 0; k < 9; ++k) {
    constexpr int together = 20;
    const double start = process_cpu_seconds();
    for (int n = 0; n < together; ++n) run();
    all.push_back((process_cpu_seconds() - start) / together);
  }
  std::nth_element(all.begin(), all.begin() + 4, all.end());
  return all[4];
}

PeerRow own_bounces(const Bounces& b, double tolerance, double exact) {
  double last = 0;
  const auto run = [&] {
    sim::Chain<double, 1> ball;
    ball.mass = {b.mass};
    ball.force = {-b.force};
    ball.law.stiffness = b.stiffness;
    ball.wall = true;
    sim::EventSolver<sim::Chain<double, 1>> solver(ball, tolerance, 1e-3);
    const double y[] = {b.height, 0};
    solver.restart(0, y, 1e-5);
    const auto wanted = static_cast<std::size_t>(2 * b.touches - 1);  // touches and releases
    while (ball.times.size() < wanted && solver.extend()) continue;
    last = ball.times.size() < wanted ? std::nan("") : ball.times[wanted - 1];
  };
  run();
  return {"own 8(5,3), events", tolerance, std::fabs(last - exact), cpu_of_one(run)};
}

PeerRow own_dry_stop(const DryStop& d, double tolerance) {
  double place = 0;
  const auto run = [&] {
    sim::Smooth<2> block;
    auto mode = sim::FrictionMode::backward;
    block.rate = [&](double, const double* y, double* dy) {
      dy[0] = y[1];
      dy[1] = mode == sim::FrictionMode::stick ? 0 : -y[0] + sim::friction_force(mode, -y[0], 1);
    };
    block.positive = [&](double, const double* y) { return sim::friction_guard(mode, y[1], -y[0], 1); };
    block.at_zero = [&](double&, double* y) {
      y[1] = 0;
      mode = sim::after_stop(-y[0], 1);
    };
    sim::EventSolver solver(block, tolerance, 1);
    const double y[] = {d.start, 0};
    solver.restart(0, y, 1e-3);
    while (solver.end() < d.end && solver.extend()) continue;
    place = solver.end_state()[0];
  };
  run();
  return {"own 8(5,3), events", tolerance, std::fabs(place - d.place), cpu_of_one(run)};
}

void print(const char* title, const char* unit, const std::vector<PeerRow>& rows, Json& out) {
  std::printf("%s\n%-30s %9s %12s %12s\n", title, "method", "setting", unit, "CPU ms");
  Json list = Json::array();
  for (const PeerRow& r : rows) {
    std::printf("%-30s %9.0e %12.2e %12.4f\n", r.method.c_str(), r.setting, r.error, 1e3 * r.cpu);
    list.push_back({{"method", r.method}, {"setting", r.setting}, {"error", r.error}, {"cpu_s", r.cpu}});
  }
  out.push_back({{"scene", title}, {"rows", list}});
}

}  // namespace

int main(int argc, char** argv) {
  const char* json = nullptr;
  for (int i = 1; i + 1 < argc; i += 2)
    if (std::strcmp(argv[i], "--json") == 0) json = argv[i + 1];
  const Bounces b;
  const DryStop d;
  const double exact = last_touch(b);
  std::vector<PeerRow> bounces, stops;
  for (const double tolerance : {1e-6, 1e-8, 1e-10, 1e-12})
    bounces.push_back(own_bounces(b, tolerance, exact));
  for (const double tolerance : {1e-6, 1e-9, 1e-12}) stops.push_back(own_dry_stop(d, tolerance));
  for (const PeerRow& r : simbody_bounces(b, exact)) bounces.push_back(r);
  for (const PeerRow& r : simbody_dry_stop(d)) stops.push_back(r);
  if (!simbody_is_here()) std::printf("Simbody: not installed, no peer in this run\n");
  std::printf("seventeenth touch at %.12f s\n", exact);
  Json out = Json::array();
  print("bounces on a Hertz contact without loss: error of the seventeenth touch", "error s", bounces, out);
  print("mass on a spring with dry friction: error of its place at 100 s", "error m", stops, out);
  if (json != nullptr)
    std::ofstream(json) << Json{{"benchmark", "mechanics_impacts"}, {"scenes", out}}.dump(2) << "\n";
  return 0;
}
