#pragma once

#include <string>

#include "host/study/fit_file.h"
#include "sim/study/fit.h"
#include "sim/study/posterior.h"

/// A posterior or a search of a fit as a point (host/store/points.h): what it depends on, and its result, every bit
/// kept.

namespace powbench::host {

/// All that a posterior depends on but the program's version.
std::string basis_of(const sim::FitProblem&, const sim::PosteriorOptions&);
/// The same of a search. `start`: points it begins from.
std::string basis_of(const sim::FitProblem&, const sim::FitOptions&,
                     const std::vector<std::vector<double>>& start);

/// Misfit, members and bounce of a posterior.
std::string bytes_of(const FitFold&);
/// Throws StoreError for other bytes.
FitFold fold_of_bytes(const std::string&);

std::string bytes_of(const sim::FitResult&);
sim::FitResult result_of_bytes(const std::string&, const sim::Misfit&);

}  // namespace powbench::host
