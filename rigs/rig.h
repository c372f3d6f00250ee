#pragma once

#include <chrono>
#include <functional>
#include <memory>
#include <optional>
#include <stdexcept>
#include <string>
#include <string_view>
#include <utility>
#include <vector>

#include "core/conditions.h"
#include "core/outcome.h"
#include "core/record.h"

/// A rig as the host sees it: something that closes a contactor under given conditions and returns a record.

namespace powbench::rigs {

/// The rig cannot be reached, or its set-up is at fault. One sentence: what happened and what to do.
class RigError : public std::runtime_error {
  using std::runtime_error::runtime_error;
};

/// No such address of a rig: nothing was tried.
class UnknownRig : public RigError {
  using RigError::RigError;
};

/// What a rig says about itself.
struct RigInfo {
  std::string uri;
  std::string description;
  std::string model, serial, firmware, kind, boot_id;
  bool programmable_source = false;  ///< supply, frequency, ambient and seed can be set
  double sample_rate = 0.0;          ///< Hz
  std::string calibration;
  std::string configuration;  ///< checksum of rate, lengths, ranges and limits, as every sealed shot names it
  std::string calibration_expires;  ///< last day, 2030-12-31; "" = no certificate is stored
  std::string phase;                ///< of the mains at this moment, in words
  struct ChannelLine {
    std::string id, label, unit;
    double scale = 0.0;  ///< SI unit per count
  };
  std::vector<ChannelLine> channels;
};

/// How one shot ended. `record` is valid when outcome is pass; otherwise `reason` is one sentence.
struct Shot {
  Outcome outcome = Outcome::error;
  std::string reason;
  Record record;
  bool rig_lost = false;   ///< the connection broke: reconnect before the next shot
  bool interlock = false;  ///< the rig refused or tripped for safety
  bool latched = false;    ///< it stays in fault, and refuses every shot, until somebody acknowledges that
};

/// The reason of a shot that a stop kept from being fired.
inline constexpr std::string_view stopped_words = "stopped by the operator";

class Rig {
 public:
  virtual ~Rig() = default;
  virtual const RigInfo& info() const = 0;
  /// Arms, fires and reads one closing. A connection that breaks is made anew as long as `limit` allows, and a shot
  /// that was fired before that is fetched, not fired again. Returns within `limit` and a few seconds (the time-outs
  /// of one request and one connection); never throws for what a rig may do.
  virtual Shot fire(const Conditions&, std::chrono::milliseconds limit) = 0;
  /// `asked` is looked at while another owner is waited for, before a shot is armed and before it is fired: once it is
  /// true, nothing more is fired, and fire() gives ABORTED. Whoever makes it true before he stops the rig by another
  /// line knows that no shot follows. Empty: never.
  virtual void stop_when(std::function<bool()> asked) = 0;
  /// Coil off, whatever the state. False when the rig does not answer.
  virtual bool abort() = 0;
  /// Throws the connection away and makes a new one; false when that fails or another rig answers.
  virtual bool reconnect() = 0;
  /// After a reconnect: how the last shot ended whose outcome was left open when the connection broke. Nothing is fired
  /// that may have been fired before. Nothing: no shot was left open.
  virtual std::optional<Shot> recover(std::chrono::milliseconds limit) = 0;
};

}  // namespace powbench::rigs
