#pragma once

#include <array>
#include <cstdint>

/// Polynomials through the newest phases: memories from 10 ms to half a second.

namespace powbench::firmware {

/// Turns as a fraction of 2^32: differences wrap by themselves.
using PhaseWord = std::uint32_t;

/// The nearest difference, [-0.5, 0.5) turns.
inline float to_turns(PhaseWord difference) {
  return static_cast<float>(static_cast<std::int32_t>(difference)) * 0x1p-32F;
}
/// Range: any; one turn wraps to 0.
PhaseWord to_word(float turns);

/// One memory: the newest `points` phases, each `stride` updates apart.
struct PhasePredictor {
  bool late;    ///< of the windows of one cycle; else of those of two cycles
  int stride;   ///< updates
  int points;   ///< number of phases
  int order;    ///< of the polynomial: 1 or 2
  float doubt;  ///< turns^2: what it errs by 20 ms ahead on the quietest mains (the shorter the more)
};

/// Sorted by series (late, stride), then by points: one pass over a series serves all its memories.
inline constexpr std::array<PhasePredictor, 13> phase_predictors = {{{true, 1, 10, 2, 5e-8F},
                                                                     {true, 1, 16, 2, 1e-8F},
                                                                     {true, 1, 32, 2, 2e-9F},
                                                                     {false, 1, 18, 1, 1e-10F},
                                                                     {false, 1, 18, 2, 2e-9F},
                                                                     {false, 1, 40, 1, 1e-11F},
                                                                     {false, 1, 40, 2, 2e-10F},
                                                                     {false, 1, 64, 1, 1e-11F},
                                                                     {false, 1, 64, 2, 1e-10F},
                                                                     {false, 8, 16, 2, 1e-11F},
                                                                     {false, 8, 24, 1, 1e-11F},
                                                                     {false, 8, 32, 2, 1e-11F},
                                                                     {false, 8, 64, 1, 1e-11F}}};
inline constexpr int predictor_count = static_cast<int>(phase_predictors.size());
inline constexpr int phase_memory = 64;  ///< phases that are remembered of each series
inline constexpr int long_stride = 8;    ///< updates between those of the sparse series

/// The phases that are remembered: on a grid of one update, and of eight.
struct PhaseHistory {
  std::array<PhaseWord, phase_memory> phase{};
  std::array<PhaseWord, phase_memory> sparse{};  ///< at the places that are multiples of long_stride
  std::array<PhaseWord, phase_memory> late{};
  std::array<PhaseWord, 32> seen{};
  std::int32_t newest = 0;       ///< place of the newest of two cycles
  std::int32_t newest_late = 0;  ///< place of the newest of one cycle
  int late_count = 0;            ///< of one cycle, whose windows had the length of a cycle; saturates

  PhaseWord at(std::int32_t place) const { return phase[static_cast<std::uint32_t>(place) % phase_memory]; }
  PhaseWord late_at(std::int32_t place) const {
    return late[static_cast<std::uint32_t>(place) % phase_memory];
  }
  /// What was seen of the newest `count` phases takes the place of what stood in for it; all before moves by `level`.
  /// Those of one cycle are forgotten.
  void take_seen(int count, PhaseWord level);
  /// `word`: phase, or what stands in for the phase that was `seen` while that does not count.
  void push(PhaseWord word, PhaseWord what_was_seen) {
    ++newest;
    phase[static_cast<std::uint32_t>(newest) % phase_memory] = word;
    seen[static_cast<std::uint32_t>(newest) % seen.size()] = what_was_seen;
    if (newest % long_stride == 0)
      sparse[static_cast<std::uint32_t>(newest / long_stride) % phase_memory] = word;
  }
};

/// What the predictors say. Deviations in turns from newest phase + step x updates.
struct Predictions {
  std::uint32_t usable = 0;                                ///< one bit each
  std::array<std::array<float, predictor_count>, 2> at{};  ///< at the two places asked for
  std::array<float, predictor_count> bend{};               ///< second derivative, turns an update^2
  std::array<float, predictor_count> late_error{};  ///< newest phase of one cycle less the polynomial there
};

/// All memories that fit into the newest `clean` phases; with fewer than the shortest takes that one. `step`: reference
/// frequency, 2^-32 turns an update. `reach`: updates from the newest phase of two cycles to the places asked for.
/// Least squares of a + b q1(u) + c q2(u), q1, q2 orthogonal on the even grid u = 0, -1 .. -(n - 1).
Predictions predict(const PhaseHistory&, int clean, PhaseWord step, const std::array<int, 2>& reach);

}  // namespace powbench::firmware
