#pragma once

#include <atomic>
#include <cstdint>

namespace powbench::firmware::port {

/// Whether the watchdog may be fed: only when every part that must live has moved since the last feed.
class Progress {
 public:
  enum Part : std::uint32_t { samples = 1, control = 2, background = 4, main_loop = 8, all = 15 };

  void moved(Part part) { seen_.fetch_or(part, std::memory_order_relaxed); }
  /// True at most once for each time that all parts have moved.
  bool may_feed() {
    if (seen_.load(std::memory_order_relaxed) != all) return false;
    seen_.store(0, std::memory_order_relaxed);
    return true;
  }

 private:
  std::atomic<std::uint32_t> seen_{0};
};

}  // namespace powbench::firmware::port
