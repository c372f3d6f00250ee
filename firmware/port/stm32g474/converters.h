#pragma once

#include <array>
#include <cstdint>

#include "firmware/port/common/scan_queue.h"
#include "firmware/port/stm32g474/board.h"

namespace powbench::firmware::stm32g474 {

/// The five converters, their buffers and the timer that triggers them all.
class Converters {
 public:
  using Queue = port::BlockQueue<block_samples, queue_blocks>;

  /// Pins, calibration, buffers. Conversions begin with start_sampling().
  void set_up();

  /// To be called when the last converter's buffer is half full or full: puts the block into the queue, with the
  /// alarms of that time. False when samples were lost.
  bool collect(Queue& queue, const port::Alarms& alarms);

  /// Samples collected or lost since the start: the newest one was triggered less than 2^16 ticks ago while collect()
  /// is called in time.
  std::int64_t samples() const { return samples_; }

 private:
  static constexpr std::size_t half_values = 2 * block_samples;  // of a converter with two ranks
  bool all_there(std::uint32_t flag_of_first) const;

  std::array<std::array<volatile std::uint16_t, 2 * half_values>, converters> buffers_{};
  port::HalfOrder order_;
  std::int64_t samples_ = 0;
};

/// Starts the gate timer and, with it, the sampling timer: from here on sample k is triggered at tick
/// time_base.ticks({k}).
void start_sampling();

}  // namespace powbench::firmware::stm32g474
