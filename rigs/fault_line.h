#pragma once

#include <cstdint>
#include <memory>
#include <string>

/// A line between a client and a rig that does one wrong thing at one byte, on request: once, or again and again. Which
/// thing, which direction and which byte follow from a seed, so that a seed that fails is a test case.

namespace powbench::rigs {

struct LineFault {
  enum class Kind : std::uint8_t {
    none,
    flip,       ///< one bit of the byte
    drop,       ///< the byte is swallowed
    close,      ///< both sides are closed behind the byte
    delay,      ///< the byte and what follows come 20 ms later
    stall,      ///< the same, far later
    half_open,  ///< from the byte on nothing passes either way, without any error
  };
  static constexpr int kinds = 7;

  Kind kind = Kind::none;
  bool to_rig = false;     ///< direction
  std::uint64_t byte = 0;  ///< from the moment the fault is set, in that direction, over all connections
  int bit = 0;
};
const char* name(LineFault::Kind);

/// A line that is bad all the time.
struct BadLine {
  std::uint64_t seed = 0;     ///< 0: a good one
  double mean_bytes = 200e3;  ///< of one direction, from one fault to the next, on average
};

inline constexpr int bad_line_stall_ms = 450;  ///< what a stall on it lasts

/// Forwards bytes between loopback addresses, in one thread; ends with the object.
class FaultLine {
 public:
  /// From `address`, or where that is empty from the first free loopback address of 127.0.2.0, to the rig at `target`;
  /// `stall_ms`: what a stall lasts. Throws std::runtime_error, in one sentence, when the address cannot be had.
  FaultLine(std::string target, int stall_ms, const BadLine& = {}, const std::string& address = {});
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

}  // namespace powbench::rigs
