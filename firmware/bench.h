#pragma once

#include <array>
#include <cstdint>
#include <span>
#include <string_view>

#include "firmware/bench_devices.h"
#include "firmware/controller.h"
#include "firmware/iiod/responder.h"
#include "firmware/source_device.h"
#include "firmware/state_hash.h"

/// The whole firmware of a rig whose plant is simulated: controller, devices, responder and its connections.
/// The simulated rig runs it in its own process, the emulated board runs the same thing on its own processor.

namespace powbench::firmware {

/// Who the rig says it is. The texts must outlive the bench.
struct Identity {
  std::string_view kind, model, serial, version, specimen;
  std::string_view boot_id{};  ///< changes with every start; empty: the kind stands for it
  std::string_view secret{};   ///< what every token must begin with; empty: anything
};

/// What the plant and the server need to know about the bench, after every block and every request.
struct BenchReport {
  SetPoints set_points;
  std::uint32_t shots_armed = 0;
  std::uint32_t state_hash = 0;
  State state = State::idle;
  bool gate_on = false;
  bool settling = false;  ///< a shot was cut short and is not over yet
  bool phase_valid = false;
  bool relay_closed = false;  ///< the command to the safety relay: close
  bool lease_held = false;
  bool owner_connected = false;  ///< a connection on which the owner of the lease has spoken is open
};

class Bench {
 public:
  static constexpr unsigned max_connections = 16;
  using Status = iiod::Connection::Status;

  /// `storage`: as for Controller.
  Bench(const ControllerConfig&, const Identity&, std::span<std::int16_t> storage);
  Bench(const Bench&) = delete;
  Bench& operator=(const Bench&) = delete;

  /// One block through the controller, on two levels of interrupts or on one: see Controller.
  std::span<const GateEdge> control(const Block& block) { return controller_.control(block); }
  void background() { controller_.background(); }
  std::span<const GateEdge> step(const Block& block) { return controller_.step(block); }
  /// Takes what the last block led to into the state hash.
  void note(std::span<const GateEdge> edges);
  BenchReport report() const;

  /// The protocol, connection by connection (0 .. max_connections - 1).
  std::size_t feed(unsigned connection, std::span<const std::uint8_t> bytes, iiod::ByteSink& out);
  void resume(unsigned connection, iiod::ByteSink& out) { responder_.resume(connections_[connection], out); }
  void expire(unsigned connection, iiod::ByteSink& out, iiod::Errno error = iiod::etimedout) {
    responder_.expire(connections_[connection], error, out);
  }
  /// A line that has been silent in the middle of a request: what came of it is void.
  void forget_input(unsigned connection) { connections_[connection].forget_input(); }
  /// Forgets the connection: the next bytes on it are a new client's.
  void close(unsigned connection) {
    connections_[connection] = {};
    owner_connections_ &= ~(1U << connection);
  }
  /// Time passes for the lease while nothing is sampled, ms.
  void rest(std::int64_t ms) { controller_.rest(ms); }
  const iiod::Connection& connection(unsigned number) const { return connections_[number]; }

  const Controller& controller() const { return controller_; }
  SourceDevice& source() { return source_; }
  const SourceDevice& source() const { return source_; }

 private:
  bool owner_connected() const {
    return controller_.lease().held() && owner_number_ == controller_.lease().number() &&
           owner_connections_ != 0;
  }

  RamCalibrationMemory calibrations_;
  Controller controller_;
  SourceDevice source_;
  BenchDevices devices_;
  std::array<const iiod::Device*, 4> device_list_;
  std::array<iiod::ContextAttribute, 6> context_attributes_;
  iiod::Context context_;
  iiod::Responder responder_;
  std::array<iiod::Connection, max_connections> connections_{};
  StateHash hash_;
  std::uint32_t owner_connections_ = 0;  ///< a bit for each
  std::uint32_t owner_number_ = 0;       ///< the lease they belong to
};

}  // namespace powbench::firmware
