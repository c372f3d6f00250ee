#include "host/gather/begin.h"

#include <fmt/format.h>

#include "rigs/sealed_shot.h"

namespace powbench::host {

/// Notes the rig's calibration and says what has expired.
static void check_calibrations(Store& store, std::int64_t campaign, const Scene& scene,
                               const rigs::RigInfo& rig, const std::function<void(const std::string&)>& say) {
  if (const std::string late = note_calibration(store, campaign, rig); !late.empty()) say(late);
  for (const Instrument& i : expired(scene.plan.test, utc_today()))
    say("calibration expired: " + i.name + ", certificate " + i.certificate + ", was valid until " +
        i.valid_until + "; the report says so on page 1");
}

/// The shots of a campaign are of one configuration: another rate or another range is another measurement. A new
/// calibration changes it too; that is allowed, and said elsewhere.
static void check_configuration(const Store& store, std::int64_t campaign,
                                const std::vector<StoredShot>& recorded, const rigs::RigInfo& rig) {
  for (const StoredShot& shot : recorded) {
    const std::string text = store.sealed_text(shot.id);
    if (text.empty() || rig.configuration.empty()) continue;
    rigs::SealedShot seal;
    try {
      seal = rigs::parse_sealed_shot(text);
    } catch (const rigs::SealError&) {
      continue;  // of a former program: it says nothing that is known here
    }
    const std::string then = fmt::format("{:08x}", seal.config_crc32);
    const bool same_rate = static_cast<double>(seal.sample_rate) == rig.sample_rate;
    if (then == rig.configuration || (same_rate && seal.calibration != rig.calibration)) return;
    throw rigs::RigError(
        fmt::format("campaign {} was begun with the rig's configuration {}, now it is {}: sample rate, "
                    "lengths, ranges or limits were changed; set them as they were, or start anew "
                    "without --resume",
                    campaign, then, rig.configuration));
  }
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
    const auto recorded = recorded_shots(store, begun->id);
    if (recorded.size() < scene.shots.size()) {  // else nothing more is measured
      check_configuration(store, begun->id, recorded, rig);
      check_calibrations(store, begun->id, scene, rig, say);
    }
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
