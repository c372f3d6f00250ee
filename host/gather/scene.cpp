#include "host/gather/scene.h"

#include <fmt/format.h>

#include <algorithm>

#include "core/version.h"
#include "host/config/bad_input.h"
#include "host/store/hash.h"
#include "rigs/sim_world.h"

namespace powbench::host {

Scene load_scene(const std::string& plan_file, std::optional<std::uint64_t> seed) {
  Plan plan = read_plan(plan_file);
  if (seed) plan.seed = *seed;
  return make_scene(std::move(plan));
}

Scene make_scene(Plan plan) {
  Scene scene;
  scene.plan = std::move(plan);
  refuse_day_to_come(scene.plan.test.recorded);
  scene.specimen = load_specimen(scene.plan);
  scene.shots = expand(scene.plan, scene.specimen.name);
  scene.plan_text = resolved_text(scene.plan);
  scene.plan_hash = sha256_hex(scene.plan_text);
  scene.specimen_text = resolved_text(scene.specimen);
  scene.specimen_hash = sha256_hex(scene.specimen_text);
  return scene;
}

RigFile rig_file(const std::string& uri) {
  if (!rigs::is_simulated(uri)) return {};
  const std::string file = uri.substr(uri.find(':') + 1);
  if (file.empty()) return RigFile{};
  RigFile rig = read_rig(file);
  refuse_unfit(rig, file);
  return rig;
}

std::unique_ptr<rigs::Rig> open_rig(const std::string& uri, const sim::Specimen& specimen) {
  const RigFile file = rig_file(uri);
  return rigs::open(uri, file.config, file.specimen.empty() ? specimen : load_specimen(file));
}

CampaignInfo campaign_info(const Scene& scene, const std::string& rig_uri, const std::string& rig_identity) {
  CampaignInfo info;
  info.name = scene.plan.name;
  info.plan = scene.plan_text;
  info.plan_hash = scene.plan_hash;
  info.specimen = scene.specimen_text;
  info.specimen_hash = scene.specimen_hash;
  info.rig_uri = rig_uri;
  info.rig_file = rigs::is_simulated(rig_uri) ? resolved_text(rig_file(rig_uri)) : "";
  info.rig_identity = rig_identity;
  info.program_version = program_version;
  return info;
}

std::string note_calibration(Store& store, std::int64_t campaign, const rigs::RigInfo& rig) {
  if (rig.calibration_expires.empty()) return {};
  const std::string text =
      rig.model + " " + rig.serial + "; " + rig.calibration + "; " + rig.calibration_expires;
  Instrument unused;
  if (!read_instrument(text, unused).empty()) return {};
  const std::vector<Annotation> there = store.annotations(campaign);
  if (std::none_of(there.begin(), there.end(),
                   [&](const Annotation& a) { return a.key == "instrument" && a.text == text; }))
    store.annotate(campaign, "instrument", text);
  if (rig.calibration_expires >= utc_today()) return {};
  return "the rig's calibration " + rig.calibration + " was valid until " + rig.calibration_expires +
         "; the report says so on page 1";
}

std::vector<Limit> plan_limits(const Plan& plan) {
  std::vector<Limit> limits;
  for (std::size_t i = 0; i < quantity_table.size(); ++i) {
    const auto& range = plan.limits[i];
    if (!std::isnan(range.low) || !std::isnan(range.high))
      limits.push_back({std::string(quantity_table[i].symbol), range.low, range.high});
  }
  return limits;
}

RunOptions run_options(const Plan& plan) {
  RunOptions options;
  options.extract.mains_hertz = plan.mains_hertz;
  options.extract.crosstalk_a = plan.crosstalk_a;
  options.extract.crosstalk_b = plan.crosstalk_b;
  set_filter(options.extract, plan.events);  // read_plan refused what is wrong
  options.limits = plan_limits(plan);
  if (std::isfinite(plan.supply_u)) options.supply_u = plan.supply_u;
  if (std::isfinite(plan.coil_temperature_u)) options.coil_temperature_u = plan.coil_temperature_u;
  options.decision = plan.decision;
  options.angle_tolerance = plan.angle_tolerance;
  options.pause = plan.pause;
  options.shot_limit += std::chrono::milliseconds(static_cast<int>(plan.hold_time * 1000.0));
  return options;
}

Progress::Style progress_style(const std::string& word) {
  if (word == "bar") return Progress::Style::bar;
  if (word == "lines") return Progress::Style::lines;
  if (word == "none") return Progress::Style::none;
  return Progress::Style::automatic;
}

}  // namespace powbench::host
