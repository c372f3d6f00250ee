#include "bench/study/channel_fit.h"

#include <algorithm>
#include <cmath>

#include "sim/specimen/validate.h"
#include "sim/study/evolution.h"
#include "sim/study/least_squares.h"

namespace powbench::bench {
namespace {

constexpr double rated_volts = 230;
constexpr double step = 1e-3;       // of the differences
constexpr double tolerance = 1e-5;  // of the integrator
constexpr double never = 40;        // deviations: a closing that does not close

sim::Misfit kind() {
  sim::FitProblem problem;
  problem.parameters = sim::posterior_parameters();
  problem.plausible = sim::catalogue_ranges();
  return sim::Misfit(problem).motion();
}

}  // namespace

ChannelMisfit::ChannelMisfit(const Campaign& campaign, const Channels& channels)
    : force_(channels.force), kind_(kind()) {
  constexpr double of_time = 0.03, of_speed = 0.05, of_force = 0.1, of_overtravel = 0.02, room = 1.35;
  const auto relative = [](double value, double u, bool known) {
    return known ? Measured{value, u * value} : Measured{};
  };
  double last = 0;
  for (const auto& s : campaign.shots) {
    rows_.push_back({s.angle,
                     {relative(s.touch, of_time, true), relative(s.seat, of_time, true),
                      relative(s.touch_speed, of_speed, channels.speeds),
                      relative(s.seat_speed, of_speed, channels.speeds),
                      relative(s.force_peak, of_force, channels.force)}});
    last = std::max({last, s.touch, s.seat});
  }
  overtravel_ = relative(campaign.overtravel, of_overtravel, channels.overtravel);
  duration_ = room * last;
}

double ChannelMisfit::rows(const sim::Specimen& specimen, double sum, double give_up,
                           std::vector<double>* out) const {
  const auto add = [&](double r) {
    if (out != nullptr) out->push_back(r);
    sum += r * r;
  };
  if (overtravel_.known())
    add((specimen.core.travel - specimen.bridges.gap - overtravel_.value) / overtravel_.u);
  for (const auto& row : rows_) {
    if (sum > give_up) return sum;
    const Shot s = closing({specimen, Model::fitted}, row.angle, rated_volts, duration_, tolerance, force_);
    const std::array<double, quantities> model{s.touch, s.seat, s.touch_speed, s.seat_speed, s.force_peak};
    for (std::size_t q = 0; q < quantities; ++q)
      if (row.of[q].known()) add(s.closed ? (model[q] - row.of[q].value) / row.of[q].u : never);
  }
  return sum;
}

std::vector<double> ChannelMisfit::residuals(std::span<const double> point) const {
  auto list = kind_.residuals(point, tolerance);
  rows(specimen(point), 0, std::numeric_limits<double>::infinity(), &list);
  return list;
}

double ChannelMisfit::value(std::span<const double> point, double give_up) const {
  const auto s = specimen(point);
  if (!sim::validate(s).empty()) return 1e9;
  const double sum = kind_.value(point, give_up);
  return sum > give_up ? sum : rows(s, sum, give_up, nullptr);
}

ChannelMisfit ChannelMisfit::shifted(Random& random) const {
  ChannelMisfit moved = *this;
  const auto move = [&](Measured& m) {
    const double by = random.normal();
    if (m.known()) m.value += by * m.u;
  };
  move(moved.overtravel_);
  for (auto& row : moved.rows_)
    for (auto& m : row.of) move(m);
  std::vector<double> prior(dimension());
  for (double& p : prior) p = random.normal();
  moved.kind_ = kind_.perturbed({}, prior);
  return moved;
}

std::vector<double> start_point(const Campaign& campaign, std::uint64_t seed, sim::Team& team) {
  const ChannelMisfit misfit(campaign, {});
  sim::Evolution::Settings settings;
  settings.dimension = misfit.dimension();
  settings.evaluations = 400;
  settings.population = 40;
  settings.seed = seed;
  sim::Evolution coarse(settings,
                        [&](std::span<const double> p, double give_up) { return misfit.value(p, give_up); });
  while (coarse.step(team)) {
  }
  const auto residuals = [&](std::span<const double> p) { return misfit.residuals(p); };
  return sim::refine(residuals, coarse.best().point, {.iterations = 12, .step = step}, team).point;
}

std::vector<std::vector<double>> channel_samples(const ChannelMisfit& misfit, std::vector<double> start,
                                                 int samples, std::uint64_t seed, sim::Team& team) {
  constexpr int near = 8;  // evaluations of a sample
  const auto residuals_of = [](const ChannelMisfit& m) {
    return [&m](std::span<const double> p) { return m.residuals(p); };
  };
  const auto residuals = residuals_of(misfit);
  const auto best = sim::refine(residuals, std::move(start), {.iterations = 2, .step = step}, team);
  const auto at_best = sim::jacobian(residuals, best.point, best.residuals, step, team);
  Random random(seed);
  std::vector<std::vector<double>> list;
  for (int k = 0; k < samples; ++k) {
    const ChannelMisfit moved = misfit.shifted(random);
    const auto of_one = [&](std::span<const sim::PointOf> points) {
      return std::vector<std::vector<double>>{moved.residuals(points.front().point)};
    };
    list.push_back(sim::refine_near(of_one, 1, best.point, at_best, near).front().point);
  }
  return list;
}

}  // namespace powbench::bench
