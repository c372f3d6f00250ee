#pragma once

#include <algorithm>
#include <cmath>
#include <cstdint>
#include <limits>
#include <string>
#include <vector>

#include "sim/supply/coil_switch.h"
#include "sim/supply/mains.h"
#include "sim/supply/suppression.h"

/// The supply as modes of a system that is integrated: what holds now, when the next change is due, and what ends it.

namespace powbench::sim {

/// What feeds the coil.
struct Supply {
  Mains mains;
  CoilSwitch coil_switch{};
  Suppression suppression{};
};
/// Parts that do not go together, in one sentence that begins with section and key of the rig file; empty: none.
std::string unsuited(const Supply&);

/// Throws std::invalid_argument naming what is out of range or does not go together.
void require_valid(const Supply&);

/// What drives the coil: dpsi/dt = emf - (R + resistance) i with R of coil and source.
template <class Real>
struct CoilFeed {
  Real emf = 0;             ///< V, smooth
  Real resistance = 0;      ///< ohm, beside coil and source; below zero where the source is not in the path
  Real capacitor_rate = 0;  ///< V/s, of the voltage v_c of an RC suppression
  Real supplied = 0;        ///< W, by the source
  Real lost = 0;            ///< W, beside (R + resistance) i^2

  /// dpsi/dt, V, and what the circuit loses, W, at the current i with R ohm of coil and source.
  Real linkage_rate(Real ohm, Real i) const { return emf - (ohm + resistance) * i; }
  Real heat(Real ohm, Real i) const { return (ohm + resistance) * i * i + lost; }
};

/// Between two events the coil's current flows on a path, through the source or through the suppression, or there is
/// none, i = 0. Events are the commands, the changes that are due at next_change(), and the zeros of guard(). After
/// an event that returns `cut` or `blocked` the owner brings the current to zero, ring flux and places unchanged, and
/// books the energy that is gone. Rectifier and diode conduct from a voltage or current of `slack` on, so that
/// rounding switches nothing.
class SupplyModes {
 public:
  enum class Coil : std::uint8_t {
    open,
    closed,
    opening  ///< fed until the current has gone
  };
  enum class Path : std::uint8_t { none, source, suppression };
  enum class Effect : std::uint8_t {
    none,
    opened,  ///< at a zero of the current
    cut,     ///< with a current flowing
    blocked  ///< at a zero of the current, by a diode behind a closed switch
  };
  static constexpr double slack = 1e-9;  ///< A, V

  SupplyModes() = default;
  /// Throws std::invalid_argument for a supply that is not valid.
  explicit SupplyModes(const Supply&);

  const Mains& mains() const { return supply_.mains; }
  Coil coil() const { return coil_; }
  bool feeds() const { return path_ == Path::source; }
  bool conducts() const { return path_ != Path::none; }
  /// Nothing will come from the supply by itself: no path, or an RC suppression without source, whose current and
  /// voltage die out; no change of the switch ahead, no rectifier behind a closed one.
  bool sleeps() const {
    const bool rings_down = path_ == Path::suppression && has_capacitor() && coil_ == Coil::open;
    return (!conducts() || rings_down) && due_.empty() && !rectified_on();
  }
  bool has_capacitor() const { return supply_.suppression.kind == Suppression::Kind::rc; }
  double capacitance() const { return has_capacitor() ? supply_.suppression.capacitance : 0.0; }
  bool commanded() const { return commanded_; }

  /// Of the piece in force, V: smooth.
  template <class Real>
  Real voltage(Real t) const {
    return mains_voltage(supply_.mains, piece_, t);
  }
  /// Of a piece that is one sine in every bit: amplitude() sin(rate() t + phase()), V.
  bool one_sine() const {
    return std::all_of(supply_.mains.harmonics.begin(), supply_.mains.harmonics.end(),
                       [](const Harmonic& h) { return h.share == 0; });
  }
  double rate() const { return mains_rate<double>(supply_.mains); }
  double phase() const { return mains_phase<double>(supply_.mains, piece_); }
  double amplitude() const { return mains_amplitude<double>(supply_.mains, piece_); }
  /// At any time, V.
  double voltage_at(double t) const {
    return mains_voltage(supply_.mains, mains_piece(supply_.mains, t, origin_), t);
  }

  /// s; infinity: never.
  double next_change() const {
    return due_.empty() || piece_.end < due_.front().time ? piece_.end : due_.front().time;
  }

  /// While the coil's current flows, path() != none. `i` A, `capacitor` V.
  template <class Real>
  CoilFeed<Real> feed(Real t, Real i, Real capacitor) const;

  /// The voltage at the coil without current, dpsi/dt, may end the present mode: guard() wants it.
  bool watches_open_voltage() const { return path_ == Path::none && (diode() || rectified_on()); }
  /// Current, clock or open voltage may end the present mode: guard() is to be watched.
  bool watches() const {
    if (path_ == Path::none) return watches_open_voltage();
    if (path_ == Path::suppression) return !has_capacitor();
    return rectifies() || coil_ == Coil::opening || (coil_ == Coil::closed && latching_ > 0);
  }
  /// Above zero as long as `i` A, the clock and `open_voltage` V end no mode.
  template <class Real>
  Real guard(Real t, Real i, Real open_voltage) const;

  Effect command(double t, bool on, double current);
  /// All that is due up to `t`, and at least what is due next.
  Effect pass(double t, double current);
  /// guard() has become negative.
  Effect pass_guard(double t, double current);

 private:
  enum class Act : std::uint8_t { close, part };
  struct Change {
    double time;  ///< s
    Act act;
  };

  void schedule(double t);
  void close(double current);
  Effect part(double current);
  Effect pass_source(double t, double current);
  Effect leave_source(double current);
  void choose_path(double t, double current);
  bool alternates() const { return supply_.mains.kind == Mains::Kind::ac; }
  bool rectifies() const { return !alternates() && supply_.mains.kind != Mains::Kind::dc; }
  bool rectified_on() const { return rectifies() && coil_ == Coil::closed; }
  bool full_wave() const { return supply_.mains.kind == Mains::Kind::full_wave; }
  bool diode() const { return supply_.suppression.kind == Suppression::Kind::diode; }
  /// Behind the rectifier, V: of the pair of diodes that conducts, or of the one that could.
  template <class Real>
  Real behind(Real t, bool either) const {
    const Real u = voltage(t);
    if (!rectifies()) return u;
    const Real way = full_wave() ? (either ? std::fabs(u) : static_cast<Real>(turn_) * u) : u;
    return way - static_cast<Real>(supply_.mains.rectifier_drop);
  }
  /// Of the terminals over what the diode takes, V: below zero the diode carries the current.
  template <class Real>
  Real over_diode(Real t, Real i, bool either) const {
    return behind(t, either) - static_cast<Real>(supply_.mains.resistance) * i +
           static_cast<Real>(supply_.suppression.forward);
  }

  Supply supply_;
  MainsPiece piece_;
  double origin_ = std::numeric_limits<double>::infinity();  ///< s, first command
  std::vector<Change> due_;                                  ///< of the switch, in order of time
  Coil coil_ = Coil::open;
  Path path_ = Path::none;
  bool commanded_ = false;
  bool latched_ = false;
  double turn_ = 1;      ///< polarity of the mains that a full-wave rectifier passes on
  double sign_ = 1;      ///< of the current that is awaited to go
  double latching_ = 0;  ///< A, zero for all but the triac
  double holding_ = 0;   ///< A
};

template <class Real>
CoilFeed<Real> SupplyModes::feed(Real t, Real i, Real capacitor) const {
  const auto& s = supply_.suppression;
  const Real source = static_cast<Real>(supply_.mains.resistance), series = static_cast<Real>(s.resistance);
  CoilFeed<Real> f;
  if (path_ == Path::source) {
    const Real e = behind(t, false);
    f.emf = e;
    f.supplied = e * i;
    if (!has_capacitor()) return f;
    const Real ratio = source / series;
    f.emf = (e + ratio * capacitor) / (1 + ratio);
    f.resistance = source / (1 + ratio) - source;
    const Real beside = (f.emf - source / (1 + ratio) * i - capacitor) / series, all = i + beside;
    f.capacitor_rate = beside / static_cast<Real>(s.capacitance);
    f.supplied = e * all;
    f.lost = source * (all * all - i * i / (1 + ratio)) + series * beside * beside;
  } else if (has_capacitor()) {
    f.emf = capacitor;
    f.resistance = series - source;
    f.capacitor_rate = -i / static_cast<Real>(s.capacitance);
  } else {
    const Real sign = static_cast<Real>(sign_);
    const Real held = diode() ? static_cast<Real>(s.forward) : varistor_voltage(s, sign * i);
    f.emf = -sign * held;
    f.resistance = (diode() ? series : Real(0)) - source;
    f.lost = sign * held * i;
  }
  return f;
}

template <class Real>
Real SupplyModes::guard(Real t, Real i, Real open_voltage) const {
  constexpr Real some = static_cast<Real>(slack);
  Real g = 1;
  switch (path_) {
    case Path::none:
      if (rectified_on()) g = std::min(g, open_voltage - behind(t, true) + some);
      if (diode()) g = std::min(g, open_voltage + static_cast<Real>(supply_.suppression.forward));
      return g;
    case Path::suppression:
      if (!has_capacitor()) g = static_cast<Real>(sign_) * i;
      if (rectified_on()) g = std::min(g, some - over_diode(t, i, true));
      return g;
    case Path::source:
      break;
  }
  if (rectifies()) {
    g = i + some;
    if (full_wave()) g = std::min(g, static_cast<Real>(turn_) * voltage(t));
    if (diode()) g = std::min(g, over_diode(t, i, false) + some);
    return g;
  }
  if (coil_ == Coil::opening) return static_cast<Real>(sign_) * i - static_cast<Real>(holding_);
  if (coil_ != Coil::closed || latching_ == 0) return g;
  return latched_ ? static_cast<Real>(sign_) * i : static_cast<Real>(latching_) - std::fabs(i);
}

}  // namespace powbench::sim
