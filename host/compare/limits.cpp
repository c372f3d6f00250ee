#include "host/compare/limits.h"

#include <fmt/format.h>

#include <cmath>
#include <stdexcept>
#include <string_view>

#include "core/phase.h"
#include "core/quantities.h"

namespace powbench::host {
namespace {

const Quantity& quantity_of(const Limit& limit) {
  const Quantity* q = find_quantity(limit.quantity);
  if (q == nullptr) throw std::invalid_argument("limit on unknown quantity " + limit.quantity);
  return *q;
}

/// A measured value: all five digits, so that 5.9000 does not read 5.9.
std::string digits(double value) {
  return fmt::format("{:#.5g}", value);
}

/// A limit is printed as it is applied, not rounded.
std::string plain(double value) {
  return fmt::format("{:.12g}", value);
}

bool in_milli(const Quantity& q) {
  return q.unit == "s";
}
double shown(const Quantity& q, double value) {
  return in_milli(q) ? value * 1e3 : value;
}
std::string unit_shown(const Quantity& q) {
  return in_milli(q) ? "ms" : std::string(q.unit);
}

}  // namespace

std::string_view decision_text(Decision d) {
  return d == Decision::simple
             ? "Simple acceptance: a value passes when it lies inside its limit, whatever its uncertainty."
             : "Guarded acceptance: a value passes when it lies inside its limit by its expanded "
               "uncertainty U or more.";
}

Outcome Limit::of(const Measured& m, Decision rule) const {
  if (!m.known()) return Outcome::not_observed;
  const double guard = rule == Decision::guarded ? 2 * m.u : 0.0;
  if (!std::isfinite(guard)) return Outcome::not_judged;
  return m.value - guard < low || m.value + guard > high ? Outcome::fail : Outcome::pass;
}

Outcome judge_angle(const Measured& reached, double commanded, double tolerance, Decision rule) {
  const double off = std::fabs(wrap_half_turn(reached.value - commanded));
  return Limit{"", -tolerance, tolerance}.of({off, reached.u}, rule);
}

std::string range_text(const Limit& limit) {
  const Quantity& q = quantity_of(limit);
  const bool low = std::isfinite(limit.low), high = std::isfinite(limit.high);
  const std::string unit = unit_shown(q), from = plain(shown(q, limit.low)), to = plain(shown(q, limit.high));
  if (low && high) return fmt::format("{} to {} {}", from, to, unit);
  if (high) return fmt::format("\xE2\x89\xA4 {} {}", to, unit);
  if (low) return fmt::format("\xE2\x89\xA5 {} {}", from, unit);
  return "any value";
}

Judgement judge(const Events& events, const std::vector<Limit>& limits, Decision rule) {
  Judgement j;
  if (!limits.empty()) j.outcome = Outcome::pass;
  for (const auto& limit : limits) {
    const Quantity& q = quantity_of(limit);
    const Measured m = q.of(events);
    const Outcome o = limit.of(m, rule);
    j.outcome = worse(j.outcome, o);
    if (o == Outcome::pass) continue;
    if (!j.reason.empty()) j.reason += "; ";
    j.reason += limit.quantity;
    if (!m.known())
      j.reason += " not observed";
    else if (o == Outcome::not_judged)
      j.reason += fmt::format(" = {} {} without an uncertainty", digits(shown(q, m.value)), unit_shown(q));
    else if (rule == Decision::guarded)
      j.reason += fmt::format(" = {} {} with U = {:.2g} {}", digits(shown(q, m.value)), unit_shown(q),
                              shown(q, 2 * m.u), unit_shown(q));
    else
      j.reason += fmt::format(" = {} {}", digits(shown(q, m.value)), unit_shown(q));
    j.reason += fmt::format(", allowed {}", range_text(limit));
  }
  return j;
}

}  // namespace powbench::host
