#include "sim/mechanics/bounce_error.h"

#include <algorithm>
#include <cmath>

namespace powbench::sim {
namespace {

std::vector<RigidEvent> of_contact(std::span<const RigidEvent> all, int contact, double end) {
  std::vector<RigidEvent> own;
  for (const auto& e : all)
    if (e.contact == contact && e.time <= end) own.push_back(e);
  std::stable_sort(own.begin(), own.end(),
                   [](const RigidEvent& a, const RigidEvent& b) { return a.time < b.time; });
  return own;
}

/// Time for which exactly one of the two is in the state that the events alternate.
double state_distance(std::span<const RigidEvent> a, std::span<const RigidEvent> b, double end) {
  std::size_t i = 0;
  std::size_t j = 0;
  bool differ = false;
  double since = 0;
  double sum = 0;
  while (i < a.size() || j < b.size()) {
    const bool first = j == b.size() || (i < a.size() && a[i].time <= b[j].time);
    const double t = first ? a[i++].time : b[j++].time;
    if (differ) sum += t - since;
    since = t;
    differ = !differ;
  }
  return differ ? sum + (end - since) : sum;
}

std::size_t prefix(std::span<const RigidEvent> a, std::span<const RigidEvent> b, double window) {
  std::size_t k = 0;
  while (k < a.size() && k < b.size() && a[k].closes == b[k].closes &&
         std::fabs(a[k].time - b[k].time) <= window)
    ++k;
  return k;
}

}  // namespace

bool is_bounce(const RigidEvent& e) {
  const auto kind = contact_place(e.contact).kind;
  return kind == ContactKind::pad || kind == ContactKind::pole;
}

BounceError bounce_error(std::span<const RigidEvent> events, std::span<const RigidEvent> reference,
                         double end, double window, const std::function<bool(const RigidEvent&)>& counts) {
  BounceError result;
  result.diverged_at = end;
  for (int c = 0; c < rigid_contacts; ++c) {
    if (!counts({c, true, 0, 0})) continue;
    const auto a = of_contact(events, c, end);
    const auto b = of_contact(reference, c, end);
    result.reference += static_cast<int>(b.size());
    result.distance = std::max(result.distance, state_distance(a, b, end));
    const std::size_t k = prefix(a, b, window);
    if (k < a.size()) result.diverged_at = std::min(result.diverged_at, a[k].time);
    if (k < b.size()) result.diverged_at = std::min(result.diverged_at, b[k].time);
  }
  for (int c = 0; c < rigid_contacts; ++c) {
    if (!counts({c, true, 0, 0})) continue;
    const auto a = of_contact(events, c, end);
    const auto b = of_contact(reference, c, end);
    for (std::size_t k = 0; k < prefix(a, b, window) && b[k].time < result.diverged_at; ++k) {
      ++result.matched;
      result.largest_dt = std::max(result.largest_dt, std::fabs(a[k].time - b[k].time));
    }
  }
  return result;
}

BounceCondition bounce_condition(std::span<const RigidEvent> twin, std::span<const RigidEvent> base,
                                 double change, double end) {
  const auto e = bounce_error(twin, base, end);
  return {e.largest_dt / change, !e.all() || e.diverged_at < end, e.diverged_at};
}

Spread spread(std::vector<double> values) {
  if (values.empty()) return {};
  std::sort(values.begin(), values.end());
  const auto at = [&](double share) {
    const double place = share * static_cast<double>(values.size() - 1);
    const auto k = static_cast<std::size_t>(place);
    if (k + 1 >= values.size()) return values.back();
    const double part = place - static_cast<double>(k);
    return values[k] + part * (values[k + 1] - values[k]);
  };
  double sum = 0;
  for (const double v : values) sum += v;
  return {sum / static_cast<double>(values.size()), at(0.05), at(0.5), at(0.95)};
}

BounceSummary bounce_summary(std::span<const RigidEvent> events, int contact) {
  BounceSummary s;
  double opened = 0;
  bool touched = false;
  for (const auto& e : events) {
    if (e.contact != contact) continue;
    if (!e.closes) {
      opened = e.time;
      continue;
    }
    if (touched) s.open_time += e.time - opened;
    if (!touched) s.first_touch = e.time;
    touched = true;
    s.last_closing = e.time;
  }
  return s;
}

}  // namespace powbench::sim
