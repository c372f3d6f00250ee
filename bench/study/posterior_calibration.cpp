// Whether the posterior of `powbench fit` is as sure as it may be: campaigns of six angles of drawn devices, one angle
// held out, its measured touch, seat and bounce among what the posterior foretells.
//   bench_posterior_calibration [--campaigns N] [--model fitted|other|both] [--seed S] [--threads N] [--json PATH]
// fitted: devices from the density that the fit states of their kind, times with the deviations that it grants them:
// simulation-based calibration (Talts et al., arXiv 1804.06788). other: devices of another model, with
// the deviations of instruments, `drawn_device`.

#include <algorithm>
#include <array>
#include <boost/math/distributions/chi_squared.hpp>
#include <cmath>
#include <cstdio>
#include <cstdlib>
#include <cstring>
#include <fstream>
#include <nlohmann/json.hpp>
#include <string>

#include "bench/study/synthetic_device.h"
#include "core/cpu_time.h"
#include "core/units.h"
#include "host/compare/student.h"
#include "host/study/held_out.h"
#include "host/study/problem.h"
#include "sim/models/closing.h"
#include "sim/study/posterior.h"
#include "sim/team.h"

namespace {

using namespace powbench;
using Json = nlohmann::ordered_json;

constexpr std::size_t angles = 6;
constexpr double pitch = 30;  // deg
constexpr double duration = 60e-3;

struct Foretold {
  double measured = 0;
  host::Band band;
  double rank = std::nan("");  ///< share of what was foretold that lies below what was measured
};

struct Result {
  std::array<Foretold, 3> of;  ///< touch, seat, bounce
  double cpu = 0;
};
constexpr const char* names[] = {"touch", "seat", "bounce"};

sim::FitProblem problem_of(std::vector<sim::MeasuredClosing> closings) {
  sim::FitProblem p;
  p.parameters = sim::posterior_parameters();
  p.plausible = sim::catalogue_ranges();
  p.closings = std::move(closings);
  return p;
}

/// From the density that the fit states of its kind of contactor: prior, edges and ranges, pick-up and calm.
sim::Specimen from_prior(Random& random) {
  const sim::Misfit kind(problem_of({}));
  const double deviation = kind.problem().prior_deviation;
  for (;;) {
    std::vector<double> point(kind.dimension());
    double prior = 0;
    for (double& u : point) {
      do u = 0.5 + deviation * random.normal();
      while (u < 0 || u > 1);
      prior += std::pow((u - 0.5) / deviation, 2);
    }
    const double most = prior - 2 * std::log(random.uniform());
    if (kind.value(point, most) <= most) {
      return kind.specimen(point);
    }
  }
}

/// Six closings as `powbench fit` is given them; empty: one does not close.
std::vector<sim::MeasuredClosing> campaign(bench::Model model, Random& random) {
  const host::ModelDeviation granted;
  bench::Device device;
  long tried = 0;
  if (model == bench::Model::fitted)
    device.specimen = from_prior(random);
  else
    device = bench::drawn_device(random, model, tried);
  std::vector<sim::MeasuredClosing> list;
  for (std::size_t k = 0; k < angles; ++k) {
    sim::MeasuredClosing m;
    m.conditions.closing_angle = radians(pitch * static_cast<double>(k + 1));
    double touch, seat, bounce;
    if (model == bench::Model::fitted) {
      const auto t = sim::tried_closing(device.specimen, m.conditions, duration, 1e-6);
      if (!t.touch || !t.core_seat) return {};
      touch = *t.touch * (1 + granted.touch * random.normal());
      seat = *t.core_seat * (1 + granted.seat * random.normal());
      bounce = (*t.settled - *t.touch) * std::exp(granted.bounce * random.normal());
    } else {
      const auto shot = bench::measured(device, m.conditions.closing_angle, random);
      if (!shot.closed) return {};
      touch = shot.touch, seat = shot.seat, bounce = shot.bounce;
    }
    m.touch = {touch, granted.touch * touch};
    m.seat = {seat, granted.seat * seat};
    m.bounce = {bounce, granted.bounce * bounce};
    list.push_back(m);
  }
  return list;
}

/// Rank of `value` among the samples, each moved at random by one deviation.
double rank(const std::vector<double>& samples, double relative, double value, Random& random) {
  double below = 0;
  for (const double v : samples) below += v * (1 + relative * random.normal()) < value;
  return (below + random.uniform()) / static_cast<double>(samples.size() + 1);
}

/// Rank of `value` in the law that the band's sides are quantiles of.
double bounce_rank(const host::Band& band, double value) {
  const double deviation = std::log(band.high / band.median) / host::coverage_factor(sim::bounce_tail, 0.68);
  const double z = std::log(value / band.median) / deviation;
  return 0.5 * (1 + std::copysign(host::student_probability(std::fabs(z), sim::bounce_tail), z));
}

Result judged(bench::Model model, std::uint64_t seed, int number) {
  Result result;
  Random random(seed * 1'000'000 + static_cast<std::uint64_t>(number));
  std::vector<sim::MeasuredClosing> list;
  while (list.empty()) list = campaign(model, random);
  const auto out = static_cast<std::size_t>(number) % angles;
  const sim::MeasuredClosing hidden = list[out];
  list.erase(list.begin() + static_cast<std::ptrdiff_t>(out));

  sim::Team alone(1);
  const sim::Misfit misfit(problem_of(list));
  sim::PosteriorOptions options;
  options.seed = seed + static_cast<std::uint64_t>(number);
  const auto posterior = sim::sample_posterior(misfit, options, alone, [](double, double) { return true; });
  std::vector<sim::Specimen> specimens;
  for (const auto& point : posterior.samples) specimens.push_back(misfit.specimen(point));
  const host::ModelDeviation granted;
  const auto p = host::predict(specimens, hidden.conditions, posterior.bounce, {granted.touch, granted.seat});

  std::vector<double> touch, seat;
  for (const auto& s : specimens) {
    const auto t = sim::tried_closing(s, hidden.conditions, duration);
    if (t.touch && t.core_seat) touch.push_back(*t.touch), seat.push_back(*t.core_seat);
  }
  result.of[0] = {hidden.touch.value, p.touch, rank(touch, granted.touch, hidden.touch.value, random)};
  result.of[1] = {hidden.seat.value, p.seat, rank(seat, granted.seat, hidden.seat.value, random)};
  result.of[2] = {hidden.bounce.value, p.bounce, bounce_rank(p.bounce, hidden.bounce.value)};
  return result;
}

struct Options {
  int campaigns = 200;
  int threads = 1;
  std::uint64_t seed = 1;
};

Json print_model(bench::Model model, const Options& o) {
  std::vector<Result> results(static_cast<std::size_t>(o.campaigns));
  sim::Team team(o.threads);
  sim::for_each_index(team, o.campaigns, [&](int k) {
    const double before = thread_cpu_seconds();
    auto& result = results[static_cast<std::size_t>(k)];
    result = judged(model, o.seed, k);
    result.cpu = thread_cpu_seconds() - before;
  });
  double cpu = 0;
  for (const auto& r : results) cpu += r.cpu;
  const char* name = model == bench::Model::fitted ? "fitted" : "other";
  std::printf("\n%d campaigns, devices of the %s model, seed %llu, %.0f s CPU\n", o.campaigns, name,
              static_cast<unsigned long long>(o.seed), cpu);
  std::printf("%-8s %8s %8s %9s   %-40s %7s\n", "quantity", "foretold", "within %", "error %", "ranks", "p");
  Json json{{"model", name}, {"campaigns", o.campaigns}, {"cpu_s", cpu}, {"rows", Json::array()}};
  for (std::size_t q = 0; q < std::size(names); ++q) {
    std::array<int, 10> tenths{};
    std::vector<double> errors;
    int within = 0, known = 0;
    for (const auto& r : results) {
      const Foretold& f = r.of[q];
      if (!std::isfinite(f.rank) || !std::isfinite(f.band.median)) continue;
      ++known;
      within += f.measured >= f.band.low && f.measured <= f.band.high;
      ++tenths[std::min<std::size_t>(9, static_cast<std::size_t>(10 * f.rank))];
      errors.push_back(std::fabs(f.band.median / f.measured - 1));
    }
    double chi = 0;
    std::string ranks;
    for (const int n : tenths) {
      chi += std::pow(n - known / 10.0, 2) / (known / 10.0);
      ranks += std::to_string(n) + ' ';
    }
    const double p = boost::math::cdf(boost::math::complement(boost::math::chi_squared(9), chi));
    const double share = 100.0 * within / known, error = 100 * bench::median_of(errors);
    std::printf("%-8s %8d %8.1f %9.2f   %-40s %7.3f\n", names[q], known, share, error, ranks.c_str(), p);
    json["rows"].push_back({{"quantity", names[q]},
                            {"foretold", known},
                            {"within_percent", share},
                            {"median_error_percent", error},
                            {"ranks", tenths},
                            {"p", p}});
  }
  return json;
}

}  // namespace

int main(int argc, char** argv) {
  Options options;
  std::string path, model = "both";
  for (int i = 1; i + 1 < argc; i += 2) {
    const auto is = [&](const char* name) { return std::strcmp(argv[i], name) == 0; };
    if (is("--campaigns")) options.campaigns = std::max(10, std::atoi(argv[i + 1]));
    if (is("--model")) model = argv[i + 1];
    if (is("--json")) path = argv[i + 1];
    if (is("--seed")) options.seed = std::strtoull(argv[i + 1], nullptr, 10);
    if (is("--threads")) options.threads = std::max(1, std::atoi(argv[i + 1]));
  }
  std::printf(
      "six angles, one held out, foretold from the other five\n"
      "within: measured values within the band of 16 .. 84 %%; error: median of |median / measured - 1|\n"
      "ranks: how many in each tenth of what was foretold, p by chi-square with 9 degrees of freedom\n");
  Json json = Json::array();
  if (model != "other") json.push_back(print_model(bench::Model::fitted, options));
  if (model != "fitted") json.push_back(print_model(bench::Model::other, options));
  if (!path.empty()) std::ofstream(path) << json.dump(1) << "\n";
  return 0;
}
