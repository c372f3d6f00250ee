#pragma once

#include <array>
#include <cstddef>
#include <cstdint>

/// How often and how long the coil may be energised. 0 switches a limit off.

namespace powbench::firmware {

struct BudgetConfig {
  std::int64_t operations_per_minute = 0;  ///< 0 .. DutyBudget::most_operations
  std::int64_t pause_samples = 0;          ///< least time from the gate's off edge to the next arm
  std::int64_t heat_samples = 0;           ///< energised time that a cold coil stands
  std::int64_t duty_per_mille = 0;         ///< share of time energised that it stands for ever
};

/// Heat is counted in energised samples: dh/dt = gate - duty, h >= 0. A shot is allowed if h + hold stays
/// within `heat_samples`.
class DutyBudget {
 public:
  static constexpr std::size_t most_operations = 64;
  enum class Verdict : std::uint8_t { ready, pause, too_many, too_hot };

  /// Time passes, energised or not.
  void advance(const BudgetConfig& c, std::int64_t samples, bool energised) {
    heat_mille_ += samples * ((energised ? 1000 : 0) - c.duty_per_mille);
    if (heat_mille_ < 0) heat_mille_ = 0;
  }

  void note_operation(std::int64_t sample) {
    starts_[next_] = sample;
    next_ = (next_ + 1) % most_operations;
    if (count_ < most_operations) ++count_;
  }

  Verdict judge(const BudgetConfig& c, std::int64_t now, std::int64_t off_since, std::int64_t hold,
                std::int64_t minute) const {
    if (count_ > 0 && now - off_since < c.pause_samples) return Verdict::pause;
    const auto most = static_cast<std::size_t>(c.operations_per_minute);
    if (most > 0 && count_ >= most &&
        now - starts_[(next_ + most_operations - most) % most_operations] < minute)
      return Verdict::too_many;
    if (c.heat_samples > 0 && heat_mille_ + hold * 1000 > c.heat_samples * 1000) return Verdict::too_hot;
    return Verdict::ready;
  }

 private:
  std::array<std::int64_t, most_operations> starts_{};
  std::size_t next_ = 0, count_ = 0;
  std::int64_t heat_mille_ = 0;
};

}  // namespace powbench::firmware
