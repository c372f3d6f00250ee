#include <algorithm>
#include <catch2/catch.hpp>
#include <cmath>
#include <functional>

#include "core/commanded_phase.h"
#include "tests/fmu/importer.h"
#include "tests/fmu/specimens.h"

using namespace powbench;
using namespace powbench::test;

namespace {

using Vector = std::vector<double>;

/// Somebody else's integrator: Runge-Kutta of order 4 with a fixed step, events located by halving the step.
class Integrator {
 public:
  Integrator(Unit2& u, std::size_t states, std::size_t indicators, std::function<double(double)> volts)
      : u_(u), x_(states), z_(indicators), volts_(std::move(volts)) {
    event();
  }

  void advance(double h) {
    const Vector before = x_;
    const double t0 = t_;
    take(before, t0, h);
    if (!crossed()) return completed();
    double low = 0, high = h;
    for (int k = 0; k < 34; ++k) {
      const double middle = 0.5 * (low + high);
      take(before, t0, middle);
      (crossed() ? high : low) = middle;
    }
    take(before, t0, high);
    enter_event();
    event();
  }
  double time() const { return t_; }
  int events = 0;

 private:
  Vector rates(double t, const Vector& x) {
    put(t, x);
    Vector d(x.size());
    REQUIRE(u_.call("fmi2GetDerivatives", d.data(), d.size()) == 0);
    return d;
  }
  void put(double t, const Vector& x) {
    REQUIRE(u_.call("fmi2SetTime", t) == 0);
    u_.set("coil_voltage", volts_(t));
    REQUIRE(u_.call("fmi2SetContinuousStates", x.data(), x.size()) == 0);
  }
  void take(const Vector& x0, double t0, double h) {
    const auto plus = [&](const Vector& d, double f) {
      Vector x = x0;
      for (std::size_t k = 0; k < x.size(); ++k) x[k] += f * d[k];
      return x;
    };
    const Vector a = rates(t0, x0), b = rates(t0 + h / 2, plus(a, h / 2)),
                 c = rates(t0 + h / 2, plus(b, h / 2)), d = rates(t0 + h, plus(c, h));
    for (std::size_t k = 0; k < x0.size(); ++k) x_[k] = x0[k] + h / 6 * (a[k] + 2 * b[k] + 2 * c[k] + d[k]);
    t_ = t0 + h;
    put(t_, x_);
  }
  bool crossed() {
    Vector now(z_.size());
    REQUIRE(u_.call("fmi2GetEventIndicators", now.data(), now.size()) == 0);
    for (std::size_t k = 0; k < now.size(); ++k)
      if ((now[k] < 0) != (z_[k] < 0)) return true;
    return false;
  }
  void completed() {
    int enter = 0, terminate = 0;
    REQUIRE(u_.call("fmi2CompletedIntegratorStep", 1, &enter, &terminate) == 0);
    CHECK(terminate == 0);
    if (enter == 0) return;
    enter_event();
    event();
  }
  void enter_event() {
    REQUIRE(u_.call("fmi2EnterEventMode") == 0);
    ++events;
  }
  void event() {
    fmu::fmi2::EventInfo info{1, 0, 0, 0, 0, 0};
    for (int k = 0; info.new_discrete_states_needed != 0; ++k) {
      REQUIRE(k < 200);
      REQUIRE(u_.call("fmi2NewDiscreteStates", &info) == 0);
    }
    REQUIRE(u_.call("fmi2EnterContinuousTimeMode") == 0);
    REQUIRE(u_.call("fmi2GetContinuousStates", x_.data(), x_.size()) == 0);
    REQUIRE(u_.call("fmi2GetEventIndicators", z_.data(), z_.size()) == 0);
    for (const double z : z_) CHECK(z > 0);  // at zero a root finder does not go on
  }

  Unit2& u_;
  Vector x_, z_;
  std::function<double(double)> volts_;
  double t_ = 0;
};

}  // namespace

TEST_CASE("integrated by another method the unit touches and seats within 1 us of the native simulation") {
  for (const auto& [name, specimen] : kinds_of_contactor()) {
    INFO(name);
    const Conditions c = conditions_at(110);
    const auto truth = sim::simulate_rigid(specimen, c, 0.03, 0).truth;
    REQUIRE((truth.touch && truth.core_seat));
    const Unpacked files(specimen, fmu::Fmi::two);
    Unit2 u(files, fmu::fmi2::model_exchange);
    REQUIRE(u.c != nullptr);
    const auto volts = [&](double t) {
      return std::sqrt(2.0) * c.supply_volts * std::sin(2 * pi * 50 * t + commanded_phase(c));
    };
    u.start();
    Integrator integrator(u, files.states, files.indicators, volts);
    const double end = std::max(*truth.touch, *truth.core_seat) + 1e-4;
    while (integrator.time() < end) integrator.advance(2e-6);
    CHECK(std::fabs(u.get("pole[1].touch_time") - *truth.touch) < 1e-6);
    CHECK(std::fabs(u.get("seat_time") - *truth.core_seat) < 1e-6);
    CHECK(integrator.events > 3);
    CHECK(u.get("core_position") == Approx(u.get("state.core.travel")).margin(1e-4));
  }
}
