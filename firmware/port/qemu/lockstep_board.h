#pragma once

#include <array>
#include <optional>

#include "firmware/bench.h"
#include "firmware/port/qemu/frame.h"

/// The board's end of the lock-step: takes frames, runs the bench, answers. No input or output of its own, so
/// that it can be tested anywhere.

namespace powbench::firmware::lockstep {

/// What the processor gives it.
class Platform {
 public:
  /// Sends one frame.
  virtual void send(std::span<const std::uint8_t> frame) = 0;
  /// Runs one block in interrupt context; the edges stay valid until the next one.
  virtual std::span<const GateEdge> run_block(Bench&, const Block&, bool measure) = 0;
  virtual Cost cost() const = 0;

 protected:
  ~Platform() = default;
};

class LockstepBoard {
 public:
  /// `storage`: memory for records; `out`: for the frame that leaves, largest_frame bytes.
  LockstepBoard(Platform& platform, std::span<std::int16_t> storage, std::span<std::uint8_t> out)
      : platform_(platform), storage_(storage), out_(out) {}
  LockstepBoard(const LockstepBoard&) = delete;
  LockstepBoard& operator=(const LockstepBoard&) = delete;

  /// Handles one frame of `frame_length` bytes. False: it was refused, and the board must stop.
  bool handle(std::span<const std::uint8_t> frame);
  /// Tells the other end that what it sent is no frame.
  void refuse(Refused why);

 private:
  class Sender;
  bool configure(Reader&);
  bool step(Reader&);
  void protocol(Reader&, Sender&);
  void answer(Sender&, bool with_cost);

  Platform& platform_;
  std::span<std::int16_t> storage_;
  std::span<std::uint8_t> out_;
  std::array<char, 512> texts_{};
  std::optional<Bench> bench_;
  std::array<GateEdge, 2 * largest_batch> edges_{};  ///< of the frame in progress
  std::uint16_t edge_count_ = 0;
  std::uint32_t expected_ = 0;  ///< sequence number of the next frame
};

}  // namespace powbench::firmware::lockstep
