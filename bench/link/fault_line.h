#pragma once

#include <cstdint>
#include <memory>
#include <string>

/// A line between a client and a rig that does one wrong thing at one byte, on request. Which thing, which direction and
/// which byte follow from a seed, so that a seed that fails is a test case.

namespace powbench::bench {

struct LineFault {
  enum class Kind : std::uint8_t {
    none,
    flip,       ///< one bit of the byte
    drop,       ///< the byte is swallowed
    close,      ///< both sides are closed behind the byte
    delay,      ///< the byte and what follows come 20 ms later
    stall,      ///< the byte and what follows come later than the client waits
    half_open,  ///< from the byte on nothing passes either way, and nobody is told
  };
  static constexpr int kinds = 7;

  Kind kind = Kind::none;
  bool to_rig = false;     ///< direction
  std::uint64_t byte = 0;  ///< from the moment the fault is set, in that direction, over all connections
  int bit = 0;
};
const char* name(LineFault::Kind);

/// Forwards bytes between loopback addresses, in one thread; ends with the object.
class FaultLine {
 public:
  /// To the rig at `target`; `stall_ms`: what a stall lasts.
  FaultLine(std::string target, int stall_ms);
  ~FaultLine();
  FaultLine(const FaultLine&) = delete;
  FaultLine& operator=(const FaultLine&) = delete;

  const std::string& address() const;
  /// Starts counting bytes anew. Connections that an earlier fault has left half open are closed.
  void set(const LineFault&);
  /// Bytes that have passed since then.
  std::uint64_t passed(bool to_rig) const;
  /// The fault has happened.
  bool struck() const;

 private:
  struct Impl;
  std::unique_ptr<Impl> impl_;
};

}  // namespace powbench::bench
