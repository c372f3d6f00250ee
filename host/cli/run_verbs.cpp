#include <fmt/format.h>

#include <filesystem>
#include <nlohmann/json.hpp>
#include <optional>

#include "core/counted.h"
#include "host/cli/verbs.h"
#include "host/gather/begin.h"
#include "host/run/stop.h"

namespace powbench::host {

namespace {

void print_summary(const RunSummary& s, std::int64_t campaign, Origin origin, bool json) {
  if (json) {
    nlohmann::ordered_json j = {
        {"campaign", campaign}, {"origin", name(origin)}, {"planned", s.planned}, {"done", s.done()}};
    for (std::size_t i = 0; i < outcome_names.size(); ++i) j[std::string(outcome_names[i])] = s.counts[i];
    j["limits"] = nlohmann::ordered_json::array();
    for (const LimitTally& t : s.limits)
      j["limits"].push_back(
          {{"quantity", t.limit.quantity}, {"fail", t.failed}, {"not_observed", t.not_observed}});
    j["stopped"] = s.stopped.empty() ? nlohmann::ordered_json(nullptr) : nlohmann::ordered_json(s.stopped);
    fmt::print("{}\n", j.dump(2));
  }
  std::string counts;
  for (const Outcome o : {Outcome::pass, Outcome::fail, Outcome::not_observed, Outcome::not_judged})
    if (s.count(o) > 0) counts += fmt::format("{}{} {}", counts.empty() ? "" : ", ", s.count(o), name(o));
  fmt::print(stderr, "campaign {}, {}: {} of {} shots recorded{}, {} without a record\n", campaign,
             name(origin), s.done(), s.planned, counts.empty() ? "" : " (" + counts + ")",
             s.count(Outcome::error) + s.count(Outcome::timeout) + s.count(Outcome::aborted));
  for (const LimitTally& t : s.limits)
    if (const std::string text = sentence(t); !text.empty()) fmt::print(stderr, "  {}\n", text);
  if (s.interlock)
    fmt::print(
        stderr,
        "a fault that is still latched is acknowledged with 'powbench stop RIG', once its cause is gone\n");
  if (!s.stopped.empty()) fmt::print(stderr, "{}\n", s.stopped);
}

}  // namespace

Exit run_plan(const RunArgs& args) {
  const Scene scene = load_scene(args.plan, args.seed);
  if (scene.plan.order == Order::by_hand)
    throw BadInput(
        {args.plan + ": order = \"by_hand\" marks closings that nobody planned; allowed random, sequential"});
  if (args.rig.empty())
    throw BadInput(
        {"run: no rig is named; --rig sim: is a simulated one, ip:ADDRESS, serial:PORT,BAUD and usb:... fire "
         "a "
         "contactor (powbench rigs lists them)"});
  if (args.dry_run) {
    rig_file(args.rig);
    fmt::print(stderr, "{} would be fired; nothing was done\n", counted(scene.shots.size(), "shot"));
    return Exit::pass;
  }
  const StopOnSignal stop;
  // the rig before a store is made: a campaign that could not begin leaves no trace; one that cannot be used is
  // refused before
  std::optional<Store> there;
  std::error_code ignored;
  if (std::filesystem::exists(args.database, ignored)) there.emplace(args.database);
  const auto rig = open_rig(args.rig, scene.specimen);
  if (!there) there.emplace(args.database);
  Store& store = *there;
  const std::int64_t campaign =
      begin_campaign(store, scene, args.rig, rig->info(), args.resume,
                     [](const std::string& text) { fmt::print(stderr, "{}\n", text); });
  RunOptions options = run_options(scene.plan);
  options.max_failures = args.max_failures;
  Progress progress("acquire", scene.shots.size(), progress_style(args.progress),
                    recorded_shots(store, campaign).size());
  const RunSummary summary = run_campaign(store, campaign, scene.shots, *rig, options, progress);
  progress.finish();
  print_summary(summary, campaign, origin_of_kind(rig->info().kind), args.json);
  return summary.exit_code();
}

}  // namespace powbench::host
