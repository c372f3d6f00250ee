#include "host/study/fit_job.h"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>

#include "core/random.h"
#include "host/config/bad_input.h"
#include "host/config/specimen_file.h"
#include "host/store/hash.h"
#include "host/study/fit_point.h"
#include "host/study/problem.h"

namespace powbench::host {
namespace {

/// Numbers of a member in the units of the specimen file.
std::vector<double> values_of(const sim::Specimen& s, const std::vector<sim::Parameter>& parameters) {
  std::vector<double> values;
  for (const auto& p : parameters) values.push_back(rounded(p.field->get(s) / p.field->si_per_unit));
  return values;
}

FitFold fold_of(const sim::FitResult& r, const std::vector<sim::Parameter>& parameters) {
  FitFold f;
  f.misfit = r.best.misfit;
  f.members.push_back(values_of(r.best.specimen, parameters));
  for (const auto& m : r.ensemble) f.members.push_back(values_of(m.specimen, parameters));
  return f;
}

/// Searches of one fit as one: the best first, then all members of searches that came near it.
FitFold together(std::span<const FitFold> searches) {
  constexpr double near = 1.5;  // times the smallest misfit
  FitFold all = *std::min_element(searches.begin(), searches.end(),
                                  [](const FitFold& a, const FitFold& b) { return a.misfit < b.misfit; });
  const auto best = all.members.front();
  for (const auto& s : searches) {
    if (s.misfit > near * all.misfit || s.members.front() == best) continue;
    all.members.insert(all.members.end(), s.members.begin(), s.members.end());
  }
  return all;
}

/// Added to the seed of the describing fit: it has a random stream of its own.
constexpr std::uint64_t describing_stream = 1;

/// A posterior or search was told to stop.
struct Stopped {};

using GoOn = std::function<bool(long used, long of, double best)>;

/// Posterior number `k`: of all closings but one that is held out, or, after those, of all. Nothing: of another shard.
std::optional<FitFold> blind_fold(const FitJob& job, std::size_t k, sim::Team& team, const GoOn& go_on,
                                  Points& points) {
  sim::FitProblem problem = job.problem;
  if (!job.posterior_parameters.empty()) problem.parameters = job.posterior_parameters;
  const bool held_out = k < job.held_out.size();
  if (held_out) problem.closings = without(problem.closings, std::span(&job.held_out[k], 1));
  sim::PosteriorOptions options = job.posterior;
  options.seed = job.options.seed;
  const auto compute = [&] {
    const sim::Misfit misfit(problem);
    const auto of = static_cast<double>(job.options.evaluations);
    const auto posterior = sim::sample_posterior(misfit, options, team, [&](double share, double best) {
      return go_on(std::lround(share * of), job.options.evaluations, best);
    });
    if (posterior.stopped) throw Stopped();
    FitFold fold;
    fold.misfit = posterior.misfit;
    for (const auto& point : posterior.samples)
      fold.members.push_back(values_of(misfit.specimen(point), problem.parameters));
    fold.bounce = rounded(posterior.bounce);
    return bytes_of(fold);
  };
  const auto bytes = points.get(static_cast<std::int64_t>(k), basis_of(problem, options), compute);
  if (!bytes) return std::nullopt;
  FitFold fold = fold_of_bytes(*bytes);
  if (held_out) fold.held_out = rounded(degrees(job.held_out[k]));
  return fold;
}

/// A fit that is to describe, not to predict: relative errors in units of what is wanted of their means. Bounds rule
/// out; beyond that the middle of a range is no better than its ends.
sim::FitProblem describing(sim::FitProblem problem) {
  constexpr double touch = 0.02, seat = 0.02, bounce = 0.08, settled = 0.03;
  constexpr double share = 0.5;  // of the wanted error that weighs as much as a range left by one deviation
  problem.prior_deviation = 0;
  for (auto& m : problem.closings) {
    m.touch.u = share * touch * m.touch.value;
    m.seat.u = share * seat * m.seat.value;
    m.bounce.u = share * bounce * m.bounce.value;
    m.settled.u = share * settled * (m.touch.value + m.bounce.value);
  }
  return problem;
}

/// Where the last search begins: what the others found, and points about each of those.
std::vector<std::vector<double>> begin_finish(const FitJob& job, const FitFile& names,
                                              std::span<const FitFold> searches) {
  constexpr double spread = 0.05;  // of the bounds
  std::vector<std::vector<double>> points;
  for (const auto& fold : searches)
    for (const auto& s : specimens(names, fold)) points.push_back(sim::point_of(s, job.problem.parameters));
  const std::size_t found = points.size();
  Random random(job.options.seed + describing_stream);
  for (std::size_t k = found; k < 4 * found; ++k) {
    points.push_back(points[k % found]);
    for (double& u : points.back()) u = std::clamp(u + spread * random.normal(), 0.0, 1.0);
  }
  return points;
}

/// The fit to everything: searches from `blind` on, number `k` counted from there, the last one with `finish`.
sim::FitProblem search_problem(const FitJob& job, bool last) {
  sim::FitProblem problem = job.finish > 0 ? describing(job.problem) : job.problem;
  if (last) problem.absolute = true, problem.tolerance = 1e-5;
  return problem;
}

sim::FitOptions search_options(const FitJob& job, std::size_t k) {
  sim::FitOptions options = job.options;
  options.seed += 7919 * (k % static_cast<std::size_t>(job.searches));
  if (job.finish > 0) {
    options.evaluations = job.finish;
    options.seed += describing_stream;
  }
  return options;
}

}  // namespace

std::size_t blind_fits(const FitJob& job) {
  return job.held_out.size() + (job.unseen.empty() && job.next == 0 ? 0 : 1);
}

std::string problem_hash(const FitJob& job) {
  std::string text = resolved_text(job.problem.base) + job.problem.model.name;
  for (const auto& p : job.problem.parameters)
    text += fmt::format("{} {} {} {}\n", p.name(), p.low, p.high, p.logarithmic);
  for (const auto& m : job.problem.closings) {
    text += fmt::format("{} {} {} {} {} {} {} {}\n", m.conditions.closing_angle, m.conditions.supply_volts,
                        m.touch.value, m.touch.u, m.bounce.value, m.bounce.u, m.seat.value, m.seat.u);
    if (m.overtravel_time.known())
      text += fmt::format("overtravel {} {}\n", m.overtravel_time.value, m.overtravel_time.u);
  }
  for (const double angle : job.held_out) text += fmt::format("{} ", angle);
  for (const auto& point : job.start)
    for (const double u : point) text += fmt::format("{} ", u);
  const auto& o = job.options;
  text += fmt::format("{} {} {} {} {} {}", o.evaluations, o.polished, o.ensemble, o.seed, job.searches,
                      job.finish);
  for (const double angle : job.unseen) text += fmt::format(" {}", angle);
  if (job.next > 0) text += " all";
  const auto& q = job.posterior;
  text += fmt::format(" posterior with bounce factors and their number {} {} {} {} {}", q.evaluations,
                      q.starts, q.further_starts, q.samples, q.tolerance);
  for (const auto& p : job.posterior_parameters)
    text += fmt::format(" {} {} {}", p.low, p.high, p.logarithmic);
  if (job.problem.prior_deviation != sim::FitProblem{}.prior_deviation)
    text += fmt::format(" {}", job.problem.prior_deviation);
  return sha256_hex(text);
}

FitReport run_fits(const FitJob& job, sim::Team& team, const FitProgress& progress, const FitState& begun,
                   Points& points) {
  FitReport report;
  report.state = begun;
  report.part = points.part();
  const std::string hash = problem_hash(job);
  if (begun.problem.empty())
    report.state.problem = hash;
  else if (begun.problem != hash)
    throw BadInput(
        {"the state to go on from belongs to another problem; give the same data and options, or "
         "begin anew without it"});
  report.file.base = resolved_text(job.problem.base);
  for (const auto& p : job.problem.parameters) report.file.names.push_back(p.name());

  const std::size_t blind = blind_fits(job);
  const auto searches = static_cast<std::size_t>(job.searches);
  const std::size_t fits = blind + searches + (job.finish > 0 && !report.part ? 1 : 0);
  auto& done = report.state.done;
  const auto search = [&](std::size_t k, const GoOn& go_on) -> std::optional<sim::FitResult> {
    const bool last = k == blind + searches;
    const sim::Misfit misfit(search_problem(job, last));
    sim::FitOptions options = search_options(job, k - blind);
    auto start = job.start;
    if (last) {
      start = begin_finish(job, report.file, std::span(done).last(searches));
      options.population = start.size();
      options.polished = options.ensemble = 0;
    }
    sim::FitWatch watch;
    watch.save = [&](const sim::Evolution::State& s) { report.state.running = s; };
    watch.go_on = go_on;
    const auto compute = [&] {
      const auto resumed = report.state.running;
      auto result = sim::fit(misfit, options, team, watch, resumed ? &*resumed : nullptr, start);
      if (result.stopped) throw Stopped();
      return result;
    };
    if (last) return compute();
    const auto bytes = points.get(static_cast<std::int64_t>(k), basis_of(misfit.problem(), options, start),
                                  [&] { return bytes_of(compute()); });
    return bytes ? std::optional(result_of_bytes(*bytes, misfit)) : std::nullopt;
  };
  try {
    for (std::size_t k = done.size(); k < fits; ++k) {
      const auto go_on = [&](long used, long of, double best) {
        return progress(k, fits, used, of, best, report.state);
      };
      // a part keeps its points alone: their places among the folds are not filled
      if (k < blind) {
        auto fold = blind_fold(job, k, team, go_on, points);
        if (!report.part) done.push_back(std::move(*fold));
        continue;
      }
      auto result = search(k, go_on);
      report.state.running.reset();
      if (report.part) continue;
      done.push_back(fold_of(*result, job.problem.parameters));
      const bool last = k == blind + searches;
      if (last || report.full.best.point.empty() || result->best.misfit < report.full.best.misfit)
        report.full = std::move(*result);
    }
  } catch (const Stopped&) {
    report.stopped = true;
  }
  if (report.stopped || report.part) return report;
  for (std::size_t k = 0; k < job.held_out.size(); ++k) report.file.folds.push_back(done[k]);
  if (job.next > 0) report.posterior = done[job.held_out.size()];
  for (const double angle : job.unseen) {
    report.file.folds.push_back(done[job.held_out.size()]);
    report.file.folds.back().held_out = rounded(degrees(angle));
  }
  report.file.folds.push_back(together(std::span(done).subspan(blind, searches)));
  auto& all = report.file.folds.back();
  if (job.finish > 0) {
    all.members.insert(all.members.begin(), done.back().members.front());
    all.misfit = done.back().misfit;
  }
  // after an interruption the best search may have been an earlier run's: its sensitivities are not known then
  if (report.full.best.misfit > all.misfit) report.full = {};
  return report;
}

}  // namespace powbench::host
