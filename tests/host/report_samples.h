#pragma once

#include <cmath>

#include "host/compare/compare.h"
#include "host/report/report.h"

/// Shots for the tests of a report, of which every number is known.

namespace powbench::host {

inline Waveform wave(const char* channel, const char* unit, std::size_t n) {
  Waveform w{channel, unit, -10e-3, 10e-6, {}};
  for (std::size_t i = 0; i < n; ++i)
    w.values.push_back(static_cast<float>(std::sin(0.01 * static_cast<double>(i))));
  return w;
}

inline Events some_events(double touch) {
  Events e;
  e.method = "method <one>";
  e.parameters_hash = "cafe";
  e.contact_voltage.present = true;
  Contact first, last;
  first.touch = {touch, 2e-6};
  first.release = {touch + 1e-3, 2e-6};
  last.touch = {touch + 3e-3, 2e-6};
  e.contact_voltage.contacts = {first, last};
  e.contact_voltage.settled = last.touch;
  e.contact_voltage.bounce_time = {3e-3, 3e-6};
  e.contact_voltage.bounce_count = 1;
  e.core.seat = {touch + 2e-3, 10e-6};
  e.coil.closing_angle = {radians(30.1), radians(0.02)};
  return e;
}

inline ReportShot some_shot(int index) {
  ReportShot s;
  s.index = index;
  s.conditions.closing_angle = radians(30);
  s.outcome = Outcome::pass;
  s.events = some_events(12e-3);
  s.waveforms = {wave("pvdf_a", "N", 6000), wave("laser", "m", 6000), wave("mains_voltage", "V", 6000)};
  s.raw = {wave("pvdf_a", "N", 6000)};
  s.record_hash = "0123456789abcdef";
  return s;
}

inline void compare_into(ReportInput& in) {
  std::vector<AngleGroup> groups;
  for (const auto& s : in.shots) {
    auto& group = group_at(groups, effective_angle(s.conditions));
    if (s.events) group.measured.push_back(*s.events);
  }
  for (const auto& s : in.simulated) group_at(groups, s.closing_angle).simulated.push_back(s.events);
  in.comparison = compare(groups, in.published, in.limits);
}

}  // namespace powbench::host
