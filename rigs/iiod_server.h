#pragma once

#include <cstdint>
#include <memory>
#include <string>

#include "rigs/board.h"
#include "rigs/rig.h"
#include "rigs/sim_rig_config.h"
#include "sim/specimen/specimen.h"

namespace powbench::rigs {

/// Port of the IIOD protocol. Several rigs on one machine take several loopback addresses, never several
/// ports: libiio 0.24 loses the port when it clones a context.
inline constexpr std::uint16_t iiod_port = 30431;

/// The address cannot be had; another one may.
struct AddressError : RigError {
  using RigError::RigError;
};

/// A simulated rig behind a real IIOD server. One thread, one event loop; requests never wait for virtual
/// time.
class IiodServer {
 public:
  /// Binds at once; throws RigError with one sentence if the address cannot be had. With an empty
  /// `options.boot_id` it makes up a new one: see rigs/boot_id.h.
  IiodServer(const SimRigConfig&, const sim::Specimen&, const std::string& address,
             std::uint16_t port = iiod_port, const BoardOptions& = {});
  ~IiodServer();
  IiodServer(const IiodServer&) = delete;
  IiodServer& operator=(const IiodServer&) = delete;

  const std::string& address() const;

  /// Serves until stop() is called from another thread, or SIGINT / SIGTERM when `until_interrupted`. Throws
  /// RigError, with every client cut off, when an emulated board fails.
  void serve(bool until_interrupted = false);
  void stop();

 private:
  struct Impl;
  std::unique_ptr<Impl> impl_;
};

/// A server in a thread of its own, on the first free address of a loopback network that other processes hardly use.
/// Ends with the object.
class LocalRig {
 public:
  LocalRig(const SimRigConfig&, const sim::Specimen&, const BoardOptions& = {});
  ~LocalRig();
  LocalRig(const LocalRig&) = delete;
  LocalRig& operator=(const LocalRig&) = delete;

  const std::string& address() const;
  /// Why the rig serves no more, or nothing.
  std::string failure() const;

 private:
  struct Impl;
  std::unique_ptr<Impl> impl_;
};

}  // namespace powbench::rigs
