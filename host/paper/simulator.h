#pragma once

#include "core/conditions.h"
#include "host/paper/evaluate.h"
#include "sim/mechanics/bounce_study.h"
#include "sim/models/closing.h"
#include "sim/specimen/specimen.h"

/// The simulator as a source for the tables.

namespace powbench::host {

/// The view of a simulated closing. Contact times are those of the measured pole, which is closed when both its breaks
/// are; core bounce counts every arrival at the stop, however small the rebound; forces are those of break A.
PublishedView published_view(const sim::Trajectory&);

/// How far the bounces of that closing can be believed, at the tolerance the tables are simulated with.
sim::BounceStudyOptions published_bounce_options();
sim::BounceStudy published_bounces(const sim::Specimen&, double theta_deg, const Conditions& = {});

/// Simulates one closing per angle at `conditions` with the angle replaced. Keeps its own copies.
/// `specimen` must be valid: sim::simulate throws std::invalid_argument otherwise.
ClosingProvider simulator_provider(const sim::Specimen& specimen, const Conditions& conditions = {});

}  // namespace powbench::host
