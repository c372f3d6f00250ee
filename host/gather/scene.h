#pragma once

#include <memory>
#include <string>
#include <vector>

#include "host/config/plan_file.h"
#include "host/config/rig_file.h"
#include "host/config/specimen_file.h"
#include "host/plan/expand.h"
#include "host/run/campaign.h"
#include "host/run/progress.h"
#include "rigs/registry.h"

/// What the verbs share: files read, names resolved, hashes taken.

namespace powbench::host {

/// A plan with everything it names, read and checked: all mistakes of all files at once.
struct Scene {
  Plan plan;
  sim::Specimen specimen;
  std::vector<PlannedShot> shots;
  std::string plan_text, plan_hash;          ///< resolved
  std::string specimen_text, specimen_hash;  ///< resolved
};
Scene load_scene(const std::string& plan_file, std::optional<std::uint64_t> seed = std::nullopt);
/// The same of a plan that was read already.
Scene make_scene(Plan);

/// Rig file behind a `sim:` URI, or the built-in one; other URIs have none.
RigFile rig_file(const std::string& uri);
/// Throws BadInput where the firmware of the simulated rig would not energise a coil with what `file` says, although
/// each key is within its range.
void refuse_unfit(const RigFile&, const std::string& file);

/// Opens a rig by its URI; `specimen` sits on a simulated one unless its rig file names another.
std::unique_ptr<rigs::Rig> open_rig(const std::string& uri, const sim::Specimen& specimen);

/// Campaign row of a scene, not yet stored.
CampaignInfo campaign_info(const Scene&, const std::string& rig_uri, const std::string& rig_identity);

/// The rig's own calibration becomes an instrument of the campaign's test record, once, where a certificate is stored
/// in the rig. To be called before the first shot and whenever the campaign is gone on with. Returns a sentence where
/// it has expired.
std::string note_calibration(Store&, std::int64_t campaign, const rigs::RigInfo&);

RunOptions run_options(const Plan&);
std::vector<Limit> plan_limits(const Plan&);
Progress::Style progress_style(const std::string& word);

}  // namespace powbench::host
