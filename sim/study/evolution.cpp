#include "sim/study/evolution.h"

#include <algorithm>
#include <cmath>
#include <limits>

#include "core/random.h"
#include "core/units.h"

namespace powbench::sim {
namespace {

constexpr std::size_t memory_length = 6;
constexpr double best_share = 0.11;  // of the population that trials are drawn to
constexpr double archive_rate = 1.4;

std::uint64_t mixed(std::uint64_t a, std::uint64_t b, std::uint64_t c) {
  std::uint64_t s = a;
  s = splitmix64(s) ^ b;
  s = splitmix64(s) ^ c;
  return splitmix64(s);
}

bool less(const Candidate& a, const Candidate& b) {
  return a.value < b.value;
}

/// Halfway back to the parent where a coordinate would leave the cube.
double kept(double value, double parent) {
  if (value < 0) return parent / 2;
  if (value > 1) return (1 + parent) / 2;
  return value;
}

/// Each by itself.
Evolution::Costs costs_one_by_one(Evolution::Cost cost) {
  return [cost = std::move(cost)](std::span<const std::vector<double>> points,
                                  std::span<const double> give_up, Team& team) {
    std::vector<double> values(points.size());
    for_each_index(team, static_cast<int>(points.size()), [&](int i) {
      const auto k = static_cast<std::size_t>(i);
      values[k] = cost(points[k], give_up[k]);
    });
    return values;
  };
}

}  // namespace

Evolution::Evolution(Settings settings, Cost cost, std::vector<std::vector<double>> start)
    : Evolution(settings, costs_one_by_one(std::move(cost)), std::move(start)) {}

Evolution::Evolution(Settings settings, Costs costs, std::vector<std::vector<double>> start)
    : settings_(settings), costs_(std::move(costs)), start_(std::move(start)) {
  if (settings_.population == 0) settings_.population = std::max<std::size_t>(20, 5 * settings_.dimension);
  state_.memory_scale.assign(memory_length, 0.5);
  state_.memory_crossing.assign(memory_length, 0.5);
}

void Evolution::begin(Team& team) {
  auto& all = state_.population;
  all.assign(settings_.population, Candidate{std::vector<double>(settings_.dimension), 0});
  for (std::size_t k = 0; k < all.size(); ++k) {
    Random random(mixed(settings_.seed, 0, k));
    for (auto& u : all[k].point) u = random.uniform();
    if (k < start_.size()) all[k].point = start_[k];
  }
  std::vector<std::vector<double>> points;
  for (const auto& c : all) points.push_back(c.point);
  const std::vector<double> never(all.size(), std::numeric_limits<double>::infinity());
  const auto values = costs_(points, never, team);
  for (std::size_t k = 0; k < all.size(); ++k) all[k].value = values[k];
  std::stable_sort(all.begin(), all.end(), less);
  state_.used += static_cast<long>(all.size());
}

Evolution::Trial Evolution::trial_for(std::size_t k) const {
  const auto& all = state_.population;
  Random random(mixed(settings_.seed, state_.generation, k));
  const std::size_t memory = random.below(memory_length);
  Trial t;
  t.crossing = std::clamp(state_.memory_crossing[memory] + 0.1 * random.normal(), 0.0, 1.0);
  do {  // Cauchy about the memory
    t.scale = state_.memory_scale[memory] + 0.1 * std::tan(pi * (random.uniform() - 0.5));
  } while (t.scale <= 0);
  t.scale = std::min(t.scale, 1.0);
  const auto top =
      std::max<std::size_t>(2, static_cast<std::size_t>(best_share * static_cast<double>(all.size())));
  const auto& leader = all[random.below(std::min(top, all.size()))].point;
  const auto& one = all[random.below(all.size())].point;
  const std::size_t other = random.below(all.size() + state_.archive.size());
  const auto& two = other < all.size() ? all[other].point : state_.archive[other - all.size()];
  const std::size_t sure = random.below(settings_.dimension);
  t.candidate.point = all[k].point;
  for (std::size_t i = 0; i < settings_.dimension; ++i) {
    if (i != sure && random.uniform() >= t.crossing) continue;
    const double u = all[k].point[i];
    t.candidate.point[i] = kept(u + t.scale * (leader[i] - u + one[i] - two[i]), u);
  }
  return t;
}

void Evolution::learn(const std::vector<Trial>& better, const std::vector<double>& gain) {
  double total = 0;
  for (const double g : gain) total += g;
  if (better.empty() || !(total > 0)) return;
  double scale = 0, scale2 = 0, crossing = 0, crossing2 = 0;
  for (std::size_t k = 0; k < better.size(); ++k) {
    const double w = gain[k] / total;
    scale += w * better[k].scale;
    scale2 += w * better[k].scale * better[k].scale;
    crossing += w * better[k].crossing;
    crossing2 += w * better[k].crossing * better[k].crossing;
  }
  state_.memory_scale[state_.memory_next] = scale2 / scale;
  state_.memory_crossing[state_.memory_next] = crossing > 0 ? crossing2 / crossing : 0.0;
  state_.memory_next = (state_.memory_next + 1) % memory_length;
}

void Evolution::shrink() {
  auto& all = state_.population;
  std::stable_sort(all.begin(), all.end(), less);
  const double share =
      std::min(1.0, static_cast<double>(state_.used) / static_cast<double>(settings_.evaluations));
  const double from = static_cast<double>(settings_.population);
  const double to = static_cast<double>(std::min(settings_.smallest, settings_.population));
  all.resize(std::min(all.size(), static_cast<std::size_t>(std::lround(from + share * (to - from)))));
  Random random(mixed(settings_.seed, state_.generation, 1'000'000));
  while (static_cast<double>(state_.archive.size()) > archive_rate * static_cast<double>(all.size())) {
    state_.archive[random.below(state_.archive.size())] = state_.archive.back();
    state_.archive.pop_back();
  }
}

bool Evolution::step(Team& team) {
  if (state_.population.empty()) {
    begin(team);
    return state_.used < settings_.evaluations;
  }
  ++state_.generation;
  auto& all = state_.population;
  std::vector<Trial> trials(all.size());
  std::vector<std::vector<double>> points;
  std::vector<double> give_up;
  for (std::size_t k = 0; k < all.size(); ++k) {
    trials[k] = trial_for(k);
    points.push_back(trials[k].candidate.point);
    give_up.push_back(all[k].value);
  }
  const auto values = costs_(points, give_up, team);
  for (std::size_t k = 0; k < all.size(); ++k) trials[k].candidate.value = values[k];
  std::vector<Trial> better;
  std::vector<double> gain;
  for (std::size_t k = 0; k < all.size(); ++k) {
    if (!(trials[k].candidate.value <= all[k].value)) continue;
    if (trials[k].candidate.value < all[k].value) {
      state_.archive.push_back(all[k].point);
      gain.push_back(all[k].value - trials[k].candidate.value);
      better.push_back(trials[k]);
    }
    all[k] = std::move(trials[k].candidate);
  }
  state_.used += static_cast<long>(all.size());
  learn(better, gain);
  shrink();
  return state_.used < settings_.evaluations;
}

}  // namespace powbench::sim
