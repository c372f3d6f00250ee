#include "host/compare/compare.h"

#include <algorithm>
#include <cmath>

#include "core/phase.h"
#include "core/quantities.h"
#include "host/compare/repeats.h"

namespace powbench::host {
namespace {

std::vector<Measured> values_of(const Quantity& q, const std::vector<Events>& all) {
  std::vector<Measured> values;
  for (const auto& events : all) values.push_back(q.of(events));
  return values;
}

void add_published(ComparisonRow& row, std::span<const PublishedRow> published) {
  for (const auto& p : published) {
    if (p.quantity != row.quantity || !std::isfinite(p.theta_deg)) continue;
    if (to_centi_degrees(radians(p.theta_deg)) != to_centi_degrees(row.closing_angle)) continue;
    row.published_measurement = p.measurement * si_per(p.unit);
    row.published_simulation = p.simulation * si_per(p.unit);
  }
}

Outcome outcome_of(const std::string& quantity, const std::vector<Measured>& values,
                   const std::vector<Limit>& limits) {
  if (values.empty()) return Outcome::error;
  for (const auto& limit : limits)
    if (limit.quantity == quantity)
      for (const auto& m : values)
        if (!limit.allows(m)) return Outcome::fail;
  return Outcome::pass;
}

ComparisonRow row_of(const Quantity& q, const AngleGroup& group, std::span<const PublishedRow> published,
                     const std::vector<Limit>& limits) {
  const auto measured = values_of(q, group.measured);
  const Repeats r = repeats_of(measured);
  ComparisonRow row;
  row.closing_angle = group.closing_angle;
  row.quantity = q.symbol;
  row.unit = q.unit;
  row.repeats = r.n;
  row.measured = {r.mean, r.u};
  row.scatter = r.scatter;
  row.dof = r.dof;
  row.coverage = r.coverage;
  row.lowest = r.lowest;
  row.highest = r.highest;
  row.two_modes = r.two_modes;
  row.simulated = repeats_of(values_of(q, group.simulated)).mean;
  row.outcome = outcome_of(row.quantity, measured, limits);
  add_published(row, published);
  return row;
}

}  // namespace

double effective_angle(const Conditions& c) {
  return wrap_turn(c.closing_angle + (c.polarity < 0 ? pi : 0.0));
}

AngleGroup& group_at(std::vector<AngleGroup>& groups, double closing_angle) {
  const auto centi = to_centi_degrees(closing_angle);
  auto at = std::find_if(groups.begin(), groups.end(),
                         [&](const AngleGroup& g) { return to_centi_degrees(g.closing_angle) >= centi; });
  if (at == groups.end() || to_centi_degrees(at->closing_angle) != centi)
    at = groups.insert(at, AngleGroup{wrap_turn(closing_angle), {}, {}});
  return *at;
}

Comparison compare(std::vector<AngleGroup> groups, std::span<const PublishedRow> published,
                   const std::vector<Limit>& limits) {
  std::stable_sort(groups.begin(), groups.end(), [](const AngleGroup& a, const AngleGroup& b) {
    return a.closing_angle < b.closing_angle;
  });
  Comparison all;
  for (const auto& quantity : quantity_table)
    for (const auto& group : groups) all.rows.push_back(row_of(quantity, group, published, limits));
  return all;
}

}  // namespace powbench::host
