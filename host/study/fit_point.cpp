#include "host/study/fit_point.h"

#include <fmt/format.h>

#include "host/config/specimen_file.h"
#include "host/store/json.h"
#include "host/store/point_bytes.h"

namespace powbench::host {
namespace {

std::string range_text(const char* name, const std::optional<sim::PlausibleRange>& r) {
  return r ? fmt::format("{} {} {} {}\n", name, r->low, r->high, r->deviation) : std::string();
}

std::string plausible_text(const sim::Plausible& p) {
  return range_text("inrush", p.inrush) + range_text("holding", p.holding) +
         range_text("overtravel", p.overtravel) + range_text("contact_force", p.contact_force) +
         range_text("base_travel", p.base_travel) + range_text("held_load", p.held_load) +
         fmt::format("{} {} {}\n", p.pick_up, p.calm, p.rated_volts);
}

std::string problem_text(const sim::FitProblem& p) {
  std::string text = resolved_text(p.base) + p.model.name;
  for (const auto& q : p.parameters)
    text += fmt::format("{} {} {} {}\n", q.name(), q.low, q.high, q.logarithmic);
  for (const auto& m : p.closings) {
    text += to_json(m.conditions);
    for (const Measured* x : {&m.touch, &m.bounce, &m.seat, &m.core_bounce, &m.settled})
      text += fmt::format(" {} {}", x->value, x->u);
    if (m.overtravel_time.known())
      text += fmt::format(" overtravel {} {}", m.overtravel_time.value, m.overtravel_time.u);
    text += '\n';
  }
  text += plausible_text(p.plausible) + fmt::format("{} {} {} {} {} {}\n", p.prior_deviation, p.edge,
                                                    p.tolerance, p.duration, p.robust, p.absolute);
  for (const double x : p.prior_middle) text += fmt::format("{} ", x);
  return text;
}

void add(ByteWriter& out, const std::vector<std::vector<double>>& lists) {
  out.add(static_cast<std::int64_t>(lists.size()));
  for (const auto& list : lists) out.add(list);
}

std::vector<std::vector<double>> lists_of(ByteReader& in) {
  std::vector<std::vector<double>> lists;
  for (std::int64_t left = in.integer(); left > 0; --left) lists.push_back(in.numbers());
  return lists;
}

sim::FitMember member_of(ByteReader& in, const sim::Misfit& misfit) {
  sim::FitMember m;
  m.misfit = in.number();
  m.point = in.numbers();
  if (m.point.size() != misfit.dimension())
    throw StoreError(
        "a point of the store has another number of free numbers; compute it anew in another store");
  m.specimen = misfit.specimen(m.point);
  return m;
}

}  // namespace

std::string basis_of(const sim::FitProblem& problem, const sim::PosteriorOptions& o) {
  return "posterior\n" + problem_text(problem) +
         fmt::format("\n{} {} {} {} {} {}", o.evaluations, o.starts, o.further_starts, o.samples, o.tolerance,
                     o.seed);
}

std::string basis_of(const sim::FitProblem& problem, const sim::FitOptions& o,
                     const std::vector<std::vector<double>>& start) {
  std::string text = "search\n" + problem_text(problem) +
                     fmt::format("\n{} {} {} {} {} {}\n", o.evaluations, o.population, o.polished, o.ensemble,
                                 o.seed, o.tolerance);
  for (const auto& point : start)
    for (const double u : point) text += fmt::format("{} ", u);
  return text;
}

std::string bytes_of(const FitFold& f) {
  ByteWriter out;
  out.add(f.misfit);
  add(out, f.members);
  const sim::BounceCalibration none, &b = f.bounce ? *f.bounce : none;
  std::vector<double> angles, bounces;
  for (const auto& a : b.line) angles.push_back(a.angle), bounces.push_back(a.bounce);
  return out.add(static_cast<std::int64_t>(f.bounce ? 1 : 0))
      .add(b.factors)
      .add(b.deviation)
      .add(b.median)
      .add(b.median_deviation)
      .add(angles)
      .add(bounces)
      .add(b.line_deviation)
      .bytes();
}

FitFold fold_of_bytes(const std::string& bytes) {
  ByteReader in(bytes);
  FitFold f;
  f.misfit = in.number();
  f.members = lists_of(in);
  const bool with_bounce = in.integer() != 0;
  sim::BounceCalibration b;
  b.factors = in.numbers();
  b.deviation = in.number();
  b.median = in.number();
  b.median_deviation = in.number();
  const auto angles = in.numbers(), bounces = in.numbers();
  if (angles.size() != bounces.size())
    throw std::invalid_argument("angles and bounces of a line differ in number");
  for (std::size_t k = 0; k < angles.size(); ++k) b.line.push_back({angles[k], bounces[k]});
  b.line_deviation = in.number();
  if (with_bounce) f.bounce = b;
  return f;
}

std::string bytes_of(const sim::FitResult& r) {
  ByteWriter out;
  out.add(static_cast<std::int64_t>(r.evaluations)).add(r.best.misfit).add(r.best.point);
  out.add(static_cast<std::int64_t>(r.ensemble.size()));
  for (const auto& m : r.ensemble) out.add(m.misfit).add(m.point);
  return out.add(static_cast<std::int64_t>(r.sensitivity.rows))
      .add(static_cast<std::int64_t>(r.sensitivity.columns))
      .add(r.sensitivity.values)
      .bytes();
}

sim::FitResult result_of_bytes(const std::string& bytes, const sim::Misfit& misfit) {
  ByteReader in(bytes);
  sim::FitResult r;
  r.evaluations = static_cast<long>(in.integer());
  r.best = member_of(in, misfit);
  for (std::int64_t left = in.integer(); left > 0; --left) r.ensemble.push_back(member_of(in, misfit));
  r.sensitivity.rows = static_cast<std::size_t>(in.integer());
  r.sensitivity.columns = static_cast<std::size_t>(in.integer());
  r.sensitivity.values = in.numbers();
  r.identifiability = sim::identifiability(r.sensitivity, misfit.problem().prior_deviation);
  return r;
}

}  // namespace powbench::host
