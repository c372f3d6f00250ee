#pragma once

#include <array>
#include <cstdint>

#include "firmware/phase_predictor.h"

/// Which memory the mains of this moment wants, and how far its prediction can be trusted.

namespace powbench::firmware {

/// Deviations in turns from newest phase + step x updates.
struct BankSay {
  float now = 0, ahead = 0;  ///< at the two places asked for
  float rate = 0;            ///< turns an update^2
  float variance_now = 0;    ///< turns^2, squares of the standard uncertainties
  float variance_ahead = 0;
  bool broken = false;  ///< so far from what was said lately that the mains must have made a step
};

/// Model: the phase is a polynomial of first or second order over a memory whose length is not known, with an error
/// that is stationary over some tenths of a second. Each predictor (phase_predictor.h) says what the phase will be now
/// and 20 ms ahead; when the window has come there, its error is known. The predictions are averaged with the weights
/// (least mean square / own mean square)^4. A mains at rest is so followed with a long memory, a moving one with a
/// short one, and neither is told by a limit.
///
/// Innovation test: a memory that does not expect the newest cycle where it is (beyond three times what is usual for
/// it) loses weight at once, before its errors are known.
///
/// Variance: the weighted mean square of the errors seen, less the variance of the windows themselves (from third
/// differences, which no smooth movement enters: var = 16 var(window)), at least 0.13 of it; 20 ms ahead no more is
/// taken off than what the relative amplitudes, in rad, vary by. And 0.35 (revision)^2 when what is said of one instant
/// has been revised within 5, 10 or 20 ms by more than is usual.
class PhaseBank {
 public:
  static constexpr int fewest = 18;  ///< phases a prediction is judged from

  void reset();
  /// The windows swing to and fro from cycle to cycle: a tone about half an order beside the fundamental is in the
  /// errors that are seen.
  bool swings() const { return swings_; }
  /// Next phase of two cycles.
  void push(PhaseWord phase) {
    history_.push(phase, phase);
    judge();
  }
  /// While a window spans a change: `expected` stands in for what was seen.
  void push_expected(PhaseWord expected, PhaseWord seen) { history_.push(expected, seen); }
  /// The phase of one cycle that belongs `after` updates behind the newest of two cycles.
  void push_late(PhaseWord phase, int after);
  /// The windows had the wrong length: what one cycle said until now does not count.
  void forget_late() { history_.late_count = 0; }
  /// `clean`: phases that belong to the mains as it is now. `step`: reference frequency, 2^-32 turns an update. `now`,
  /// `ahead`: updates from the newest phase to now and to 20 ms ahead, < 48. Once an update.
  BankSay say(int clean, PhaseWord step, int now, int ahead);
  /// The newest `count` phases were seen behind a change and differ from what stands in for them by `level` + `slope`
  /// (i - middle), turns, about which their mean square is `around`, turns^2 (below 0: none). They take their places;
  /// is the slope none, the memory before them moves by the level. False: there is a slope, and the memory before them
  /// does not fit.
  bool resume(float level, float slope, int count, float around);
  /// Amplitude of the newest window of two cycles, any unit.
  void note_amplitude(float amplitude) {
    amplitude_[static_cast<std::uint32_t>(history_.newest) % phase_memory] = amplitude;
  }
  /// Something has happened to the mains: predictions made before are not judged, and what the last ones erred by
  /// does not count.
  void event();

 private:
  /// Every second place is predicted and judged: neighbouring windows share 39 of 40 ms.
  static constexpr std::uint32_t slots = 32, said_slots = 32;
  static constexpr std::uint32_t mixed = predictor_count;  ///< index of the average's own errors
  /// Mean square of errors, turns^2.
  struct Track {
    float slow = 0, fast = 0;
    float count = 0;  ///< saturates

    float worse() const { return slow > fast ? slow : fast; }
    /// The larger one less a share of what it exceeds the recent one by.
    float expected(float recent_share) const { return worse() - recent_share * (worse() - fast); }
    void add(float square);
  };
  struct Usual {
    float mean_square = 0, count = 0;
  };
  using Tracks = std::array<std::array<Track, predictor_count + 1>, 2>;
  /// What was said at an update: the curve about its place 20 ms ahead.
  struct Said {
    PhaseWord ahead = 0;
    PhaseWord step = 0;
    float slope = 0, bend = 0;  ///< less the reference; turns an update, turns an update^2
    std::int32_t place = 0;
  };

  void judge();
  float swing_share() const;
  void judge(std::int32_t place, PhaseWord phase);
  void note_scatter();
  void weigh(const Predictions&, bool judged);
  float variance(unsigned horizon) const;
  void revise(BankSay&, Said said, bool long_known);
  void note_predictions(const Predictions&, PhaseWord base, unsigned horizon, float average,
                        std::int32_t place);
  void forget_predictions();
  void keep_tracks();

  PhaseHistory history_;
  PhaseWord step_ = 1U << 26;         ///< reference frequency of the last estimate, 2^-32 turns an update ...
  std::array<float, 32> swing_of_{};  ///< windows less the mean of those half a cycle off, turns
  float swing_ = 0;                   ///< mean square of what turns its sign within a cycle, turns^2
  bool swings_ = false;
  float swing_square_ = 0, swing_across_ = 0;  ///< mean products of a swing with itself, and half a cycle ago
  float bend_ = 0;                             ///< ... and its rate, turns an update^2
  /// What was predicted for one place.
  struct Predicted {
    PhaseWord mixed = 0;
    std::array<std::int16_t, predictor_count>
        less{};               ///< prediction less the average, 2^-22 turns, saturates at 2.8 deg
    std::uint16_t known = 0;  ///< which stand there, one bit each
  };
  Predicted& predicted(unsigned horizon, std::int32_t place) {
    return predicted_[horizon][static_cast<std::uint32_t>(place) / 2 % slots];
  }
  std::array<std::array<Predicted, slots>, 2> predicted_{};
  Tracks track_{};
  std::array<Tracks, 2> kept_{};  ///< older states of track_, 32 .. 64 updates
  int since_kept_ = 0;            ///< -1: within an event
  std::array<Usual, predictor_count> innovation_{};
  std::array<float, predictor_count> weight_{};  ///< sum 1
  std::array<float, 2> expected_{};              ///< weighted mean squares, turns^2
  std::array<float, phase_memory> amplitude_{};
  float phase_scatter_ = 0, amplitude_scatter_ = 0;  ///< variances of a window of two cycles, turns^2
  float scatter_count_ = 0;
  int since_joint_ = 0;  ///< updates since windows took the place of what stood in for them, saturates
  std::array<Said, said_slots> said_{};
  int said_count_ = 0;
  std::array<float, 3> revision_{};  ///< usual mean squares, turns^2
  float alarm_ = 0;                  ///< turns^2
  float level_doubt_ = 0;            ///< turns^2, of the level behind a change
};

}  // namespace powbench::firmware
