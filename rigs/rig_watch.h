#pragma once

#include <chrono>
#include <memory>
#include <string>

#include "rigs/rig.h"

namespace powbench::rigs {

/// What a rig says of itself at one moment, in its own words.
struct RigStatus {
  std::string state;       ///< idle, armed, firing, captured or fault
  std::string fault;       ///< number and name of the latched fault, or "0 none"
  std::string phase;       ///< of the mains
  std::string owner;       ///< who has the lease, or "free"
  std::string last_error;  ///< why the rig last refused or tripped

  /// The coil is on, or could be without another command of its owner.
  bool live() const { return state == "armed" || state == "firing"; }
  bool operator==(const RigStatus&) const = default;
};

/// A second line to a rig, for whoever looks on. It takes no lease and can do one thing: switch the coil off. One thread at a time.
class RigWatch {
 public:
  /// Throws RigError within `limit`. `request`: time for one answer.
  explicit RigWatch(const std::string& uri, std::chrono::milliseconds limit,
                    std::chrono::milliseconds request = std::chrono::milliseconds(1000));
  ~RigWatch();
  RigWatch(const RigWatch&) = delete;
  RigWatch& operator=(const RigWatch&) = delete;

  // each throws RigError: the line is of no use any more
  RigInfo info();
  RigStatus status();
  std::string state();
  /// Coil off, whoever owns the rig. The rig has taken the command; state() tells what came of it.
  void stop();

 private:
  struct Impl;
  std::unique_ptr<Impl> impl_;
};

}  // namespace powbench::rigs
