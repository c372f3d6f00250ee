#pragma once

#include <functional>
#include <string>

#include "sim/study/evolution.h"
#include "sim/study/least_squares.h"
#include "sim/study/misfit.h"

/// Identification of a specimen from measured closings: a global search, because bounce times jump with every
/// parameter, then least squares from the best points found, then an ensemble of fits to shifted data.

namespace powbench::sim {

struct FitOptions {
  long evaluations = 20'000;   ///< of the global search
  std::size_t population = 0;  ///< at its start; 0: 5 for each free number
  int polished = 1;            ///< best points that least squares start from
  int ensemble = 12;           ///< members; 0: none
  std::uint64_t seed = 1;
  double tolerance = 1e-7;  ///< of the integrator in least squares
};

struct FitMember {
  std::vector<double> point;
  Specimen specimen;
  double misfit = 0;
};

struct FitResult {
  FitMember best;
  /// One fit each to data shifted by their deviations: how far the data let the specimen move.
  std::vector<FitMember> ensemble;
  Jacobian sensitivity;             ///< at `best`: `Misfit::per_closing` of each closing, in deviations
  Identifiability identifiability;  ///< from it and the prior
  long evaluations = 0;
  bool stopped = false;  ///< `go_on` said so: what there is by then
};

/// Hooks of the caller: where the search stands after each generation, and whether to go on.
struct FitWatch {
  std::function<bool(long used, long of, double best)> go_on;
  std::function<void(const Evolution::State&)> save;
};

/// `resume`: state of an interrupted global search. Reproducible for any number of threads.
FitResult fit(const Misfit&, const FitOptions&, Team&, const FitWatch& = {},
              const Evolution::State* resume = nullptr, std::vector<std::vector<double>> start = {});

}  // namespace powbench::sim
