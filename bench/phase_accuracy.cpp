// Phase error of the tracker for every disturbance, beside a plain zero-cross controller and a SOGI-PLL.
//
//   bench_phase_accuracy [--json PATH] [--starts N]
//
// Every row is the worst of N start phases; the judged estimates are one a millisecond. "now" is the error at
// the newest sample, "+20 ms" that of the phase predicted from it.

#include <algorithm>
#include <cstdio>
#include <cstdlib>
#include <ctime>
#include <fstream>
#include <nlohmann/json.hpp>
#include <string>
#include <vector>

#include "bench/phase_judge.h"
#include "bench/phase_peers.h"

namespace {

using namespace powbench::bench;
using nlohmann::json;

template <class Estimator>
SteadyErrors worst_steady(const MainsScenario& scenario, double hertz, int starts) {
  SteadyErrors worst{.valid_share = 1.0};
  for (int i = 0; i < starts; ++i) {
    Estimator estimator;
    const SteadyErrors e = judge_steady(scenario, hertz, 0.13 + static_cast<double>(i) / starts, estimator);
    worst.now = std::max(worst.now, e.now);
    worst.ahead = std::max(worst.ahead, e.ahead);
    worst.hertz = std::max(worst.hertz, e.hertz);
    worst.valid_share = std::min(worst.valid_share, e.valid_share);
  }
  return worst;
}

void steady_row(const MainsScenario& s, int starts, json& rows) {
  for (const double hertz : mains_hertz) {
    const SteadyErrors ours = worst_steady<OurTracker>(s, hertz, starts);
    const SteadyErrors crossing = worst_steady<ZeroCrossPeer>(s, hertz, starts);
    const SteadyErrors sogi = worst_steady<SogiPeer>(s, hertz, starts);
    const bool limited = s.must_now > 0;
    const bool valid = ours.valid_share == 1.0;
    const bool must = ours.now <= s.must_now && ours.ahead <= s.must_ahead && valid;
    const bool goal = ours.now <= s.goal_now && ours.ahead <= s.goal_ahead && valid;
    std::printf(
        "%-28s %3.0f | %7.3f %7.3f %6.1f | %5.3g %5.3g %-5s| %5.3g %5.3g %-5s| %7.3f %7.3f | %7.3f %7.3f\n",
        std::string(s.name).c_str(), hertz, ours.now, ours.ahead, 100 * ours.valid_share, s.must_now,
        s.must_ahead, limited ? (must ? "pass" : "MISS") : "-", s.goal_now, s.goal_ahead,
        limited ? (goal ? "pass" : "miss") : "-", crossing.now, crossing.ahead, sogi.now, sogi.ahead);
    json row = {{"scenario", s.name},
                {"hertz", hertz},
                {"now_deg", ours.now},
                {"ahead_20ms_deg", ours.ahead},
                {"frequency_error_hertz", ours.hertz},
                {"valid_share", ours.valid_share},
                {"zero_cross", {{"now_deg", crossing.now}, {"ahead_20ms_deg", crossing.ahead}}},
                {"sogi_pll", {{"now_deg", sogi.now}, {"ahead_20ms_deg", sogi.ahead}}}};
    if (limited) {
      row["must"] = {{"now_deg", s.must_now}, {"ahead_20ms_deg", s.must_ahead}, {"pass", must}};
      row["goal"] = {{"now_deg", s.goal_now}, {"ahead_20ms_deg", s.goal_ahead}, {"pass", goal}};
    }
    rows.push_back(row);
  }
}

struct Event {
  const char* name;
  MainsScenario scenario;
  double ends;
  bool limited;  ///< false: harder than what is promised
};

std::vector<Event> events() {
  std::vector<Event> list;
  for (const bool disturbed : {false, true}) {
    MainsScenario base = disturbed ? steady_scenarios().back() : MainsScenario{};
    MainsScenario jump = base, step = base, dip = base, gone = base;
    jump.jump = 30;
    step.step = 1;
    dip.dip = 0.4;
    gone.dip = 0;
    list.push_back({disturbed ? "jump 30 deg, all" : "jump 30 deg", jump, event_start, !disturbed});
    list.push_back({disturbed ? "step 1 Hz, all" : "step 1 Hz", step, event_start, !disturbed});
    list.push_back({disturbed ? "dip to 40 %, all" : "dip to 40 %", dip, event_end, !disturbed});
    list.push_back({disturbed ? "interruption, all" : "interruption", gone, event_end, !disturbed});
  }
  return list;
}

template <class Estimator>
EventErrors worst_event(Event event, double hertz, int starts) {
  if (hertz + event.scenario.step > 65.0) event.scenario.step = -event.scenario.step;
  EventErrors worst;
  for (int i = 0; i < starts; ++i) {
    Estimator estimator;
    const EventErrors e =
        judge_event(event.scenario, hertz, 0.01 + static_cast<double>(i) / starts, event.ends, estimator);
    worst.noticed = std::max(worst.noticed, e.noticed);
    worst.worst_before = std::max(worst.worst_before, e.worst_before);
    worst.worst_after = std::max(worst.worst_after, e.worst_after);
    worst.settled = std::max(worst.settled, e.settled);
  }
  return worst;
}

void event_row(const Event& event, int starts, json& rows) {
  for (const double hertz : mains_hertz) {
    const EventErrors ours = worst_event<OurTracker>(event, hertz, starts);
    const EventErrors crossing = worst_event<ZeroCrossPeer>(event, hertz, starts);
    const EventErrors sogi = worst_event<SogiPeer>(event, hertz, starts);
    const bool must = ours.noticed <= 0.020 && ours.settled <= 0.100 && ours.worst_after <= 1.0;
    std::printf("%-28s %3.0f | %7.1f %7.2f %9.2f %9.1f %-5s| %9.1f | %9.1f\n", event.name, hertz,
                1e3 * ours.noticed, ours.worst_before, ours.worst_after, 1e3 * ours.settled,
                !event.limited ? "-" : (must ? "pass" : "MISS"), 1e3 * crossing.settled, 1e3 * sogi.settled);
    json row = {{"event", event.name},
                {"hertz", hertz},
                {"noticed_s", ours.noticed},
                {"worst_valid_before_noticed_deg", ours.worst_before},
                {"worst_valid_after_deg", ours.worst_after},
                {"valid_within_1deg_after_s", ours.settled},
                {"zero_cross_within_1deg_after_s", crossing.settled},
                {"sogi_pll_within_1deg_after_s", sogi.settled}};
    if (event.limited) row["must"] = {{"noticed_s", 0.020}, {"valid_after_s", 0.100}, {"pass", must}};
    rows.push_back(row);
  }
}

template <class Estimator>
double nanoseconds_a_sample() {
  MainsSource source(steady_scenarios().back(), 50.0, 0.1, 3);
  std::vector<std::int16_t> samples(100000);
  for (std::int16_t& sample : samples) sample = source.next();
  double best = 1e9;
  for (int repeat = 0; repeat < 5; ++repeat) {
    Estimator estimator;
    const std::clock_t start = std::clock();
    for (const std::int16_t sample : samples) estimator.push(sample);
    const double seconds = static_cast<double>(std::clock() - start) / CLOCKS_PER_SEC;
    if (estimator.say().turns < -1) std::abort();  // the result is used
    best = std::min(best, 1e9 * seconds / static_cast<double>(samples.size()));
  }
  return best;
}

}  // namespace

int main(int count, char** words) {
  std::string path;
  int starts = 4;
  for (int i = 1; i + 1 < count; i += 2) {
    const std::string word = words[i];
    if (word == "--json") path = words[i + 1];
    if (word == "--starts") starts = std::max(1, std::atoi(words[i + 1]));
  }
  json report;
  std::puts("Largest phase error, deg: now, 20 ms ahead");
  std::puts(
      "scenario                      Hz |     now  +20 ms valid% |        must       |        goal       |  "
      "zero-cross "
      "    |  SOGI-PLL 8 Hz");
  for (const MainsScenario& s : steady_scenarios()) steady_row(s, starts, report["steady"]);
  for (const MainsScenario& s : harder_scenarios()) steady_row(s, starts, report["harder"]);
  std::puts(
      "\nEvents: ms until noticed, deg of valid estimates before and after that, ms until valid and within 1 "
      "deg");
  std::puts(
      "event                         Hz | noticed  before     after   settled      | zero-cross |  SOGI-PLL");
  for (const Event& event : events()) event_row(event, 3 * starts, report["events"]);
  const double ours = nanoseconds_a_sample<OurTracker>();
  const double crossing = nanoseconds_a_sample<ZeroCrossPeer>();
  const double sogi = nanoseconds_a_sample<SogiPeer>();
  std::printf(
      "\nCPU a sample at 100 kS/s, ns: tracker %.1f, zero-cross %.1f, SOGI-PLL %.1f (ratio %.1f, 1, %.1f)\n",
      ours, crossing, sogi, ours / crossing, sogi / crossing);
  report["cpu_ns_per_sample"] = {{"tracker", ours}, {"zero_cross", crossing}, {"sogi_pll", sogi}};
  report["starts"] = starts;
  if (!path.empty()) {
    std::ofstream out(path);
    out << report.dump(1) << '\n';
    if (!out) {
      std::fprintf(stderr, "cannot write %s\n", path.c_str());
      return 1;
    }
  }
  return 0;
}
