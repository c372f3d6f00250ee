#pragma once

#include <cstdint>
#include <functional>
#include <span>
#include <vector>

#include "sim/team.h"

/// Global search over the unit cube for functions with many minima and jumps.

namespace powbench::sim {

struct Candidate {
  std::vector<double> point;  ///< coordinates in [0, 1]
  double value = 0;
};

/// Success-history adaptive differential evolution with a population that shrinks linearly (L-SHADE). Every trial of a
/// generation depends on the seed, the generation and its own number alone, so the result does not depend on the number
/// of threads, and a search can be stopped after any generation and gone on with.
/// Source: R. Tanabe, A. Fukunaga, IEEE Congress on Evolutionary Computation 2014, 1658-1665.
class Evolution {
 public:
  /// Cost of a point; may stop early and return any value above `give_up` as soon as it is sure to exceed that.
  using Cost = std::function<double(std::span<const double> point, double give_up)>;

  /// The cost of many points, each with its own limit: for costs that share their work.
  using Costs = std::function<std::vector<double>(std::span<const std::vector<double>> points,
                                                  std::span<const double> give_up, Team&)>;

  struct Settings {
    std::size_t dimension = 0;
    long evaluations = 10'000;   ///< in all
    std::size_t population = 0;  ///< at the start; 0: 5 for each dimension, at least 20
    std::size_t smallest = 8;    ///< population at the end
    std::uint64_t seed = 1;
  };

  /// All there is to know to go on.
  struct State {
    std::vector<Candidate> population;  ///< ascending by value
    std::vector<std::vector<double>> archive;
    std::vector<double> memory_scale, memory_crossing;
    std::size_t memory_next = 0;
    std::uint64_t generation = 0;
    long used = 0;  ///< evaluations
  };

  /// `start` points take the first places of the population; the rest is spread over the cube.
  Evolution(Settings, Costs, std::vector<std::vector<double>> start = {});
  Evolution(Settings, Cost, std::vector<std::vector<double>> start = {});

  /// One generation. False when the evaluations are used up.
  bool step(Team&);

  const State& state() const { return state_; }
  void resume(State state) { state_ = std::move(state); }
  const Candidate& best() const { return state_.population.front(); }

 private:
  struct Trial {
    Candidate candidate;
    double scale = 0, crossing = 0;
  };
  void begin(Team&);
  Trial trial_for(std::size_t k) const;
  void learn(const std::vector<Trial>& better, const std::vector<double>& gain);
  void shrink();

  Settings settings_;
  Costs costs_;
  std::vector<std::vector<double>> start_;
  State state_;
};

}  // namespace powbench::sim
