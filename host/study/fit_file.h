#pragma once

#include <optional>
#include <string>
#include <vector>

#include "sim/specimen/specimen.h"
#include "sim/study/bounce_calibration.h"
#include "sim/study/evolution.h"

/// What a fit leaves behind: specimens, and where an interrupted search stood.

namespace powbench::host {

/// One identification. `held_out`: the angle it has not seen, degrees; none: all were used.
struct FitFold {
  std::optional<double> held_out;
  double misfit = 0;
  /// Values of the free numbers in the units of the specimen file, eight digits; the best first, then the ensemble;
  /// of a posterior, its samples.
  std::vector<std::vector<double>> members;
  std::optional<sim::BounceCalibration>
      bounce{};  ///< of a posterior: from the closings it was conditioned on
};

struct FitFile {
  std::string base;                ///< specimen file (text) of the numbers that were not free
  std::vector<std::string> names;  ///< section.key of the free ones
  std::vector<FitFold> folds;
};

/// Specimens of a fold. Throws BadInput when the file's base or a name is not usable.
std::vector<sim::Specimen> specimens(const FitFile&, const FitFold&);

std::string to_json(const FitFile&);
/// Throws BadInput naming `file` when the text is not such a file.
FitFile parse_fit_file(const std::string& text, const std::string& file);
/// Throws BadInput also where the file cannot be read.
FitFile load_fit_file(const std::string& file);

/// A search that was stopped: the folds that are done and the state of the one that was running.
struct FitState {
  std::string problem;  ///< hash: a state of another problem is refused
  std::vector<FitFold> done;
  std::optional<sim::Evolution::State> running;
};
std::string to_json(const FitState&);
FitState parse_fit_state(const std::string& text, const std::string& file);

/// Eight significant digits: what a fit file keeps.
double rounded(double);
sim::BounceCalibration rounded(sim::BounceCalibration);

}  // namespace powbench::host
