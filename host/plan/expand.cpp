#include "host/plan/expand.h"

#include <numeric>
#include <utility>

#include "core/random.h"

namespace powbench::host {
namespace {

constexpr std::uint64_t order_stream =
    0x6F72646572ULL;  // keeps the order's numbers apart from the shots' seeds

std::vector<std::size_t> block_order(const Plan& plan, int repeat) {
  std::vector<std::size_t> order(plan.angles.size());
  std::iota(order.begin(), order.end(), std::size_t{0});
  if (plan.order != Order::random) return order;
  std::uint64_t state = plan.seed ^ order_stream;
  const std::uint64_t base = splitmix64(state);
  Random random(base + static_cast<std::uint64_t>(repeat));
  for (std::size_t i = order.size(); i > 1; --i) std::swap(order[i - 1], order[random.below(i)]);
  return order;
}

int polarity_of(const Plan& plan, int index, int repeat) {
  if (plan.polarity != Polarity::alternate) return plan.polarity == Polarity::positive ? +1 : -1;
  const bool even_block = plan.angles.size() % 2 == 0;
  return (index + (even_block ? repeat : 0)) % 2 == 0 ? +1 : -1;
}

}  // namespace

std::uint64_t shot_seed(std::uint64_t plan_seed, int index) {
  std::uint64_t state = plan_seed;
  state = splitmix64(state) + static_cast<std::uint64_t>(index);
  return splitmix64(state) >> 11;
}

std::vector<PlannedShot> expand(const Plan& plan, const std::string& specimen_name) {
  std::vector<PlannedShot> shots;
  shots.reserve(plan.angles.size() * static_cast<std::size_t>(plan.repeats));
  for (int repeat = 0; repeat < plan.repeats; ++repeat)
    for (const std::size_t place : block_order(plan, repeat)) {
      const int index = static_cast<int>(shots.size());
      Conditions c;
      c.supply_volts = plan.supply_volts;
      c.mains_hertz = plan.mains_hertz;
      c.closing_angle = plan.angles[place];
      c.angle_tolerance = plan.angle_tolerance;
      c.polarity = polarity_of(plan, index, repeat);
      c.hold_time = plan.hold_time;
      c.ambient = plan.ambient;
      c.specimen = specimen_name;
      c.seed = shot_seed(plan.seed, index);
      shots.push_back({index, repeat, std::move(c)});
    }
  return shots;
}

double estimated_seconds(const Plan& plan, double overhead_per_shot) {
  const double shots = static_cast<double>(plan.angles.size()) * plan.repeats;
  return shots < 1 ? 0.0 : shots * (plan.hold_time + overhead_per_shot) + (shots - 1) * plan.pause;
}

}  // namespace powbench::host
