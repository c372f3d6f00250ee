#pragma once

#include <cstddef>
#include <span>
#include <string>
#include <vector>

#include "core/outcome.h"
#include "dsp/options.h"
#include "host/compare/limits.h"
#include "host/plan/expand.h"
#include "host/run/machine_clock.h"
#include "host/run/progress.h"
#include "host/run/tally.h"
#include "host/store/store.h"
#include "rigs/rig.h"

/// Executes a plan: every shot acquired, its events extracted, judged and stored before the next one is fired.

namespace powbench::host {

class RunWatcher;

struct RunOptions {
  dsp::ExtractOptions extract;
  std::vector<Limit> limits;             ///< of the plan
  Decision decision = Decision::simple;  ///< of the limits
  double angle_tolerance = 0.0;          ///< rad: reached against commanded closing angle; 0 = none
  double supply_u = 0.005;               ///< relative: standard uncertainty of the measured voltage's scale
  double coil_temperature_u = 2.0;       ///< K
  double pause = 0.0;                    ///< s between two shots
  int max_failures = 5;                  ///< shots without a record in a row after which the campaign stops
  std::chrono::milliseconds shot_limit{15'000};  ///< longest time for one shot, hold time included
  Clock* clock = &machine_clock();  ///< of the pauses between shots and in the search for a lost rig
  RunWatcher* watcher = nullptr;    ///< beside the signals, which always count
  std::string how_to_go_on = "go on with --resume";  ///< of a campaign that stopped early, in words
};

/// Looks on while a campaign runs, and may hold or end it.
class RunWatcher {
 public:
  virtual ~RunWatcher() = default;
  /// The campaign ends before its next shot.
  virtual bool stopped() = 0;
  /// The plan's pause between two shots lasts `left` s more; called again and again, at last with 0.
  virtual void resting(double /*left*/) {}
  /// Between two shots; returns when the next one may begin.
  virtual void between() {}
  virtual void stored(std::int64_t /*shot*/) {}
};

/// How a campaign went.
struct RunSummary {
  std::size_t planned = 0;
  std::size_t counts[outcome_names.size()] =
      {};                          ///< shots of each Outcome, earlier runs of the campaign included
  bool rig_lost = false;           ///< stopped: the rig went away and did not come back
  bool interlock = false;          ///< stopped: the rig tripped or refused for safety
  bool interrupted = false;        ///< stopped by the operator
  std::string stopped;             ///< why it stopped early, one sentence; empty when it ran to the end
  std::vector<LimitTally> limits;  ///< of the plan, over the shots fired in this run
  int outside_here = 0;            ///< shots of this run that are FAIL or NOT OBSERVED

  std::size_t count(Outcome o) const { return counts[static_cast<std::size_t>(o)]; }
  std::size_t done() const {
    return count(Outcome::pass) + count(Outcome::fail) + count(Outcome::not_judged) +
           count(Outcome::not_observed);
  }
  Exit exit_code() const;
};

/// The shots of a campaign that gave a record.
std::vector<StoredShot> recorded_shots(const Store&, std::int64_t campaign);

/// Fires what is still to do (a shot that gave a record before is not fired again) and stores each shot in one
/// transaction; one that failed stays as an earlier attempt. A rig that goes away is looked for again; a rig that
/// stays away ends the run, never the data.
RunSummary run_campaign(Store&, std::int64_t campaign, std::span<const PlannedShot>, rigs::Rig&,
                        const RunOptions&, Progress&);

/// A planned shot as it is stored, before anything is known of it.
StoredShot stored(std::int64_t campaign, ShotKind, const PlannedShot&);
ExtractionInfo extraction_info(const RunOptions&);

/// The verdict on a shot with a record: angle tolerance, then limits. NOT JUDGED without a limit; NOT OBSERVED where
/// an angle was commanded within a tolerance and the record does not show the one reached.
Judgement judge_shot(const Events&, const Conditions&, const RunOptions&);

/// Events of a record with the checks that need its conditions: closing angle within tolerance.
Events extract_checked(const Record&, const RunOptions&);

}  // namespace powbench::host
