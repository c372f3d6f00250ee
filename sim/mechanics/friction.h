#pragma once

#include <cmath>
#include <cstdint>

namespace powbench::sim {

/// Coulomb friction of one body, as a mode: it sticks while what drives it is at most the limit, else it slides in the
/// direction of what drove it until its speed is zero again. Within a mode all is smooth, also where a step of the
/// integrator overshoots.
template <class Real>
class CoulombFriction {
 public:
  CoulombFriction() = default;
  /// `limit` N; 0: none.
  explicit CoulombFriction(Real limit) : limit_(limit), mode_(limit > 0 ? Mode::stick : Mode::none) {}

  bool sticks() const { return mode_ == Mode::stick; }
  bool slides() const { return mode_ == Mode::forward || mode_ == Mode::backward; }
  bool slides_forward() const { return mode_ == Mode::forward; }

  Real force() const { return force_; }  ///< N, on a body that slides
  /// What accelerates a body, N.
  Real net(Real driving) const { return sticks() ? Real(0) : driving + force_; }
  Real loss(Real speed) const { return -force_ * speed; }  ///< W

  /// Above zero as long as the mode holds; `driving()` N is asked for only where the body sticks.
  template <class Driving>
  Real guard(Real speed, const Driving& driving) const {
    if (sticks()) return limit_ - std::fabs(driving());
    return slides() ? way() * speed : Real(1);
  }
  /// Of the guard, for the acceleration of a body that slides.
  Real guard_rate(Real acceleration) const { return slides() ? way() * acceleration : Real(0); }

  /// The mode that begins where the speed is zero.
  void choose(Real driving) {
    const bool stays = std::fabs(driving) <= limit_;
    mode_ = stays ? Mode::stick : driving > 0 ? Mode::forward : Mode::backward;
    force_ = stays ? Real(0) : -way() * limit_;
  }

 private:
  enum class Mode : std::uint8_t { none, stick, forward, backward };
  Real way() const { return mode_ == Mode::backward ? Real(-1) : Real(1); }

  Real limit_ = 0;
  Real force_ = 0;
  Mode mode_ = Mode::none;
};

}  // namespace powbench::sim
