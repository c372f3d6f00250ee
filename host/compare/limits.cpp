#include "host/compare/limits.h"

#include <fmt/format.h>

#include <cmath>
#include <stdexcept>
#include <string_view>

#include "core/quantities.h"

namespace powbench::host {
namespace {

const Quantity& quantity_of(const Limit& limit) {
  const Quantity* q = find_quantity(limit.quantity);
  if (q == nullptr) throw std::invalid_argument("limit on unknown quantity " + limit.quantity);
  return *q;
}

std::string plain(double value) {
  return fmt::format("{:.5g}", value);
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

bool Limit::allows(const Measured& m) const {
  if (!m.known()) return false;
  return !(m.value < low) && !(m.value > high);
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

Judgement judge(const Events& events, const std::vector<Limit>& limits) {
  Judgement j;
  for (const auto& limit : limits) {
    const Quantity& q = quantity_of(limit);
    const Measured m = q.of(events);
    if (limit.allows(m)) continue;
    j.outcome = Outcome::fail;
    if (!j.reason.empty()) j.reason += "; ";
    j.reason += limit.quantity;
    j.reason +=
        m.known() ? fmt::format(" = {} {}", plain(shown(q, m.value)), unit_shown(q)) : " not observed";
    j.reason += fmt::format(", allowed {}", range_text(limit));
  }
  return j;
}

}  // namespace powbench::host
