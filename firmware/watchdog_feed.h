#pragma once

#include <array>
#include <atomic>
#include <cstddef>
#include <cstdint>

/// Who may feed the hardware watchdog: nobody alone.

namespace powbench::firmware {

/// Both interrupts, main loop and communication each report progress; feeding is allowed once all four have done
/// so since the last time. A part that hangs, or runs but never gets to its end, leads to a reset.
class WatchdogFeed {
 public:
  enum class Part : std::uint8_t { control_interrupt, background, main_loop, communication };
  static constexpr std::size_t parts = 4;

  /// To be called at the end of the part's round, from any context.
  void progress(Part part) { moved_[static_cast<std::size_t>(part)].store(true, std::memory_order_relaxed); }

  /// True when the port shall feed now; starts the next round. One caller only.
  bool may_feed() {
    for (const auto& part : moved_)
      if (!part.load(std::memory_order_relaxed)) return false;
    for (auto& part : moved_) part.store(false, std::memory_order_relaxed);
    return true;
  }

 private:
  std::array<std::atomic<bool>, parts> moved_{};
};

}  // namespace powbench::firmware
