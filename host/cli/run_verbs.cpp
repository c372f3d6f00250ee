#include <fmt/format.h>

#include <nlohmann/json.hpp>

#include "host/cli/verbs.h"
#include "host/gather/scene.h"
#include "host/run/stop.h"

namespace powbench::host {

namespace {

void print_summary(const RunSummary& s, std::int64_t campaign, Origin origin, bool json) {
  if (json) {
    nlohmann::ordered_json j = {
        {"campaign", campaign}, {"origin", name(origin)}, {"planned", s.planned}, {"done", s.done()}};
    for (std::size_t i = 0; i < outcome_names.size(); ++i) j[std::string(outcome_names[i])] = s.counts[i];
    j["stopped"] = s.stopped.empty() ? nlohmann::ordered_json(nullptr) : nlohmann::ordered_json(s.stopped);
    fmt::print("{}\n", j.dump(2));
  }
  std::string counts;
  for (const Outcome o : {Outcome::pass, Outcome::fail, Outcome::not_observed, Outcome::not_judged})
    if (s.count(o) > 0) counts += fmt::format("{}{} {}", counts.empty() ? "" : ", ", s.count(o), name(o));
  fmt::print(stderr, "campaign {}, {}: {} of {} shots recorded{}, {} without a record\n", campaign,
             name(origin), s.done(), s.planned, counts.empty() ? "" : " (" + counts + ")",
             s.count(Outcome::error) + s.count(Outcome::timeout) + s.count(Outcome::aborted));
  if (!s.stopped.empty()) fmt::print(stderr, "{}\n", s.stopped);
}

}  // namespace

Exit run_plan(const RunArgs& args) {
  const Scene scene = load_scene(args.plan, args.seed);
  if (args.rig.empty())
    throw BadInput(
        {"run: no rig is named; --rig sim: is a simulated one, ip:ADDRESS, serial:PORT,BAUD and usb:... fire "
         "a "
         "contactor (powbench rigs lists them)"});
  if (args.dry_run) {
    rig_file(args.rig);
    fmt::print(stderr, "{} shots would be fired; nothing was done\n", scene.shots.size());
    return Exit::pass;
  }
  Store store(args.database);
  const StopOnSignal stop;
  // the rig first: a campaign that could not begin leaves no trace
  const auto rig = open_rig(args.rig, scene.specimen);
  const std::string identity = rig->info().model + ", " + rig->info().serial;
  const Origin origin = origin_of_kind(rig->info().kind);
  const auto begun = store.find_campaign(scene.plan_hash, scene.specimen_hash);
  std::int64_t campaign = 0;
  if (args.resume && begun) {
    campaign = begun->id;
    if (begun->rig_identity != identity)
      throw rigs::RigError("campaign " + std::to_string(campaign) + " was begun on '" + begun->rig_identity +
                           "', this rig is '" + identity + "'; use that rig, or start anew without --resume");
  } else {
    if (begun && !begun->finished)
      fmt::print(stderr, "campaign {} of this plan is unfinished; --resume would go on with it\n", begun->id);
    CampaignInfo info = campaign_info(scene, args.rig, identity);
    info.origin = origin;
    campaign = store.create_campaign(info);
    if (const std::string late = note_calibration(store, campaign, rig->info()); !late.empty())
      fmt::print(stderr, "{}\n", late);
  }
  RunOptions options = run_options(scene.plan);
  options.max_failures = args.max_failures;
  Progress progress("acquire", scene.shots.size(), progress_style(args.progress));
  const RunSummary summary = run_campaign(store, campaign, scene.shots, *rig, options, progress);
  progress.finish();
  print_summary(summary, campaign, origin, args.json);
  return summary.exit_code();
}

}  // namespace powbench::host
