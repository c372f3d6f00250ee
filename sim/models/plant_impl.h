#pragma once

#include <algorithm>
#include <cstdio>
#include <stdexcept>
#include <string>

#include "sim/models/contactor_model.h"
#include "sim/models/integrator.h"

/// Inside of a plant: for plant.cpp and sim/models/lanes only.

namespace powbench::sim {

struct Plant::Impl {
  Impl(const Specimen& specimen, const Mains& mains, const PlantOptions& options)
      : model(specimen, mains, options),
        integrator(model, options.relative_tolerance, 0.05 / mains.hertz),
        rest_state(model.rest()),
        bound(std::max(1e-4, 1e4 * options.relative_tolerance)) {
    model.events().reserve(256);
  }
  Impl(const Impl& other)
      : model(other.model),
        integrator(other.integrator),
        rest_state(other.rest_state),
        bound(other.bound),
        now(other.now),
        at_rest(other.at_rest) {
    integrator.attach(model);
  }

  ContactorModel model;
  EventIntegrator<ContactorModel> integrator;
  ContactorModel::State rest_state{};  ///< valid while at rest; keeps the ledger
  double bound = 0;                    ///< of the energy residual
  long steps = 0;
  double now = 0;
  bool at_rest = true;

  static constexpr double first_step = 1e-6;  // s

  ContactorModel::State state_now() const {
    ContactorModel::State s = rest_state;
    if (!at_rest) integrator.state(now, s);
    return s;
  }

  void gate(bool on) {
    if (on == model.supply().commanded()) return;
    auto s = state_now();
    model.set_coil(now, s.data(), on);
    integrator.restart(now, s, first_step);
    at_rest = false;
  }

  void settle() {
    ContactorModel::State s = integrator.end_state();
    ContactorModel::State calm = model.rest(model.offset(s.data()));
    const auto ledger = static_cast<std::size_t>(model.size() - 4);
    std::copy(s.begin() + static_cast<std::ptrdiff_t>(ledger), s.begin() + model.size(),
              calm.begin() + static_cast<std::ptrdiff_t>(ledger));
    model.book_loss(calm.data(), model.stored_energy(s.data()) - model.stored_energy(calm.data()));
    model.reset_modes();
    rest_state = calm;
    at_rest = true;
  }

  /// The residual is a sum since t = 0: what a look misses, the next one sees.
  void judge_energy() const {
    const double residual = model.energy_residual(integrator.end_state().data());
    if (residual <= bound) return;
    char text[160];
    std::snprintf(text, sizeof text,
                  "plant: the energies do not balance at t = %.9g s, residual %.3g, allowed %.3g",
                  integrator.end(), residual, bound);
    throw std::runtime_error(text);
  }

  [[noreturn]] void refuse_step() const {
    throw std::runtime_error("plant: the step became too small at t = " + std::to_string(integrator.end()) +
                             " s");
  }

  void advance(double t_end, std::span<const double> times, std::span<PlantSample> out) {
    std::size_t next = 0;
    ContactorModel::State s;
    while (!at_rest) {
      const double reach = std::min(integrator.end(), t_end);
      for (; next < times.size() && times[next] <= reach; ++next) {
        integrator.state(times[next], s);
        model.sample(times[next], s.data(), out[next]);
      }
      if (integrator.end() >= t_end) break;
      if (model.near_rest(integrator.end_state())) {
        settle();
        break;
      }
      if (!integrator.extend()) refuse_step();
      if (++steps % 32 == 0) judge_energy();
    }
    for (; next < times.size(); ++next) model.sample(times[next], rest_state.data(), out[next]);
    now = t_end;
  }
};

}  // namespace powbench::sim
