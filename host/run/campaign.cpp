#include "host/run/campaign.h"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <future>
#include <optional>
#include <set>

#include "core/phase.h"
#include "core/version.h"
#include "dsp/events/extract.h"
#include "host/compare/compare.h"
#include "host/run/stop.h"

namespace powbench::host {

ExtractionInfo extraction_info(const RunOptions& options) {
  return {dsp::to_text(options.extract), program_version};
}

StoredShot stored(std::int64_t campaign, ShotKind kind, const PlannedShot& planned) {
  StoredShot shot;
  shot.campaign = campaign;
  shot.kind = kind;
  shot.number = planned.index;
  shot.repeat = planned.repeat;
  shot.conditions = planned.conditions;
  shot.angle_deg = stored_degrees(effective_angle(planned.conditions));
  return shot;
}

namespace {

bool stop_asked(const RunOptions& options) {
  return StopOnSignal::asked() || (options.watcher != nullptr && options.watcher->stopped());
}

/// Looks for a lost rig with growing pauses, about 4 s in all.
bool find_again(rigs::Rig& rig, const RunOptions& options, Progress& progress) {
  progress.say("the rig is gone; looking for it");
  for (const double seconds : {0.25, 0.5, 1.0, 2.0}) {
    if (rig.reconnect()) return true;
    options.clock->sleep(seconds);
    if (stop_asked(options)) return false;
  }
  return rig.reconnect();
}

/// Shots outside limits that are named one by one; the others are in the sum at the end.
constexpr int failures_named = 5;

/// Extracts, judges and stores what one attempt gave.
StoredShot keep_shot(Store& store, StoredShot shot, const rigs::Shot& result, const RunOptions& options,
                     RunSummary& summary, Progress& progress) {
  shot.outcome = result.outcome;
  shot.reason = result.reason;
  std::optional<Events> events;
  if (result.outcome == Outcome::pass) {
    events = extract_checked(result.record, options);
    Judgement j = judge_shot(*events, shot.conditions, options);
    shot.outcome = j.outcome;
    shot.reason = std::move(j.reason);
    count(summary.limits, *events, options.decision, shot.angle_deg);
  }
  shot.id = store.store_shot(shot, events ? &result.record : nullptr, events ? &*events : nullptr,
                             extraction_info(options));
  if (options.watcher != nullptr) options.watcher->stored(shot.id);
  const bool outside = shot.outcome == Outcome::fail || shot.outcome == Outcome::not_observed;
  const int named = outside ? ++summary.outside_here : 0;
  if (named == failures_named + 1) progress.say("more shots outside limits are summed at the end");
  if (!shot.reason.empty() && named <= failures_named)
    progress.say(fmt::format("shot {} at {:.1f} deg: {}: {}", shot.number + 1, shot.angle_deg,
                             name(shot.outcome), shot.reason));
  return shot;
}

void pause_between(const RunOptions& options) {
  const auto tell = [&](double left) {
    if (options.watcher != nullptr) options.watcher->resting(left);
  };
  for (double left = options.pause; left > 0 && !stop_asked(options); left -= 0.05) {
    tell(left);
    options.clock->sleep(std::min(left, 0.05));
  }
  tell(0);
  if (options.watcher != nullptr) options.watcher->between();
}

}  // namespace

Exit RunSummary::exit_code() const {
  if (interrupted) return Exit::interrupted;
  if (interlock) return Exit::interlock;
  if (rig_lost || count(Outcome::error) > 0) return Exit::rig_fault;
  if (count(Outcome::timeout) > 0) return Exit::timeout;
  return count(Outcome::fail) + count(Outcome::not_observed) > 0 ? Exit::outside_limits : Exit::pass;
}

/// One of the two in a thread of its own; where none can be had, in turn.
static void side_by_side(const std::function<void()>& first, const std::function<void()>& second) {
  auto beside = std::async(first);
  second();
  beside.get();
}

Events extract_checked(const Record& record, const RunOptions& options) {
  Events events = dsp::extract_events(record, options.extract, side_by_side);
  dsp::check_angle(events, record.conditions, options.angle_tolerance);
  return events;
}

Judgement judge_shot(const Events& events, const Conditions& conditions, const RunOptions& options) {
  Judgement j = judge(events, options.limits, options.decision);
  const double commanded = effective_angle(conditions);
  if (!(options.angle_tolerance > 0) || !std::isfinite(commanded)) return j;
  const auto add = [&](Outcome o, const std::string& why) {
    j.outcome = worse(j.outcome, o);
    j.reason = why + (j.reason.empty() ? "" : "; ") + j.reason;
  };
  const Measured& reached = events.coil.closing_angle;
  const Outcome angle = judge_angle(reached, commanded, options.angle_tolerance, options.decision);
  if (angle == Outcome::not_observed)
    add(angle, fmt::format("closing angle not observed, commanded {:.2f} deg", degrees(commanded)));
  else if (angle != Outcome::pass)
    add(angle,
        fmt::format("closing angle {:.2f} deg{}, commanded {:.2f} deg, tolerance {:g} deg",
                    degrees(commanded + wrap_half_turn(reached.value - commanded)),
                    options.decision != Decision::guarded ? ""
                    : std::isfinite(reached.u) ? fmt::format(" with U = {:.2g} deg", degrees(2 * reached.u))
                                               : " without an uncertainty",
                    degrees(commanded), degrees(options.angle_tolerance)));
  return j;
}

std::vector<StoredShot> recorded_shots(const Store& store, std::int64_t campaign) {
  std::vector<StoredShot> shots = store.shots(campaign, ShotKind::measured);
  std::erase_if(shots, [](const StoredShot& s) { return !measured(s.outcome); });
  return shots;
}

RunSummary run_campaign(Store& store, std::int64_t campaign, std::span<const PlannedShot> plan,
                        rigs::Rig& rig, const RunOptions& options, Progress& progress) {
  RunSummary summary;
  summary.planned = plan.size();
  struct Watched {  // a stop also ends a shot that still waits for another owner
    rigs::Rig& rig;
    ~Watched() { rig.stop_when({}); }
  } const watched{rig};
  rig.stop_when([&options] { return stop_asked(options); });
  summary.limits = tally_of(options.limits);
  for (const StoredShot& left : store.close_begun())
    progress.say(fmt::format("campaign {}, shot {}: {}", left.campaign, left.number + 1, left.reason));
  std::set<int> done;
  for (const StoredShot& s : recorded_shots(store, campaign)) {
    done.insert(s.number);
    ++summary.counts[static_cast<std::size_t>(s.outcome)];
  }
  std::size_t fired = 0;
  int failures = 0;
  // of this plan; a campaign of single closings has others too
  auto recorded = static_cast<std::size_t>(
      std::count_if(plan.begin(), plan.end(), [&](const auto& p) { return done.contains(p.index); }));
  if (recorded > 0 && recorded < plan.size())
    store.annotate(campaign, course_key,
                   fmt::format("gone on with, {} of {} shots recorded before", recorded, plan.size()));
  const auto stop = [&](const std::string& why, const std::string& then) {
    summary.stopped = why + "; " + then + options.how_to_go_on;
    store.annotate(campaign, course_key,
                   fmt::format("{}, {} of {} shots recorded", why, recorded, plan.size()));
  };
  for (const PlannedShot& planned : plan) {
    if (done.contains(planned.index)) continue;
    if (fired > 0) pause_between(options);
    if (stop_asked(options)) {
      summary.interrupted = true;
      stop("stopped by the operator", "");
      break;
    }
    const StoredShot shot = stored(campaign, ShotKind::measured, planned);
    store.begin_shot(shot);
    rigs::Shot result = rig.fire(planned.conditions, options.shot_limit);
    StoredShot ended = keep_shot(store, shot, result, options, summary, progress);
    bool back = true;
    if (result.rig_lost) {
      back = find_again(rig, options, progress);
      // what was fired before the rig was lost may lie there still
      if (auto late = back ? rig.recover(options.shot_limit) : std::nullopt) {
        result = std::move(*late);
        ended = keep_shot(store, shot, result, options, summary, progress);
      }
    }
    ++summary.counts[static_cast<std::size_t>(ended.outcome)];
    failures = measured(ended.outcome) ? 0 : failures + 1;
    recorded += measured(ended.outcome) ? 1U : 0U;
    progress.update(done.size() + ++fired, fmt::format("{:.0f} deg", shot.angle_deg));

    summary.interlock = summary.interlock || result.interlock;
    if (!back) {
      summary.rig_lost = true;
      stop("stopped because the rig did not come back", "what was stored is safe; ");
      break;
    }
    if (result.latched) {
      stop("stopped because the rig is in fault", "mend the cause and acknowledge the fault, then ");
      break;
    }
    if (failures >= options.max_failures) {
      stop(fmt::format("stopped after {} shots in a row without a record", failures),
           "mend the cause, then ");
      break;
    }
  }
  store.set_finished(campaign, summary.done() == summary.planned);
  return summary;
}

}  // namespace powbench::host
