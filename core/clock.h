#pragma once

namespace powbench {

/// Time as the host's programs see it: whatever waits, or limits a wait, is given one of these. A test hands in a clock
/// of its own, and nothing in it depends on the speed of the machine.
class Clock {
 public:
  virtual ~Clock() = default;
  virtual double now() const = 0;          ///< s since a fixed instant; never runs back
  virtual void sleep(double seconds) = 0;  ///< returns when so much time has passed; at once for 0 or less
};

}  // namespace powbench
