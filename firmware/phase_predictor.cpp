#include "firmware/phase_predictor.h"

#include "firmware/math.h"

namespace powbench::firmware {

namespace {

/// What follows from the number of points: their middle and the inverse sums of squares of the polynomials.
struct Grid {
  float middle;  ///< (n - 1) / 2
  float spread;  ///< mean square distance from the middle, (n^2 - 1) / 12
  float mean;    ///< 1 / n
  float slope;   ///< 1 / (n spread)
  float curve;   ///< 180 / (n (n^2 - 1) (n^2 - 4))
  float stride;  ///< 1 / stride
};

constexpr Grid grid(const PhasePredictor& p) {
  const auto n = static_cast<float>(p.points);
  const float spread = (n * n - 1.0F) / 12.0F;
  return {0.5F * (n - 1.0F),
          spread,
          1.0F / n,
          1.0F / (n * spread),
          p.order < 2 ? 0.0F : 180.0F / (n * (n * n - 1.0F) * (n * n - 4.0F)),
          1.0F / static_cast<float>(p.stride)};
}

constexpr auto grids = [] {
  std::array<Grid, phase_predictors.size()> list{};
  for (std::size_t p = 0; p < list.size(); ++p) list[p] = grid(phase_predictors[p]);
  return list;
}();

/// Sums of d, i d and i^2 d over the newest points; i counts backwards from 0.
struct Moments {
  float zeroth = 0, first = 0, second = 0;
};

class Pass {
 public:
  Pass(const PhaseHistory& history, const PhasePredictor& series, PhaseWord step)
      : words_(series.late          ? history.late.data()
               : series.stride != 1 ? history.sparse.data()
                                    : history.phase.data()),
        newest_(series.late ? history.newest_late : history.newest / series.stride * series.stride),
        place_(static_cast<std::uint32_t>(newest_ / series.stride)),
        reference_(history.at(history.newest) + step * static_cast<std::uint32_t>(newest_ - history.newest)),
        step_(step * static_cast<std::uint32_t>(series.stride)) {}

  std::int32_t newest() const { return newest_; }

  /// Goes on to `points` points.
  const Moments& up_to(int points) {
    for (; done_ < points; ++done_) {
      const float d = to_turns(words_[place_ % phase_memory] - reference_);
      sums_.zeroth += d;
      sums_.first += index_ * d;
      sums_.second += index_ * index_ * d;
      index_ += 1.0F;
      --place_;
      reference_ -= step_;
    }
    return sums_;
  }

 private:
  const PhaseWord* words_;
  std::int32_t newest_;
  std::uint32_t place_;
  PhaseWord reference_, step_;
  int done_ = 0;
  float index_ = 0;
  Moments sums_;
};

}  // namespace

PhaseWord to_word(float turns) {
  return static_cast<PhaseWord>(static_cast<std::int32_t>(wrap_half(turns) * 4294967296.0F));
}

void PhaseHistory::take_seen(int count, PhaseWord level) {
  late_count = 0;
  if (count > static_cast<int>(seen.size())) count = static_cast<int>(seen.size());
  for (std::int32_t i = 0; i < phase_memory; ++i) {
    const auto place = static_cast<std::uint32_t>(newest - i);
    PhaseWord& word = phase[place % phase_memory];
    word = i < count ? seen[place % seen.size()] : word + level;
  }
  const std::int32_t first = newest / long_stride;
  for (std::int32_t i = 0; i < phase_memory; ++i) {
    PhaseWord& word = sparse[static_cast<std::uint32_t>(first - i) % phase_memory];
    const std::int32_t age = newest - (first - i) * long_stride;
    word = age < count ? at(newest - age) : word + level;
  }
}

Predictions predict(const PhaseHistory& history, int clean, PhaseWord step, const std::array<int, 2>& reach) {
  constexpr unsigned shortest = 3;
  Predictions out;
  const std::int32_t after = history.newest_late - history.newest;
  const float late = to_turns(history.late_at(history.newest_late) - history.at(history.newest) -
                              step * static_cast<std::uint32_t>(after));
  for (unsigned first = 0; first < phase_predictors.size();) {
    const PhasePredictor& series = phase_predictors[first];
    Pass pass(history, series, step);
    const auto offset = static_cast<float>(pass.newest() - history.newest);
    const int there = series.late && history.late_count < clean ? history.late_count : clean;
    unsigned p = first;
    for (; p < phase_predictors.size() && phase_predictors[p].late == series.late &&
           phase_predictors[p].stride == series.stride;
         ++p) {
      if (phase_predictors[p].points * phase_predictors[p].stride > there && p != shortest) continue;
      const Moments& m = pass.up_to(phase_predictors[p].points);
      const Grid& g = grids[p];
      const float mean = m.zeroth * g.mean;
      const float slope = (g.middle * m.zeroth - m.first) * g.slope;
      const float curve =
          (m.second - 2.0F * g.middle * m.first + (g.middle * g.middle - g.spread) * m.zeroth) * g.curve;
      const auto value = [&](float updates) {
        const float u = updates * g.stride + g.middle;
        return mean + slope * u + curve * (u * u - g.spread);
      };
      out.usable |= 1U << p;
      out.at[0][p] = value(static_cast<float>(reach[0]) - offset);
      out.at[1][p] = value(static_cast<float>(reach[1]) - offset);
      out.bend[p] = 2.0F * curve * g.stride * g.stride;
      out.late_error[p] = late - value(static_cast<float>(after) - offset);
    }
    first = p;
  }
  return out;
}

}  // namespace powbench::firmware
