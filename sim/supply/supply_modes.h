#pragma once

#include <cstdint>
#include <limits>
#include <vector>

#include "sim/supply/coil_switch.h"
#include "sim/supply/mains.h"

/// The supply as modes of a system that is integrated: what holds now, when the next change is due, and what ends it.

namespace powbench::sim {

/// What feeds the coil.
struct Supply {
  Mains mains;
  CoilSwitch coil_switch;
};
/// Throws std::invalid_argument naming what is out of range.
void require_valid(const Supply&);

/// Between two events the coil is fed, dpsi/dt = u(t) - R i with a smooth u, or it is not, i = 0. Events are the commands,
/// the changes that are due at next_change(), and the zeros of current_guard(). After an event that returns `cut` the
/// owner brings the current to zero, ring flux and places unchanged, and books the energy that is gone.
class SupplyModes {
 public:
  enum class Coil : std::uint8_t {
    open,
    closed,
    opening  ///< fed until the current has gone
  };
  enum class Effect : std::uint8_t {
    none,
    opened,  ///< at a zero of the current
    cut      ///< with a current flowing
  };

  SupplyModes() = default;
  /// Throws std::invalid_argument for a supply that is not valid.
  explicit SupplyModes(const Supply&);

  const Mains& mains() const { return supply_.mains; }
  Coil coil() const { return coil_; }
  bool feeds() const { return coil_ != Coil::open; }
  bool commanded() const { return commanded_; }
  /// The switch will change by itself, whatever the current.
  bool pending() const { return !due_.empty(); }

  /// Of the piece in force, V: smooth.
  template <class Real>
  Real voltage(Real t) const {
    return mains_voltage(supply_.mains, piece_, t);
  }
  /// At any time, V.
  double voltage_at(double t) const {
    return mains_voltage(supply_.mains, mains_piece(supply_.mains, t, origin_), t);
  }

  /// s; infinity: never.
  double next_change() const {
    return due_.empty() || piece_.end < due_.front().time ? piece_.end : due_.front().time;
  }

  /// The current may end the present mode: current_guard() is to be watched.
  bool watches_current() const { return coil_ == Coil::opening || (coil_ == Coil::closed && latching_ > 0); }
  /// Above zero as long as the current ends no mode.
  template <class Real>
  Real current_guard(Real i) const {
    if (!watches_current()) return 1;
    if (coil_ == Coil::opening) return static_cast<Real>(sign_) * i - static_cast<Real>(holding_);
    return latched_ ? static_cast<Real>(sign_) * i : static_cast<Real>(latching_) - std::fabs(i);
  }

  Effect command(double t, bool on, double current);
  /// All that is due up to `t`, and at least what is due next.
  Effect pass(double t, double current);
  /// The guard of the current has become negative.
  Effect pass_current(double current);

 private:
  enum class Act : std::uint8_t { close, part };
  struct Change {
    double time;  ///< s
    Act act;
  };

  void schedule(double t);
  void close(double current);
  Effect part(double current);

  Supply supply_;
  MainsPiece piece_;
  double origin_ = std::numeric_limits<double>::infinity();  ///< s, first command
  std::vector<Change> due_;                                  ///< of the switch, in order of time
  Coil coil_ = Coil::open;
  bool commanded_ = false;
  bool latched_ = false;
  double sign_ = 1;      ///< of the current that is awaited to go
  double latching_ = 0;  ///< A, zero for all but the triac
  double holding_ = 0;   ///< A
};

}  // namespace powbench::sim
