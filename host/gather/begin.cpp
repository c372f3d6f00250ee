#include "host/gather/begin.h"

namespace powbench::host {

/// Notes the rig's calibration and says what has expired.
static void check_calibrations(Store& store, std::int64_t campaign, const Scene& scene,
                               const rigs::RigInfo& rig, const std::function<void(const std::string&)>& say) {
  if (const std::string late = note_calibration(store, campaign, rig); !late.empty()) say(late);
  for (const Instrument& i : expired(scene.plan.test, utc_today()))
    say("calibration expired: " + i.name + ", certificate " + i.certificate + ", was valid until " +
        i.valid_until + "; the report says so on page 1");
}

std::int64_t begin_campaign(Store& store, const Scene& scene, const std::string& rig_uri,
                            const rigs::RigInfo& rig, bool resume,
                            const std::function<void(const std::string&)>& say) {
  const std::string identity = rig.model + ", " + rig.serial;
  const auto begun = store.find_campaign(scene.plan_hash, scene.specimen_hash);
  if (resume && begun) {
    if (begun->rig_identity != identity)
      throw rigs::RigError("campaign " + std::to_string(begun->id) + " was begun on '" + begun->rig_identity +
                           "', this rig is '" + identity + "'; use that rig, or start anew without --resume");
    if (recorded_shots(store, begun->id).size() < scene.shots.size())  // else nothing more is measured
      check_calibrations(store, begun->id, scene, rig, say);
    return begun->id;
  }
  if (begun && !begun->finished)
    say("campaign " + std::to_string(begun->id) +
        " of this plan is unfinished; --resume would go on with it");
  CampaignInfo info = campaign_info(scene, rig_uri, identity);
  info.origin = origin_of_kind(rig.kind);
  const std::int64_t campaign = store.create_campaign(info);
  check_calibrations(store, campaign, scene, rig, say);
  return campaign;
}

}  // namespace powbench::host
