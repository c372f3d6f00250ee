#include "dsp/contacts/pole.h"

#include <algorithm>
#include <cmath>
#include <vector>

#include "dsp/contacts/contact_train.h"

namespace powbench::dsp {

namespace {

constexpr double carried = 20e-6;  ///< s: from the core's stop to a contact

double start_of(const Contact& c) {
  return c.touch.known() ? c.touch.value : -1e300;
}
double end_of(const Contact& c) {
  return c.release.known() ? c.release.value : 1e300;
}

struct Edge {
  double t = 0, u = 0;
};

/// All edges in order of time.
std::vector<Edge> edges_of(const ContactTrain& a, const ContactTrain& b, double t_end) {
  std::vector<Edge> out{{0.0, 0.0}, {t_end, 0.0}};
  for (const ContactTrain* train : {&a, &b})
    for (const Contact& c : train->contacts)
      for (const Measured& m : {c.touch, c.release})
        if (m.known() && m.value > 0 && m.value < t_end)
          out.push_back({m.value, std::isfinite(m.u) ? m.u : 0.0});
  std::sort(out.begin(), out.end(), [](const Edge& x, const Edge& y) { return x.t < y.t; });
  return out;
}

bool closed_at(const ContactTrain& train, double t) {
  return std::any_of(train.contacts.begin(), train.contacts.end(),
                     [t](const Contact& c) { return start_of(c) <= t && t < end_of(c); });
}

}  // namespace

ContactTrain pole_by_force(const ContactTrain& a, const ContactTrain& b, double merge) {
  ContactTrain out;
  if (!a.present || !b.present) return out;
  out.present = true;
  out.resolution = std::max(a.resolution, b.resolution);
  out.flags = a.flags | b.flags;
  for (const Contact& x : a.contacts)
    for (const Contact& y : b.contacts) {
      if (std::max(start_of(x), start_of(y)) >= std::min(end_of(x), end_of(y))) continue;
      Contact c;
      c.touch = start_of(x) >= start_of(y) ? x.touch : y.touch;
      c.release = end_of(x) <= end_of(y) ? x.release : y.release;
      c.flags = x.flags | y.flags;
      c.probability = x.probability * y.probability;
      out.contacts.push_back(c);
    }
  std::sort(out.contacts.begin(), out.contacts.end(),
            [](const Contact& x, const Contact& y) { return start_of(x) < start_of(y); });
  summarise(out, merge);
  return out;
}

Disagreement disagreement(const ContactTrain& a, const ContactTrain& b, double t_end) {
  if (!a.present || !b.present || !(t_end > 0)) return {};
  const auto edges = edges_of(a, b, t_end);
  double total = 0, longest = 0, variance = 0, longest_u = 0, run = 0;
  for (std::size_t i = 0; i + 1 < edges.size(); ++i) {
    const double length = edges[i + 1].t - edges[i].t, middle = 0.5 * (edges[i].t + edges[i + 1].t);
    if (!(length > 0) || closed_at(a, middle) == closed_at(b, middle)) {
      if (length > 0) run = 0;
      continue;
    }
    const double u = std::hypot(edges[i].u, edges[i + 1].u);
    total += length;
    variance += u * u;
    run += length;
    if (run > longest) longest = run, longest_u = u;
  }
  return {{total, std::sqrt(variance)}, {longest, longest_u}};
}

void split_trains(ContactTrain& t, const Measured& seat) {
  t.first_train = t.second_train = {};
  if (t.contacts.empty()) return;
  t.first_train.from = t.contacts.front().touch;
  t.first_train.to = t.contacts.front().touch;
  const double u = std::isfinite(seat.u) ? seat.u : 0.0;
  const double border = seat.known() ? seat.value - 3 * u - carried : 1e300;
  for (std::size_t k = 0; k < t.contacts.size(); ++k) {
    const Measured& release = t.contacts[k].release;
    if (!release.known()) break;
    const Measured next = k + 1 < t.contacts.size() ? t.contacts[k + 1].touch : Measured{};
    if (release.value < border) {
      if (next.known()) ++t.first_train.openings;
      t.first_train.to = next;
      continue;
    }
    if (!t.second_train.from.known()) t.second_train.from = release;
    if (next.known()) ++t.second_train.openings;
    t.second_train.to = next;
  }
}

}  // namespace powbench::dsp
