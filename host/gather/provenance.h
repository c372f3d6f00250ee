#pragma once

#include <map>
#include <string>
#include <vector>

#include "host/report/report.h"
#include "host/store/store.h"

/// Where the shots of a report come from, and in which order they were fired.

namespace powbench::host {

/// Program, rig, and every calibration with the shots that were measured under it. `fired` as `by_firing` gives it.
Provenance rig_provenance(const Store&, const std::vector<StoredShot>& fired);

/// The measured shots in the order in which they were fired, then the simulated ones.
std::vector<StoredShot> by_firing(std::vector<StoredShot>);

/// How the attempts before the last one ended, by the number of the measured shot.
std::map<int, std::vector<Outcome>> earlier_outcomes(const Store&, std::int64_t campaign);

/// What the rig knew of the mains' phase when it fired, rad; NaN: nobody has told.
double phase_deviation(const Store&, const StoredShot&);

}  // namespace powbench::host
