#include "host/study/fit_job.h"

#include <fmt/format.h>

#include "host/config/bad_input.h"
#include "host/config/specimen_file.h"
#include "host/store/hash.h"
#include "host/study/problem.h"

namespace powbench::host {
namespace {

/// Numbers of a member in the units of the specimen file.
std::vector<double> values_of(const sim::Specimen& s, const std::vector<sim::Parameter>& parameters) {
  std::vector<double> values;
  for (const auto& p : parameters) values.push_back(rounded(p.field->get(s) / p.field->si_per_unit));
  return values;
}

FitFold fold_of(const sim::FitResult& r, const std::vector<sim::Parameter>& parameters,
                std::optional<double> held_out) {
  FitFold f;
  if (held_out) f.held_out = rounded(degrees(*held_out));
  f.misfit = r.best.misfit;
  f.members.push_back(values_of(r.best.specimen, parameters));
  for (const auto& m : r.ensemble) f.members.push_back(values_of(m.specimen, parameters));
  return f;
}

}  // namespace

std::string problem_hash(const FitJob& job) {
  std::string text = resolved_text(job.problem.base);
  for (const auto& p : job.problem.parameters)
    text += fmt::format("{} {} {} {}\n", p.name(), p.low, p.high, p.logarithmic);
  for (const auto& m : job.problem.closings)
    text += fmt::format("{} {} {} {} {} {} {} {}\n", m.conditions.closing_angle, m.conditions.supply_volts,
                        m.touch.value, m.touch.u, m.bounce.value, m.bounce.u, m.seat.value, m.seat.u);
  for (const double angle : job.held_out) text += fmt::format("{} ", angle);
  for (const auto& point : job.start)
    for (const double u : point) text += fmt::format("{} ", u);
  const auto& o = job.options;
  text += fmt::format("{} {} {} {}", o.evaluations, o.polished, o.ensemble, o.seed);
  return sha256_hex(text);
}

FitReport run_fits(const FitJob& job, sim::Team& team, const FitProgress& progress, const FitState& begun) {
  FitReport report;
  report.state = begun;
  const std::string hash = problem_hash(job);
  if (begun.problem.empty())
    report.state.problem = hash;
  else if (begun.problem != hash)
    throw BadInput(
        {"the state to go on from belongs to another problem; give the same data and options, or "
         "begin anew without it"});
  report.file.base = resolved_text(job.problem.base);
  for (const auto& p : job.problem.parameters) report.file.names.push_back(p.name());

  const std::size_t fits = 1 + job.held_out.size();
  // the fit to everything is made last: its sensitivities are wanted even when its search was done before
  for (std::size_t k = report.state.done.size(); k < fits; ++k) {
    const bool full = k + 1 == fits;
    sim::FitProblem problem = job.problem;
    if (!full) problem.closings = without(problem.closings, std::span(&job.held_out[k], 1));
    sim::FitWatch watch;
    watch.save = [&](const sim::Evolution::State& s) { report.state.running = s; };
    watch.go_on = [&](long used, long of, double best) {
      return progress(k, fits, used, of, best, report.state);
    };
    const auto resumed = report.state.running;
    const auto result =
        sim::fit(sim::Misfit(problem), job.options, team, watch, resumed ? &*resumed : nullptr,
                 full ? job.start : std::vector<std::vector<double>>{});
    if (result.stopped) {
      report.stopped = true;
      return report;
    }
    report.state.running.reset();
    report.state.done.push_back(fold_of(result, job.problem.parameters,
                                        full ? std::nullopt : std::optional<double>(job.held_out[k])));
    if (full) report.full = result;
  }
  report.file.folds = report.state.done;
  return report;
}

}  // namespace powbench::host
