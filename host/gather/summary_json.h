#pragma once

#include <string>

#include "host/report/report.h"

namespace powbench::host {

/// What the first page of the report answers, for machines: campaign, origin, verdict and its reason, counts, the
/// best closing angle, how many comparisons differ and the largest, instruments whose calibration had expired, the
/// course. JSON, SI units; what is not known is null.
std::string summary_json(const ReportInput&);

}  // namespace powbench::host
