#include "dsp/events/lost_time.h"

#include <algorithm>
#include <cmath>
#include <vector>

namespace powbench::dsp {

namespace {

/// s: from the last sample before it to the first behind it.
struct Lost {
  double from = 0, to = 0;
  double length() const { return to - from; }
};

std::vector<Lost> lost_time(const Record& record, Channel channel) {
  std::vector<Lost> out;
  const ChannelRecord* c = record.find(channel);
  if (c == nullptr) return out;
  const double tick = 1 / record.sample_rate;
  for (const auto* gaps : {&record.gaps, &c->gaps})
    for (const Gap& g : *gaps) {
      const double from = record.time(0) + static_cast<double>(g.first - 1) * tick - c->delay;
      out.push_back({from, from + static_cast<double>(g.count + 1) * tick});
    }
  std::sort(out.begin(), out.end(), [](const Lost& a, const Lost& b) { return a.from < b.from; });
  return out;
}

/// An edge at a stretch, its ends included by the rounding of a time.
bool holds(const Lost& l, const Measured& edge) {
  constexpr double rounding = 1e-9;
  return edge.known() && edge.value > l.from - rounding && edge.value < l.to + rounding;
}

bool closed_around(const Lost& l, const Contact& c) {
  return c.touch.known() && c.touch.value < l.to && (!c.release.known() || c.release.value > l.from);
}

}  // namespace

void admit_lost_time(ContactTrain& t, const Record& record, Channel channel) {
  for (const Lost& l : lost_time(record, channel)) {
    bool touched = false;
    for (Contact& c : t.contacts) {
      bool here = l.length() > t.resolution && closed_around(l, c);
      for (Measured* edge : {&c.touch, &c.release})
        if (holds(l, *edge)) edge->u = std::max(edge->u, l.length() / std::sqrt(12.0)), here = true;
      if (here) c.flags |= flag_gap, touched = true;
    }
    if (!t.contacts.empty() && t.contacts.front().touch.known()) {
      Contact& first = t.contacts.front();
      const double before = first.touch.value - l.from;
      if (l.length() > t.resolution && l.to > 0 && l.to <= first.touch.value && before < near_touch) {
        first.touch.u = std::max(first.touch.u, before);
        first.flags |= flag_gap, touched = true;
      }
    }
    if (touched) t.flags |= flag_gap;
  }
  if (!t.settled.known()) return;
  const double first = t.contacts.front().touch.u, last = t.contacts.back().touch.u;
  if (last > t.settled.u && t.contacts.size() == 1) t.bounce_time.u = last;  // what was lost may hold others
  t.settled.u = std::max(t.settled.u, last);
  if (t.bounce_time.known() && t.contacts.size() > 1)
    t.bounce_time.u = std::max(t.bounce_time.u, std::hypot(first, last));
}

double unbroken_end(const ContactTrain& t, const Record& record, Channel channel, double t_end) {
  if (!t.settled.known()) return t_end;
  for (const Lost& l : lost_time(record, channel))
    if (l.length() > t.resolution && l.to > t.settled.value) return std::min(std::max(l.from, 0.0), t_end);
  return t_end;
}

}  // namespace powbench::dsp
