#pragma once

#include "host/compare/compare.h"
#include "host/compare/curves.h"
#include "host/config/plan_file.h"
#include "host/config/specimen_file.h"
#include "host/report/report.h"
#include "host/run/campaign.h"
#include "host/store/store.h"

/// From the store to what comparison and report are made of.

namespace powbench::host {

/// What a campaign was begun with. Throws StoreError when it cannot be read: the file is damaged.
Plan stored_plan(const CampaignInfo&);
sim::Specimen stored_specimen(const CampaignInfo&);

/// Nothing was planned: single closings by hand, or imported waveforms.
bool unplanned(const CampaignInfo&, const Plan&);

/// Options of the stored plan; of imports without a tolerance of the angle, which nobody set.
RunOptions stored_options(const CampaignInfo&, const Plan&);

/// Measured and simulated events of a campaign, by closing angle.
std::vector<AngleGroup> gather_angles(const Store&, std::int64_t campaign);

/// Measured beside simulated beside published, judged by the plan's limits.
Comparison compare_stored(const Store&, const CampaignInfo&);

/// How far the simulated curves of a campaign are from the measured ones, by closing angle.
std::vector<CurveRow> gather_curves(const Store&, const CampaignInfo&);

/// The plan's test record with what the annotations add, and the day on which the campaign began.
TestRecord gather_test_record(const Store&, const CampaignInfo&);

/// The conditions that a simulated shot was made under, in words: "under the mean conditions of 2 measured closings".
std::string simulation_basis(const StoredShot& simulated);

/// One measured or simulated shot with all its channels, and the simulation of its angle where there is one.
ReportInput gather_shot(const Store&, std::int64_t shot);

/// Everything the report shows; waveforms of at most 60 measured closings.
ReportInput gather_report(const Store&, const CampaignInfo&, const std::string& database);

}  // namespace powbench::host
