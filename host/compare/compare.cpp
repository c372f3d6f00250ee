#include "host/compare/compare.h"

#include <algorithm>
#include <cmath>

#include "core/commanded_phase.h"
#include "core/phase.h"
#include "core/quantities.h"
#include "host/compare/repeats.h"
#include "host/compare/student.h"

namespace powbench::host {
namespace {

/// Hundredths of a degree; an unknown angle stands behind all others.
CentiDegrees place(double angle) {
  return std::isfinite(angle) ? to_centi_degrees(angle) : full_turn_centi;
}

std::vector<Measured> values_of(const Quantity& q, const std::vector<Events>& all) {
  std::vector<Measured> values;
  for (const auto& events : all) values.push_back(q.of(events));
  return values;
}

void add_published(ComparisonRow& row, std::span<const PublishedRow> published) {
  for (const auto& p : published) {
    if (p.quantity != row.quantity || !std::isfinite(p.theta_deg)) continue;
    if (!same_angle(radians(p.theta_deg), row.closing_angle)) continue;
    row.published_measurement = p.measurement * si_per(p.unit);
    row.published_simulation = p.simulation * si_per(p.unit);
  }
}

Outcome outcome_of(const ComparisonRow& row, const std::vector<Measured>& values,
                   const std::vector<Limit>& limits, Decision rule) {
  bool limited = false;
  Outcome worst = Outcome::pass;
  for (const auto& limit : limits) {
    if (limit.quantity != row.quantity) continue;
    limited = true;
    if (values.empty()) return Outcome::error;
    for (const auto& m : values) worst = worse(worst, limit.of(m, rule));
  }
  return limited ? worst : Outcome::not_judged;
}

/// The mean against the simulation; guarded: with the U of their difference.
Outcome simulation_outcome(const ComparisonRow& row, Decision rule, double most) {
  if (!std::isfinite(most) || !std::isfinite(row.simulated)) return Outcome::not_judged;
  if (!row.measured.known()) return Outcome::not_observed;
  const double guard = rule == Decision::guarded ? row.expanded_difference() : 0.0;
  if (!std::isfinite(guard)) return Outcome::not_judged;
  const double difference = std::fabs(row.simulated - row.measured.value) + guard;
  return difference > most * std::fabs(row.measured.value) ? Outcome::fail : Outcome::pass;
}

/// Standard deviation of measured less simulated, the latter for each closing at its own conditions.
double unexplained_scatter(const Quantity& q, const AngleGroup& group) {
  if (group.moved.size() != group.measured.size()) return unknown;
  std::vector<Measured> left;
  for (std::size_t i = 0; i < group.measured.size(); ++i) {
    const auto by = group.moved[i].find(std::string(q.symbol));
    if (by == group.moved[i].end()) return unknown;
    Measured m = q.of(group.measured[i]);
    m.value -= by->second;
    left.push_back(m);
  }
  return repeats_of(left).scatter;
}

/// The channel of a first touch or seat is there on both sides, and the event on one of them alone.
bool seen_in_one(const ComparisonRow& row, const AngleGroup& group) {
  const auto by = [&](const std::vector<Events>& all) {
    return !all.empty() && std::all_of(all.begin(), all.end(), [&](const Events& e) {
      return row.quantity == "t_ct1" ? timing_train(e).present : row.quantity == "t_xt1" && e.core.present;
    });
  };
  return row.measured.known() != std::isfinite(row.simulated) && by(group.measured) && by(group.simulated);
}

ComparisonRow row_of(const Quantity& q, const AngleGroup& group, std::span<const PublishedRow> published,
                     const std::vector<Limit>& limits, Decision rule, double most_from_simulation) {
  const auto measured = values_of(q, group.measured);
  const Repeats r = repeats_of(measured);
  ComparisonRow row;
  row.closing_angle = group.closing_angle;
  row.quantity = q.symbol;
  row.unit = q.unit;
  row.repeats = r.n;
  row.closings = static_cast<int>(group.measured.size());
  row.measured = {r.mean, r.u};
  row.scatter = r.scatter;
  row.dof = r.dof;
  row.coverage = r.coverage;
  row.lowest = r.lowest;
  row.highest = r.highest;
  row.two_modes = r.two_modes;
  row.simulated = repeats_of(values_of(q, group.simulated)).mean;
  row.seen_in_one = seen_in_one(row, group);
  row.unexplained = unexplained_scatter(q, group);
  if (const auto u = group.u_simulated.find(row.quantity); u != group.u_simulated.end())
    row.u_simulated = u->second, row.u_simulated_unknown = !std::isfinite(u->second);
  if (row.measured.u > 0 && row.u_simulated > 0) {  // the inputs' share has infinite degrees of freedom
    const double whole = 1 + row.u_simulated * row.u_simulated / (row.measured.u * row.measured.u);
    row.coverage_difference = coverage_factor(row.dof * whole * whole);
  }
  row.outcome = outcome_of(row, measured, limits, rule);
  row.against_simulation = simulation_outcome(row, rule, most_from_simulation);
  add_published(row, published);
  return row;
}

}  // namespace

double effective_angle(const Conditions& c) {
  if (!std::isfinite(c.closing_angle)) return c.closing_angle;
  return wrap_turn(commanded_phase(c));
}

double stored_degrees(double angle) {
  return std::isfinite(angle) ? to_centi_degrees(angle) / 100.0 : std::numeric_limits<double>::quiet_NaN();
}

bool same_angle(double a, double b) {
  return place(a) == place(b);
}

AngleGroup& group_at(std::vector<AngleGroup>& groups, double closing_angle) {
  const auto wanted = place(closing_angle);
  auto at = std::find_if(groups.begin(), groups.end(),
                         [&](const AngleGroup& g) { return place(g.closing_angle) >= wanted; });
  if (at == groups.end() || place(at->closing_angle) != wanted)
    at = groups.insert(
        at, AngleGroup{std::isfinite(closing_angle) ? wrap_turn(closing_angle) : closing_angle, {}, {}, {}});
  return *at;
}

Comparison compare(std::vector<AngleGroup> groups, std::span<const PublishedRow> published,
                   const std::vector<Limit>& limits, Decision rule, double most_from_simulation) {
  std::stable_sort(groups.begin(), groups.end(), [](const AngleGroup& a, const AngleGroup& b) {
    return place(a.closing_angle) < place(b.closing_angle);
  });
  Comparison all;
  for (const auto& quantity : quantity_table)
    for (const auto& group : groups)
      all.rows.push_back(row_of(quantity, group, published, limits, rule, most_from_simulation));
  return all;
}

std::vector<const ComparisonRow*> ranked(const Comparison& comparison) {
  std::vector<const ComparisonRow*> rows;
  for (const auto& row : comparison.rows)
    if (std::isfinite(row.difference_over_U())) rows.push_back(&row);
  std::stable_sort(rows.begin(), rows.end(), [](const auto* a, const auto* b) {
    return a->difference_over_U() > b->difference_over_U();
  });
  return rows;
}

}  // namespace powbench::host
