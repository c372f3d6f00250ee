#include "sim/models/plant.h"

#include <cassert>
#include <stdexcept>
#include <string>

#include "sim/mechanics/contact_damping.h"
#include "sim/models/plant_impl.h"
#include "sim/specimen/validate.h"

namespace powbench::sim {

Plant::Plant(const Specimen& specimen, const Mains& mains, const PlantOptions& options) {
  require_valid(specimen);
  if (const std::string beyond = rigid_only(specimen); !beyond.empty()) throw std::invalid_argument(beyond);
  require_valid(Supply{mains, options.coil_switch, options.suppression});
  if (!(options.relative_tolerance >= 1e-14 && options.relative_tolerance <= 1e-2))
    throw std::invalid_argument("relative tolerance: allowed 1e-14 .. 1e-2");
  impl_ = std::make_unique<Impl>(specimen, mains, options);
}
Plant::Plant(std::unique_ptr<Impl> impl) : impl_(std::move(impl)) {}
Plant::~Plant() = default;
Plant::Plant(Plant&& other) noexcept = default;
Plant& Plant::operator=(Plant&& other) noexcept = default;

Plant Plant::copy() const {
  return Plant(std::make_unique<Impl>(*impl_));
}

double Plant::now() const {
  return impl_->now;
}
void Plant::gate(bool on) {
  impl_->gate(on);
}
void Plant::advance(double t_end, std::span<const double> times, std::span<PlantSample> out) {
  assert(t_end >= impl_->now && out.size() >= times.size());
  assert(times.empty() || (times.front() > impl_->now && times.back() <= t_end));
  impl_->advance(t_end, times, out);
}
std::span<const PlantEvent> Plant::events() const {
  return impl_->model.events();
}
std::int64_t Plant::evaluations() const {
  return impl_->integrator.evaluations();
}
double Plant::supplied_energy() const {
  return impl_->model.supplied_energy(impl_->state_now().data());
}
double Plant::energy_residual() const {
  return impl_->model.energy_residual(impl_->state_now().data());
}

}  // namespace powbench::sim
