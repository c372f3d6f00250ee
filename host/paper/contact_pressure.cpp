#include "host/paper/contact_pressure.h"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <complex>
#include <limits>
#include <nlohmann/json.hpp>

#include "core/units.h"
#include "host/paper/contact_hum.h"

namespace powbench::host {
namespace {

using Json = nlohmann::ordered_json;

constexpr double duration = 0.1;  // s
constexpr double sample_dt = pressure_sample_dt;
constexpr double nan = std::numeric_limits<double>::quiet_NaN();

/// One line of the comparison.
struct Line {
  const char* what;
  const char* unit;
  double published, ours;
};

std::vector<Line> printed_simulation(const PressureTrain& t) {
  return {{"bounces", "", 2, static_cast<double>(t.bounces())},
          {"first to second peak", "ms", 1.5,
           t.pulses.size() > 1 ? 1e3 * (t.pulses[1].peak_time - t.pulses[0].peak_time) : nan},
          {"first peak", "N", 10, t.peak(0)},
          {"second peak", "N", 5, t.peak(1)}};
}

std::vector<Line> printed_measurement(const PressureTrain& a, const PressureTrain& b) {
  return {{"bounces of F2", "", 3, static_cast<double>(b.bounces())},
          {"first to second touch of F2", "ms", 1.0, 1e3 * b.interval(0)},
          {"second to third touch of F2", "ms", 0.5, 1e3 * b.interval(1)},
          {"F1 over F2, largest peaks", "", nan, a.largest() / b.largest()}};
}

std::string lines_text(const std::vector<Line>& lines) {
  std::string text;
  for (const auto& l : lines)
    text +=
        fmt::format("  {:<30} {:>9} {:>9.3g} {:>3}  {}\n", l.what,
                    std::isnan(l.published) ? "above 1" : fmt::format("{:g}", l.published), l.ours, l.unit,
                    std::isnan(l.published) || l.published == 0
                        ? ""
                        : fmt::format("{:.1f} %", 100 * std::fabs(l.ours / l.published - 1)));
  return text;
}

std::string train_text(const char* name, const PressureTrain& t) {
  std::string text = fmt::format("  {}:", name);
  for (std::size_t k = 0; k < t.pulses.size(); ++k)
    text += fmt::format(" {:.2f}{} ms {:.1f} N;", t.pulses[k].begin * 1e3,
                        k + 1 < t.pulses.size() ? fmt::format("-{:.2f}", t.pulses[k].end * 1e3) : " on",
                        t.pulses[k].peak);
  return text + "\n";
}

/// What one closing angle does to the contacts.
struct AngleLine {
  double theta_deg, touch, seat, bounce, first_peak, impulse;
  std::size_t bounces;
};

AngleLine angle_line(const sim::Specimen& s, double theta_deg) {
  const auto r = pressure_closing(s, theta_deg);
  const auto a = pressure_train(r.samples, false, 50), b = pressure_train(r.samples, true, 50);
  const auto& t = r.truth;
  double impulse = 0;
  for (const auto& p : r.samples)
    if (t.settled && p.time <= *t.settled) impulse += sample_dt * (p.force_a + p.force_b);
  return {theta_deg,
          t.touch.value_or(nan),
          t.core_seat.value_or(nan),
          t.settled.value_or(nan) - t.touch.value_or(nan),
          std::max(a.peak(0), b.peak(0)),
          impulse,
          t.openings.size()};
}

/// A train beside those a little off its angle and its mains.
struct Neighbour {
  double degrees, volts_percent;
  PressureTrain train;
};

std::vector<Neighbour> neighbours(const sim::Specimen& s, double theta_deg, bool break_b) {
  std::vector<Neighbour> list;
  for (const auto& [deg, percent] : {std::pair{0.0, 0.0}, {-3.0, 0.0}, {3.0, 0.0}, {0.0, -1.0}, {0.0, 1.0}})
    list.push_back(
        {deg, percent,
         pressure_train(pressure_closing(s, theta_deg + deg, 1 + percent / 100).samples, break_b, 50)});
  return list;
}

std::string neighbours_text(const char* name, const std::vector<Neighbour>& list) {
  const auto shown = [](double value, int digits) {
    return std::isfinite(value) ? fmt::format("{:.{}f}", value, digits) : std::string("-");
  };
  std::string text;
  for (const auto& n : list)
    text += fmt::format("  {:<12} {:>+5.0f} deg {:>+4.0f} % {:>8} {:>9} {:>9} {:>9} {:>9}\n", name, n.degrees,
                        n.volts_percent, n.train.bounces(), shown(n.train.interval(0) * 1e3, 2),
                        shown(n.train.interval(1) * 1e3, 2), shown(n.train.peak(0), 1),
                        shown(n.train.peak(1), 1));
  return text;
}

constexpr double ranked_deg[] = {0, 30, 40, 70, 90, 120, 150, 180, 220, 270};

}  // namespace

double PressureTrain::interval(std::size_t k) const {
  return k + 1 < pulses.size() ? pulses[k + 1].begin - pulses[k].begin : nan;
}

double PressureTrain::peak(std::size_t k) const {
  return k < pulses.size() ? pulses[k].peak : nan;
}

double PressureTrain::largest() const {
  double most = 0;
  for (const auto& p : pulses) most = std::max(most, p.peak);
  return most;
}

PressureTrain pressure_train(const std::vector<sim::PlantSample>& samples, bool break_b, double mains_hertz) {
  PressureTrain t;
  bool pressing = false;
  for (const auto& s : samples) {
    const double f = break_b ? s.force_b : s.force_a;
    const bool reopened = t.pulses.empty() || s.time - t.pulses.back().end >= shortest_opening;
    if (f > 0 && !pressing && reopened) t.pulses.push_back({s.time, s.time, 0, s.time});
    pressing = f > 0;
    if (!pressing) continue;
    auto& p = t.pulses.back();
    p.end = s.time;
    if (f > p.peak) p.peak = f, p.peak_time = s.time;
  }
  if (t.pulses.empty() || !pressing) return t;
  t.settled = t.pulses.back().begin;
  double low = std::numeric_limits<double>::infinity(), high = 0, sum = 0, count = 0;
  std::complex<double> once = 0, twice = 0;
  const double from = samples.back().time - 1 / mains_hertz;
  for (const auto& s : samples) {
    if (s.time <= from || s.time <= t.settled) continue;
    const double f = break_b ? s.force_b : s.force_a, phase = 2 * pi * mains_hertz * s.time;
    low = std::min(low, f);
    high = std::max(high, f);
    sum += f;
    once += std::polar(f, phase);
    twice += std::polar(f, 2 * phase);
    ++count;
  }
  t.mean = sum / count;
  t.swing = high - low;
  t.once = 2 * std::abs(once) / count;
  t.second = 2 * std::abs(twice) / count;
  return t;
}

Conditions pressure_conditions(double theta_deg) {
  Conditions c;
  c.supply_volts = 220;
  c.ambient = zero_celsius + 17;
  c.closing_angle = radians(theta_deg);
  c.hold_time = duration;
  return c;
}

sim::Trajectory pressure_closing(const sim::Specimen& specimen, double theta_deg, double share_of_volts) {
  Conditions c = pressure_conditions(theta_deg);
  c.supply_volts *= share_of_volts;
  return sim::simulate(specimen, c, duration, sample_dt);
}

std::string pressure_text(const PressurePage& page) {
  const auto level = pressure_closing(page.level, page.level_deg);
  const auto tilted = pressure_closing(page.tilted, page.tilted_deg);
  const auto one = pressure_train(level.samples, false, 50);
  const auto a = pressure_train(tilted.samples, false, 50), b = pressure_train(tilted.samples, true, 50);
  std::string text =
      "220 V, 50 Hz, 17 degC; the closing angle of both trains is not printed, ours was chosen.\n"
      "Openings below 0.1 ms count as closed, as in a filtered force.\n\n";
  text += fmt::format("printed simulation, beside {} at {:g} deg\n  {:<30} {:>9} {:>9}\n", page.level.name,
                      page.level_deg, "", "printed", "ours");
  text += lines_text(printed_simulation(one)) + train_text("one break", one);
  text += fmt::format("\nprinted measurement, beside {} at {:g} deg\n  {:<30} {:>9} {:>9}\n",
                      page.tilted.name, page.tilted_deg, "", "printed", "ours");
  text += lines_text(printed_measurement(a, b)) + train_text("F1", a) + train_text("F2", b);
  text += fmt::format(
      "\nhow much the trains depend on the angle and on the mains, neither of which is printed to that\n"
      "  {:<12} {:>9} {:>6} {:>8} {:>9} {:>9} {:>9} {:>9}\n",
      "", "angle", "mains", "bounces", "1st ms", "2nd ms", "1st N", "2nd N");
  text += neighbours_text("one break", neighbours(page.level, page.level_deg, false)) +
          neighbours_text("F2", neighbours(page.tilted, page.tilted_deg, true));
  text += "\nafter settling: pulsation over the last period of the mains, no bounce\n";
  for (const auto& [name, t] : {std::pair{"level", &one}, {"tilted, F1", &a}, {"tilted, F2", &b}})
    text += fmt::format("  {:<12} mean {:.2f} N, swing {:.3g} N, at 50 Hz {:.2g} N, at 100 Hz {:.2g} N\n",
                        name, t->mean, t->swing, t->once, t->second);
  text += fmt::format(
      "\nheld for 0.4 s, {}: where the pulsation would come from\n  {:<30} {:>13} {:>14} {:>12} {:>12} "
      "{:>6}\n",
      page.tilted.name, "", "pull N", "overtravel um", "at 100 Hz mN", "k_c / 2 x mN", "lifts");
  for (const auto& l : hum_lines(page.tilted))
    text += fmt::format("  {:<30} {:>13} {:>14.1f} {:>12.1f} {:>12.1f} {:>6}\n", l.what,
                        fmt::format("{:.0f} .. {:.0f}", l.low, l.high), l.swing_um, 1e3 * l.second,
                        1e3 * l.expected, l.lifts);
  text +=
      fmt::format("\nclosing angles, {}\n  {:>5} {:>9} {:>9} {:>9} {:>8} {:>11} {:>13}\n", page.tilted.name,
                  "deg", "touch ms", "seat ms", "bounce ms", "bounces", "first peak N", "impulse mN s");
  for (const double theta : ranked_deg) {
    const auto l = angle_line(page.tilted, theta);
    text +=
        fmt::format("  {:>5g} {:>9.2f} {:>9.2f} {:>9.2f} {:>8} {:>11.1f} {:>13.2f}\n", theta, l.touch * 1e3,
                    l.seat * 1e3, l.bounce * 1e3, l.bounces, l.first_peak, l.impulse * 1e3);
  }
  return text;
}

std::string pressure_json(const PressurePage& page) {
  const auto lines = [](const std::vector<Line>& list) {
    Json j = Json::array();
    for (const auto& l : list)
      j.push_back({{"quantity", l.what}, {"unit", l.unit}, {"published", l.published}, {"ours", l.ours}});
    return j;
  };
  const auto pulsation = [](const PressureTrain& t) {
    return Json{{"mean_N", t.mean}, {"swing_N", t.swing}, {"at_50_Hz_N", t.once}, {"at_100_Hz_N", t.second}};
  };
  const auto level = pressure_train(pressure_closing(page.level, page.level_deg).samples, false, 50);
  const auto tilted = pressure_closing(page.tilted, page.tilted_deg);
  const auto a = pressure_train(tilted.samples, false, 50), b = pressure_train(tilted.samples, true, 50);
  Json hum = Json::array();
  for (const auto& l : hum_lines(page.tilted))
    hum.push_back({{"what", l.what},
                   {"pull_low_N", l.low},
                   {"pull_high_N", l.high},
                   {"overtravel_swing_um", l.swing_um},
                   {"at_100_Hz_N", l.second},
                   {"by_overtravel_spring_N", l.expected},
                   {"core_lifts", l.lifts}});
  const auto near = [](const std::vector<Neighbour>& list) {
    Json j = Json::array();
    for (const auto& n : list)
      j.push_back({{"angle_off_deg", n.degrees},
                   {"mains_off_percent", n.volts_percent},
                   {"bounces", n.train.bounces()},
                   {"first_interval_s", n.train.interval(0)},
                   {"second_interval_s", n.train.interval(1)},
                   {"first_peak_N", n.train.peak(0)},
                   {"second_peak_N", n.train.peak(1)}});
    return j;
  };
  Json angles = Json::array();
  for (const double theta : ranked_deg) {
    const auto l = angle_line(page.tilted, theta);
    angles.push_back({{"angle_deg", theta},
                      {"touch_s", l.touch},
                      {"seat_s", l.seat},
                      {"bounce_s", l.bounce},
                      {"bounces", l.bounces},
                      {"first_peak_N", l.first_peak},
                      {"impulse_Ns", l.impulse}});
  }
  return Json{
      {"simulation", lines(printed_simulation(level))},
      {"measurement", lines(printed_measurement(a, b))},
      {"pulsation", {{"level", pulsation(level)}, {"tilted_a", pulsation(a)}, {"tilted_b", pulsation(b)}}},
      {"robustness",
       {{"level", near(neighbours(page.level, page.level_deg, false))},
        {"tilted_b", near(neighbours(page.tilted, page.tilted_deg, true))}}},
      {"held", hum},
      {"angles", angles}}
      .dump(2);
}

}  // namespace powbench::host
