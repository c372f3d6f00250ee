#pragma once

#include <cstdint>
#include <optional>
#include <string>
#include <vector>

#include "core/outcome.h"
#include "host/cli/shard.h"

/// Verbs that need many simulated closings.

namespace powbench::sim {
struct Case;
struct MeasuredClosing;
}  // namespace powbench::sim

namespace powbench::host {

struct FitArgs {
  std::string database;                 ///< "" = the published tables
  std::vector<std::int64_t> campaigns;  ///< empty = the newest
  std::string fields, mechanics;        ///< model that simulates; both "" = the plant
  std::string cache = "field";          ///< folder of field tables
  std::string specimen_file;            ///< numbers that are not free; "" = built-in, or the campaign's
  std::vector<std::string> free;        ///< NAME=LOW:HIGH
  std::vector<std::string> start;       ///< specimen files that the search for everything begins from
  std::vector<double>
      deviations;       ///< percent of touch, seat, bounce, overtravel; empty = defaults of the source
  double prior = 0.35;  ///< deviation of each free number, as a share of its bounds; 0: none
  std::vector<double> hold_out;  ///< degrees: never used, predicted
  bool leave_one_out = false;
  long evaluations = 6'000;  ///< of each search
  int searches = 3;
  long finish = 0;   ///< evaluations of the last search, on absolute deviations; 0: none
  int ensemble = 3;  ///< of each search
  int next = 0;      ///< measurements to propose
  std::uint64_t seed = 1;
  int threads = 0;
  std::string state_file, output, fit_file, name;
  bool overwrite = false;  ///< `output` and `fit_file`
  std::string picture;     ///< SVG to write; "" = none
  bool json = false;
  ShardArgs shards;  ///< of posteriors and searches
  std::string progress = "auto";
};
Exit fit_specimen(const FitArgs&);
/// The measured closings of a fit: of the published tables, or of a campaign.
std::vector<sim::MeasuredClosing> fit_closings(const FitArgs&);

struct SweepArgs {
  std::string specimen_file;      ///< "" = built-in reference
  std::vector<std::string> vary;  ///< NAME=LOW:HIGH[:STEPS], or NAME~MEAN:DEVIATION
  std::string sampling = "latin";
  std::int64_t points = 1000;
  std::uint64_t seed = 1;
  double angle_deg = 0, supply_volts = 230, ambient_degC = 20;
  std::string metric = "bounce";
  bool forces = false;       ///< first_peak and impulse too: three times dearer
  bool sensitivity = false;  ///< table of derivatives instead of a sweep
  bool best_angle = false;   ///< search instead of a sweep
  int angles = 90, draws = 60;
  std::string database = "powbench.db";
  std::string picture;  ///< SVG to write; "" = none
  ShardArgs shards;     ///< in blocks of points
  int threads = 0;
  bool json = false;
  std::string progress = "auto";
};
Exit sweep(const SweepArgs&);

struct LadderArgs {
  std::string scene;  ///< specimen file, or a plan file NAME.plan.toml; "" = the reference contactor
  std::vector<double> angles_deg;  ///< in place of the plan's first shot; several for `judge`
  std::optional<double> supply_volts, ambient_degC;  ///< likewise
  std::string judge;               ///< of the touch time: the table of all pairs held against it; "" = none
  std::string fit_file, database;  ///< of `judge`: what a fit missed at the angles it held out, as `FitArgs`
  std::optional<std::int64_t> campaign;
  std::string accuracy;  ///< of the touch time, "1%" or "0.01": choose a rung; "" = the whole ladder
  std::vector<std::string> fields;  ///< of the rungs; empty = circuit
  std::string mechanics;            ///< only rungs with these; "" = all that take less than seconds
  bool all = false;                 ///< every pair, also those that take seconds to minutes
  std::string cache = "field";      ///< folder of field tables
  std::string
      table_file;  ///< of `powbench field`: also the rung `table+rigid`, or only it for an accuracy; "" = none
  std::string folder = "ladder";
  ShardArgs shards;  ///< of cells: rung and setting
  bool json = false;
};
Exit show_ladder(const LadderArgs&);
/// Every pair at every angle with its times, three errors, cost and verdict. `scene`: the conditions of all of them.
Exit judge_ladder(const LadderArgs&, const sim::Case& scene);

}  // namespace powbench::host
