#pragma once

#include <nlohmann/json.hpp>
#include <string>
#include <vector>

#include "bench/dsp_metrics.h"

/// What the score is held against, and its picture.

namespace powbench::bench {

/// One line: what must hold, what is aimed at, what was measured.
struct Figure {
  std::string what, must, goal;
  double measured = 0;
  bool met_must = false, met_goal = false;
};

/// |measured| at most `must` / `goal`.
Figure at_most(std::string what, double measured, double must, double goal);
/// At least.
Figure at_least(std::string what, double measured, double must, double goal);
/// Within [low, high].
Figure between(std::string what, double measured, double low, double high, double goal_low, double goal_high);

nlohmann::json print(const std::vector<Figure>&);

/// The extraction on the simulated rig, against the simulator's truth. Prints its table.
struct RigScore {
  nlohmann::json json;
  double cpu_ms = 0;     ///< one record of six channels, 100 ms at 200 kS/s
  double angle_deg = 0;  ///< rms
};
RigScore score_rig(int angles);

/// Restored force of a 5 N plateau after 0.1 s behind a corner of 5 Hz, minus 5 N: the largest of 20 records, N.
double droop_error();

/// Error against cost of each method on clean and on ringing records, as a picture.
struct Mark {
  std::string method;
  bool ring = false;
  double cpu_ms = 0, touch_us = 0;
};
void write_picture(const std::string& path, const std::vector<Mark>&);

}  // namespace powbench::bench
