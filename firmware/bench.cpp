#include "firmware/bench.h"

namespace powbench::firmware {

Bench::Bench(const ControllerConfig& config, const Identity& identity, std::span<std::int16_t> storage)
    : controller_(config, storage),
      source_(identity.specimen, controller_),
      devices_(controller_, &source_.set_points),
      device_list_{&devices_.daq(), &devices_.control(), &source_.device(), &devices_.trigger()},
      context_attributes_{{{"bench,kind", identity.kind},
                           {"boot_id", identity.boot_id.empty() ? identity.kind : identity.boot_id},
                           {"fw_version", identity.version},
                           {"hw_model", identity.model},
                           {"hw_serial", identity.serial},
                           {"protocol_version", "1"}}},
      context_{.description = identity.model, .attributes = context_attributes_, .devices = device_list_},
      responder_(context_) {
  controller_.use_memory(calibrations_);
  devices_.identify(context_attributes_);
  controller_.lease().protect(identity.secret);
}

BenchReport Bench::report() const {
  const FireControl& fire = controller_.fire_control();
  return {.set_points = source_.set_points,
          .shots_armed = fire.shots_armed(),
          .state_hash = hash_.value(),
          .state = fire.state(),
          .gate_on = fire.gate_on(),
          .settling = fire.settling(),
          .phase_valid = fire.phase().valid(),
          .relay_closed = fire.relay_closed(),
          .lease_held = controller_.lease().held(),
          .owner_connected = owner_connected()};
}

std::size_t Bench::feed(unsigned connection, std::span<const std::uint8_t> bytes, iiod::ByteSink& out) {
  const Lease& lease = controller_.lease();
  const std::uint32_t spoken = lease.times_renewed();
  const std::size_t used = responder_.feed(connections_[connection], bytes, out);
  if (controller_.calibrations().due()) controller_.take_calibration(controller_.save_calibration());
  if (lease.times_renewed() != spoken) {
    if (owner_number_ != lease.number()) owner_connections_ = 0;
    owner_number_ = lease.number();
    owner_connections_ |= 1U << connection;
  }
  return used;
}

void Bench::note(std::span<const GateEdge> edges) {
  const FireControl& fire = controller_.fire_control();
  const PhaseEstimate& phase = fire.phase();
  hash_.add(static_cast<std::uint32_t>(fire.state()) << 24 | static_cast<std::uint32_t>(fire.fault()) << 17 |
            static_cast<std::uint32_t>(fire.gate_on()) << 16 | phase.faults);
  hash_.add(phase.sample);
  hash_.add(phase.phase_turns);
  hash_.add(phase.frequency);
  hash_.add(phase.frequency_rate);
  hash_.add(phase.amplitude);
  for (const GateEdge& edge : edges) {
    hash_.add(edge.at.sample);
    hash_.add(static_cast<std::uint32_t>(edge.at.fraction) << 1 | static_cast<std::uint32_t>(edge.on));
  }
}

}  // namespace powbench::firmware
