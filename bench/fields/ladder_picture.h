#pragma once

#include <string>
#include <vector>

/// Three pictures side by side: error of flux linkage, pull and touch time against CPU time, both logarithmic.

namespace powbench::bench {

struct LadderPoint {
  double cost = 0;       ///< s CPU
  double to_space = 0;   ///< against the field in three dimensions; 0: not known
  double to_finest = 0;  ///< against the finest of its own kind
};

struct LadderLine {
  std::string rung;
  std::vector<LadderPoint> points;
};

struct LadderPanel {
  std::string title, abscissa, ordinate;
  std::vector<LadderLine> lines;
};

/// Full lines: against the field in three dimensions; dashed: against the finest of its kind.
std::string ladder_picture(const std::vector<LadderPanel>&, const std::string& title);

}  // namespace powbench::bench
