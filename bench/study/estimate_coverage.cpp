#include "bench/study/estimate_coverage.h"

#include <algorithm>
#include <cmath>
#include <limits>
#include <stdexcept>

#include "core/random.h"
#include "core/units.h"

namespace powbench::bench {

std::vector<sim::Case> random_scenes(const sim::Specimen& specimen, int count, std::uint64_t seed) {
  Random random(seed);
  std::vector<sim::Case> scenes;
  for (int k = 0; k < count; ++k) {
    sim::Case c{specimen, {}};
    c.conditions.closing_angle = 2 * pi * random.uniform();
    c.conditions.supply_volts = 230 * (0.85 + 0.25 * random.uniform());
    c.conditions.ambient = zero_celsius - 5 + 65 * random.uniform();
    scenes.push_back(c);
  }
  return scenes;
}

double EstimateCoverage::share() const {
  int in = 0;
  int all = 0;
  for (std::size_t q = 0; q < covered.size(); ++q) {
    in += covered[q];
    all += happened[q];
  }
  return all == 0 ? std::numeric_limits<double>::quiet_NaN() : static_cast<double>(in) / all;
}

std::vector<EstimateCoverage> estimator_coverage(std::span<const sim::Rung> rungs,
                                                 std::span<const sim::Case> scenes,
                                                 const sim::LadderOptions& o, const sim::CpuClock& clock,
                                                 sim::Team& team) {
  std::vector<EstimateCoverage> result;
  for (std::size_t r = 0; r < rungs.size(); ++r) {
    std::vector<std::vector<sim::LadderRow>> ladders(scenes.size());
    sim::for_each_index(team, static_cast<int>(scenes.size()), [&](int k) {
      const auto scene = static_cast<std::size_t>(k);
      try {
        ladders[scene] = run_ladder(rungs.subspan(r, 1), scenes[scene], o, clock).rows;
      } catch (const std::runtime_error&) {  // a guard stopped it
      }
    });
    std::vector<EstimateCoverage> part;
    int stopped = 0;
    for (auto& rows : ladders) {
      if (rows.empty()) {
        ++stopped;
        continue;
      }
      // the estimate of the last of a rung's own settings is made with the truth itself: it would always cover
      if (!rungs[r].settings.empty()) rows.pop_back();
      part.resize(rows.size());
      for (std::size_t k = 0; k < rows.size(); ++k) {
        auto& c = part[k];
        c.rung = r;
        c.tolerance = rows[k].run.tolerance;
        c.cpu += rows[k].run.cpu / static_cast<double>(scenes.size());
        for (std::size_t q = 0; q < c.covered.size(); ++q) {
          const double error = rows[k].error[q];
          if (std::isnan(error)) continue;
          ++c.happened[q];
          c.covered[q] += error <= rows[k].estimate[q];
          c.worst_error[q] = std::max(c.worst_error[q], error);
        }
      }
    }
    for (auto& c : part) c.stopped = stopped;
    result.insert(result.end(), part.begin(), part.end());
  }
  return result;
}

}  // namespace powbench::bench
