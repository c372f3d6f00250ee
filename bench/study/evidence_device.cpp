#include "bench/study/evidence_device.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <span>

#include "bench/study/bounce_rules.h"
#include "bench/study/channel_fit.h"
#include "core/units.h"
#include "host/compare/student.h"
#include "sim/study/bounce_calibration.h"

namespace powbench::bench {
namespace {

constexpr int most_angles = 48;
constexpr double shortest = 20e-6;  // s: what bounces for less does not bounce
constexpr double rated_volts = 230;

double log_bounce(const Shot& s) {
  return std::log(std::max(s.bounce, shortest));
}

/// Share by which a predicted bounce misses a measured one; 1 at most.
double miss(double predicted_log, const Shot& measured) {
  return std::min(1.0, std::fabs(std::expm1(predicted_log - log_bounce(measured))));
}

using Features = std::vector<double> (*)(const Shot&);
std::vector<double> no_features(const Shot&) {
  return {};
}
std::vector<double> of_interval(const Shot& s) {
  return {s.seat - s.touch};
}
std::vector<double> of_settling(const Shot& s) {
  return {s.core_settled - s.touch};
}
std::vector<double> of_force(const Shot& s) {
  return {s.force_peak};
}
std::vector<double> of_speeds(const Shot& s) {
  return {s.touch_speed, s.seat_speed};
}
std::vector<double> of_all(const Shot& s) {
  return {s.seat - s.touch, s.core_settled - s.touch, s.force_peak, s.touch_speed, s.seat_speed};
}

/// Within a factor of 4 of their median: a closing without any bounce must not bend a line.
std::vector<double> tempered(std::vector<double> logs) {
  const double middle = median_of(logs), most = std::log(4.0);
  for (double& v : logs) v = std::clamp(v, middle - most, middle + most);
  return logs;
}

std::vector<Known> known_of(const std::vector<Shot>& shots, Features features) {
  std::vector<double> logs;
  for (const auto& s : shots) logs.push_back(log_bounce(s));
  logs = tempered(std::move(logs));
  std::vector<Known> list;
  for (std::size_t k = 0; k < shots.size(); ++k)
    list.push_back({shots[k].angle, logs[k], features(shots[k])});
  return list;
}

/// An angle that no campaign has, closed several times.
struct HeldOut {
  double angle = 0;
  std::vector<Shot> shots;
};

/// What the fit says of a list of angles: for each posterior sample the closing there.
using Simulated = std::vector<std::vector<Shot>>;  ///< [sample][angle]

Simulated simulated(const ChannelMisfit& misfit, const std::vector<std::vector<double>>& samples,
                    std::span<const double> angles) {
  constexpr double duration = 60e-3, tolerance = 1e-4;
  Simulated list;
  for (const auto& point : samples) {
    auto& of_sample = list.emplace_back();
    for (const double a : angles)
      of_sample.push_back(
          closing({misfit.specimen(point), Model::fitted}, a, rated_volts, duration, tolerance, false));
  }
  return list;
}

Shot middle_of(const Simulated& list, std::size_t angle) {
  std::vector<Shot> closed;
  for (const auto& sample : list)
    if (sample[angle].closed) closed.push_back(sample[angle]);
  return closed.empty() ? list.front()[angle] : median_shot(closed);
}

double middle_log(const Simulated& list, std::size_t angle) {
  std::vector<double> logs;
  for (const auto& sample : list)
    if (sample[angle].closed) logs.push_back(log_bounce(sample[angle]));
  return logs.empty() ? std::log(shortest) : median_of(logs);
}

struct Tally {
  double sum = 0, n = 0;
  void add(double v) { sum += v, n += 1; }
  double mean() const { return n > 0 ? sum / n : std::nan(""); }
};

/// The median of the other shots of the same angle: nothing predicts better without seeing the shot.
double floor_of(std::span<const HeldOut> held_out) {
  Tally t;
  for (const auto& h : held_out)
    for (std::size_t k = 0; k < h.shots.size(); ++k) {
      std::vector<double> others;
      for (std::size_t i = 0; i < h.shots.size(); ++i)
        if (i != k) others.push_back(log_bounce(h.shots[i]));
      t.add(miss(median_of(others), h.shots[k]));
    }
  return t.mean();
}

constexpr double (*rules[])(const std::vector<Known>&, double, const std::vector<double>&) = {
    median_rule, nearest_rule, interpolation_rule, harmonic_rule};
template <std::size_t n>
using Tallies = std::array<Tally, n>;
using RuleTallies = Tallies<7>;
using FitTallies = Tallies<8>;

void judge_rules(const std::vector<Shot>& shots, std::span<const HeldOut> held_out, RuleTallies& t) {
  const auto known = known_of(shots, no_features);
  for (const auto& h : held_out) {
    const Blend smooth = blended(known, {}, h.angle, 0);
    for (const auto& shot : h.shots) {
      for (std::size_t r = 0; r < std::size(rules); ++r) t[r].add(miss(rules[r](known, h.angle, {}), shot));
      t[4].add(miss(smooth.log_bounce, shot));
      t[5].add(std::fabs(smooth.log_bounce - log_bounce(shot)) <= smooth.deviation);
    }
  }
  t[6].add(floor_of(held_out));
}

/// The fit of one campaign, as far as bounces are concerned.
struct Fitted {
  Simulated at_known, at_held_out;
  sim::BounceCalibration calibration;
};

Fitted fitted(const Campaign& campaign, const Channels& channels, const std::vector<double>& start,
              std::span<const HeldOut> held_out, int count, std::uint64_t seed) {
  sim::Team team(1);
  const ChannelMisfit misfit(campaign, channels);
  const auto samples = channel_samples(misfit, start, count, seed, team);
  std::vector<double> known_angles, angles, measured;
  for (const auto& s : campaign.shots) known_angles.push_back(s.angle), measured.push_back(s.bounce);
  for (const auto& h : held_out) angles.push_back(h.angle);
  Fitted f{simulated(misfit, samples, known_angles), simulated(misfit, samples, angles), {}};
  std::vector<std::vector<double>> bounces;
  for (const auto& sample : f.at_known) {
    auto& list = bounces.emplace_back();
    for (const auto& s : sample) list.push_back(s.bounce);
  }
  f.calibration = sim::calibrate_bounce(bounces, measured, known_angles);
  return f;
}

/// Median over the calibrated samples, ln.
double alone(const Fitted& f, std::size_t h) {
  std::vector<double> own;
  for (std::size_t k = 0; k < f.at_held_out.size(); ++k)
    if (f.at_held_out[k][h].closed)
      own.push_back(log_bounce(f.at_held_out[k][h]) + std::log(f.calibration.factors[k]));
  return own.empty() ? std::log(f.calibration.median) : median_of(own);
}

void judge(const Campaign& campaign, const Channels& channels, const std::vector<double>& start,
           std::span<const HeldOut> held_out, const EvidenceOptions& options, std::uint64_t seed,
           FitTallies& t) {
  const Fitted f = fitted(campaign, channels, start, held_out, options.samples, seed);
  const auto known = known_of(campaign.shots, no_features);
  std::vector<double> model;
  for (std::size_t k = 0; k < known.size(); ++k) model.push_back(middle_log(f.at_known, k));
  for (const auto& h : held_out) {
    const auto place = static_cast<std::size_t>(&h - held_out.data());
    auto logs = model;
    logs.push_back(middle_log(f.at_held_out, place));
    logs = tempered(std::move(logs));
    const double at_held_out = logs.back();
    logs.pop_back();
    const double own = alone(f, place);
    const auto fit = sim::pooled_bounce(std::exp(own), f.calibration, h.angle);
    const Blend blend = blended(known, logs, h.angle, at_held_out), data = blended(known, {}, h.angle, 0);
    const Shot middle = middle_of(f.at_held_out, place);
    const double side = sim::bounce_core * host::coverage_factor(sim::bounce_tail, 0.68) * fit.deviation;
    for (const auto& shot : h.shots) {
      const double at = log_bounce(shot), of_blend = miss(blend.log_bounce, shot);
      t[0].add(miss(std::log(fit.value), shot));
      t[1].add(std::fabs(std::log(fit.value) - at) <= side);
      t[2].add(miss(own, shot));
      t[3].add(of_blend);
      t[4].add(std::fabs(blend.log_bounce - at) <= blend.deviation);
      t[5].add(of_blend - miss(data.log_bounce, shot));
      t[6].add(blend.share);
      t[7].add(std::min(1.0, std::fabs(middle.touch / shot.touch - 1)));
    }
  }
}

template <std::size_t n>
std::vector<double> cells_of(const Tallies<n>& t) {
  std::vector<double> cells;
  for (const auto& tally : t) cells.push_back(tally.mean());
  return cells;
}

/// A line of ln(bounce) on what is measured of the very closing.
std::vector<double> seen(const std::vector<Shot>& shots, std::span<const HeldOut> held_out) {
  std::vector<double> cells;
  for (const Features f : {no_features, of_interval, of_settling, of_force, of_speeds, of_all}) {
    const auto known = known_of(shots, f);
    Tally t;
    for (const auto& h : held_out)
      for (const auto& s : h.shots) t.add(miss(feature_rule(known, h.angle, f(s)), s));
    cells.push_back(t.mean());
  }
  cells.push_back(floor_of(held_out));
  return cells;
}

std::vector<Shot> every(const std::vector<Shot>& shots, std::size_t step) {
  std::vector<Shot> list;
  for (std::size_t k = 0; k < shots.size(); k += step) list.push_back(shots[k]);
  return list;
}

HeldOut closed_often(const Device& device, double angle, Random& random) {
  constexpr int shots = 9;
  HeldOut h{angle, {}};
  for (int k = 0; k < shots; ++k)
    if (const Shot s = measured(device, angle, random); s.closed) h.shots.push_back(s);
  return h;
}

void describe(const std::vector<Shot>& shots, DeviceResult& result) {
  Tally mean, squares;
  std::vector<double> bounces;
  for (const auto& shot : shots)
    mean.add(log_bounce(shot)), squares.add(std::pow(log_bounce(shot), 2)), bounces.push_back(shot.bounce);
  result.spread = std::sqrt(std::max(0.0, squares.mean() - mean.mean() * mean.mean()));
  result.bounce = median_of(bounces);
}

constexpr Channels channel_sets[] = {{"touch, bounce, seat"},
                                     {"+ overtravel", true},
                                     {"+ force peak", false, true},
                                     {"+ speeds", false, false, true},
                                     {"+ all of these", true, true, true}};

}  // namespace

std::vector<std::string> rule_columns() {
  return {"median", "nearest", "interpol.", "harmonic", "process", "band", "floor"};
}

std::vector<std::string> fit_columns() {
  return {"fit", "fit band", "samples", "blend", "band", "less proc.", "share", "touch"};
}

std::vector<std::string> seen_columns() {
  return {"nothing", "seat-touch", "core still", "force", "speeds", "all", "floor"};
}

DeviceResult study_device(const EvidenceOptions& options, int number) {
  DeviceResult result;
  const std::uint64_t seed = options.seed * 100'000 + static_cast<std::uint64_t>(number) * 100;
  Random random(seed);
  const Device device = drawn_device(random, options.model, result.tried);
  const auto& s = device.specimen;
  constexpr double of_gauge = 0.01, pitch = 180.0 / most_angles;
  const double overtravel = (s.core.travel - s.bridges.gap) * (1 + of_gauge * random.normal());
  std::vector<Shot> all, repeated;
  for (int k = 0; k < most_angles; ++k) all.push_back(measured(device, radians(pitch * k), random));
  const auto six = every(all, 8), twelve = every(all, 4), twenty_four = every(all, 2);
  for (const auto& shot : six) {
    std::vector<Shot> repeats{shot};
    for (int k = 1; k < 4; ++k) repeats.push_back(measured(device, shot.angle, random));
    repeated.push_back(median_shot(repeats));
  }
  std::vector<HeldOut> between;
  for (int k = 0; k < 12; ++k)
    between.push_back(closed_often(device, radians(15 * (k + random.uniform())), random));
  describe(all, result);

  // two angles of the six are left out in turn; all searches start where the four others alone lead
  const std::size_t left_out[] = {static_cast<std::size_t>(number % 3),
                                  static_cast<std::size_t>(number % 3 + 3)};
  Campaign common{{}, overtravel};
  std::vector<HeldOut> left;
  std::vector<std::vector<Shot>> five;
  for (std::size_t k = 0; k < six.size(); ++k)
    if (k != left_out[0] && k != left_out[1]) common.shots.push_back(six[k]);
  for (const std::size_t k : left_out) {
    left.push_back(closed_often(device, six[k].angle, random));
    five.push_back(six);
    five.back().erase(five.back().begin() + static_cast<std::ptrdiff_t>(k));
  }

  const auto rules_row = [&](const char* angles, const std::vector<Shot>& shots) {
    RuleTallies t;
    judge_rules(shots, between, t);
    result.rules.push_back({"", angles, cells_of(t)});
  };
  RuleTallies fives;
  for (std::size_t k = 0; k < 2; ++k) judge_rules(five[k], std::span(&left[k], 1), fives);
  result.rules.push_back({"", "6 - 1", cells_of(fives)});
  rules_row("6", six);
  rules_row("6 x 4", repeated);
  rules_row("12", twelve);
  rules_row("24", twenty_four);
  rules_row("48", all);
  for (const auto& shots : {six, twelve, twenty_four, all})
    result.seen.push_back({"", std::to_string(shots.size()), seen(shots, between)});
  if (options.samples == 0) return result;

  sim::Team team(1);
  const auto start = start_point(common, seed + 1, team);
  std::uint64_t stream = seed + 10;
  for (const auto& channels : std::span(channel_sets).first(options.sets)) {
    FitTallies of_five;
    for (std::size_t k = 0; k < 2; ++k)
      judge({five[k], overtravel}, channels, start, std::span(&left[k], 1), options, ++stream, of_five);
    result.fits.push_back({channels.name, "6 - 1", cells_of(of_five)});
    const auto row = [&](const char* angles, const std::vector<Shot>& shots) {
      FitTallies t;
      judge({shots, overtravel}, channels, start, between, options, ++stream, t);
      result.fits.push_back({channels.name, angles, cells_of(t)});
    };
    row("6", six);
    if (&channels == channel_sets) row("6 x 4", repeated);
    row("12", twelve);
    row("24", twenty_four);
  }
  return result;
}

}  // namespace powbench::bench
