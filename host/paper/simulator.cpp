#include "host/paper/simulator.h"

#include <algorithm>

#include "core/units.h"
#include "sim/models/rigid_closing.h"

namespace powbench::host {
namespace {

constexpr double duration = 0.060;  // s: every closing in range has settled long before
constexpr double sample_dt =
    2e-6;  // s: a contact pulse lasts about 0.1 ms, so its peak is found within 0.1 %

double peak_between(const std::vector<sim::PlantSample>& samples, double from, double to) {
  double peak = 0;
  for (const auto& s : samples)
    if (s.time >= from && s.time <= to) peak = std::max(peak, s.force_a);
  return peak;
}

}  // namespace

PublishedView published_view(const sim::Trajectory& closing) {
  const sim::ClosingTruth& truth = closing.truth;
  PublishedView v;
  v.t_ct1 = truth.touch.value_or(unknown);
  v.t_ct2 = truth.settled.value_or(unknown);
  v.t_ct_bon = v.t_ct2 - v.t_ct1;
  v.t_xt1 = truth.core_seat.value_or(unknown);
  v.t_xt2 = truth.core_settled.value_or(unknown);
  v.t_xt_bon = v.t_xt2 - v.t_xt1;
  const auto& openings = truth.openings;
  if (truth.touch && !openings.empty()) {
    v.bounce_interval_1 = openings[0].touch - v.t_ct1;
    v.F_bounce_1 = peak_between(closing.samples, v.t_ct1, openings[0].release);
  }
  if (openings.size() > 1) {
    v.bounce_interval_2 = openings[1].touch - openings[0].touch;
    v.F_bounce_2 = peak_between(closing.samples, openings[0].touch, openings[1].release);
  }
  return v;
}

sim::BounceStudyOptions published_bounce_options() {
  sim::BounceStudyOptions o;
  o.tolerance = sim::PlantOptions{}.relative_tolerance;
  o.end = duration;
  return o;
}

sim::BounceStudy published_bounces(const sim::Specimen& specimen, double theta_deg,
                                   const Conditions& conditions) {
  Conditions c = conditions;
  c.closing_angle = radians(theta_deg);
  const auto run = [&](double tolerance, const sim::Factor& factor) {
    return sim::contact_events(
        sim::simulate(sim::varied(specimen, factor), c, duration, 0, tolerance).events);
  };
  return sim::study_bounces(run, published_bounce_options());
}

ClosingProvider simulator_provider(const sim::Specimen& specimen, const Conditions& conditions) {
  return [specimen, conditions](double theta_deg) {
    Conditions c = conditions;
    c.closing_angle = radians(theta_deg);
    return published_view(sim::simulate(specimen, c, duration, sample_dt));
  };
}

}  // namespace powbench::host
