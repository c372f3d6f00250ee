#include "bench/dsp_figures.h"

#include <algorithm>
#include <cmath>
#include <cstdio>
#include <ctime>
#include <fstream>
#include <stdexcept>

#include "bench/dsp_rig_truth.h"
#include "core/phase.h"
#include "dsp/events/extract.h"
#include "dsp/filter/force.h"

namespace powbench::bench {

namespace {

std::string number(double v) {
  char text[40];
  std::snprintf(text, sizeof text, "%g", v);
  return text;
}

/// Root mean square without the unmatched.
struct Errors {
  double squares = 0, n = 0;
  void add(double e) {
    if (std::isfinite(e)) squares += e * e, n += 1;
  }
  double rms() const { return n > 0 ? std::sqrt(squares / n) : std::nan(""); }
};

}  // namespace

Figure at_most(std::string what, double m, double must, double goal) {
  const double size = std::abs(m);
  return {std::move(what), "<= " + number(must), "<= " + number(goal), m, size <= must, size <= goal};
}

Figure at_least(std::string what, double m, double must, double goal) {
  return {std::move(what), ">= " + number(must), ">= " + number(goal), m, m >= must, m >= goal};
}

Figure between(std::string what, double m, double low, double high, double goal_low, double goal_high) {
  return {std::move(what),
          number(low) + " .. " + number(high),
          number(goal_low) + " .. " + number(goal_high),
          m,
          m >= low && m <= high,
          m >= goal_low && m <= goal_high};
}

nlohmann::json print(const std::vector<Figure>& figures) {
  nlohmann::json rows = nlohmann::json::array();
  std::printf("\n%-62s %14s %14s %10s  %s\n", "figure (records not used for tuning)", "must", "goal",
              "measured", "");
  for (const Figure& f : figures) {
    const char* verdict = f.met_goal ? "goal" : f.met_must ? "must" : "MISSED";
    std::printf("%-62s %14s %14s %10.4g  %s\n", f.what.c_str(), f.must.c_str(), f.goal.c_str(), f.measured,
                verdict);
    rows.push_back({{"figure", f.what},
                    {"must", f.must},
                    {"goal", f.goal},
                    {"measured", f.measured},
                    {"verdict", verdict}});
  }
  return rows;
}

RigScore score_rig(int angles) {
  RigScore out;
  out.json = nlohmann::json::array();
  std::printf(
      "\nsimulated rig, 200 kS/s, 100 ms, ringing from the mechanics; %d closing angles; times in us\n"
      "%-8s %6s %6s %6s | %7s %7s | %7s | %7s %7s | %7s %8s\n",
      angles, "film", "recall", "prec", "exact", "touch", "release", "flagged", "seat", "angle", "differ",
      "CPU ms");
  Scorer films[2];
  int flagged[2] = {0, 0};
  Errors seat, angle, differ;
  for (int k = 0; k < angles; ++k) {
    const double theta = radians(360.0 * k / angles + 3.0);
    RigTruth r = rig_record(200e3, theta, 50.0, 100 + static_cast<std::uint64_t>(k));
    const Events e = dsp::extract_events(r.record);
    films[0].add(r.film_a, e.pvdf_a.contacts);
    films[1].add(r.film_b, e.pvdf_b.contacts);
    flagged[0] += (e.pvdf_a.flags & flag_ring_overlap) != 0;
    flagged[1] += (e.pvdf_b.flags & flag_ring_overlap) != 0;
    seat.add(e.core.seat.value - r.core_seat);
    angle.add(wrap_half_turn(e.coil.closing_angle.value - theta));
    differ.add(e.pole.disagreement.value);
    // Six channels: the two films, travel, current and both voltages.
    std::erase_if(r.record.channels, [](const ChannelRecord& c) {
      return c.channel == Channel::contact_a || c.channel == Channel::aux;
    });
    const std::clock_t before = std::clock();
    dsp::extract_events(r.record);
    out.cpu_ms += 1e3 * static_cast<double>(std::clock() - before) / CLOCKS_PER_SEC / angles;
  }
  out.angle_deg = degrees(angle.rms());
  for (int f = 0; f < 2; ++f) {
    const Score s = films[f].score();
    std::printf("%-8s %6.3f %6.3f %6.3f | %7.2f %7.2f | %4d/%-2d | %7.2f %7.4f | %7.1f %8.2f\n",
                f ? "B" : "A", s.recall, s.precision, s.exact, 1e6 * s.touch_rmse, 1e6 * s.release_rmse,
                flagged[f], angles, 1e6 * seat.rms(), out.angle_deg, 1e6 * differ.rms(), out.cpu_ms);
    out.json.push_back({{"film", f ? "B" : "A"},
                        {"angles", angles},
                        {"recall", s.recall},
                        {"precision", s.precision},
                        {"exact", s.exact},
                        {"touch_rmse_s", s.touch_rmse},
                        {"release_rmse_s", s.release_rmse},
                        {"ring_overlap", flagged[f]},
                        {"seat_rms_s", seat.rms()},
                        {"angle_rms_deg", out.angle_deg},
                        {"force_and_voltage_differ_s", differ.rms()},
                        {"cpu_ms_six_channels", out.cpu_ms}});
  }
  return out;
}

double droop_error() {
  double worst = 0;
  for (std::uint64_t seed = 0; seed < 20; ++seed) {
    Random random(seed + 501);
    const double rate = 1e5, w = std::tan(pi * 5.0 / rate);
    Record r;
    r.sample_rate = rate;
    r.fire_sample = 4000;
    ChannelRecord c;
    c.channel = Channel::pvdf_a;
    c.scale = 1e-3;
    c.corner_hertz = 5.0;
    double in = 0, out = 0;
    for (int i = 0; i < 16000; ++i) {
      const double x = i >= 5000 ? 5.0 : 0.0;
      out = ((1 - w) * out + x - in) / (1 + w);
      in = x;
      c.raw.push_back(static_cast<std::int16_t>(std::lround((out + 0.01 * random.normal()) / c.scale)));
    }
    r.channels.push_back(std::move(c));
    const dsp::Force f = dsp::restore_force(r, Channel::pvdf_a, {}, std::nullopt);
    double sum = 0;
    for (std::size_t i = 14500; i < 15500; ++i) sum += f.signal.value[i] / 1000;
    if (std::abs(sum - 5.0) > std::abs(worst)) worst = sum - 5.0;
  }
  return worst;
}

void write_picture(const std::string& path, const std::vector<Mark>& marks) {
  std::ofstream out(path);
  constexpr double left = 70, right = 600, top = 50, bottom = 350;
  const auto x = [&](double ms) { return left + (right - left) * (std::log10(ms) + 0.3) / 2.3; };
  const auto y = [&](double us) { return bottom - (bottom - top) * std::log10(us) / 2.5; };
  out << "<svg xmlns=\"http://www.w3.org/2000/svg\" viewBox=\"0 0 720 410\" font-family=\"sans-serif\" "
         "font-size=\"13\">\n"
      << "<rect width=\"720\" height=\"410\" fill=\"white\"/>\n"
      << "<text x=\"70\" y=\"28\" font-size=\"15\">Touch error against cost: one film, 75 ms at 1 MS/s, 40 "
         "dB</text>\n";
  for (const double us : {1.0, 3.0, 10.0, 30.0, 100.0, 300.0})
    out << "<path d=\"M" << left << ' ' << y(us) << "H" << right << "\" stroke=\"#ddd\"/><text x=\""
        << left - 8 << "\" y=\"" << y(us) + 4 << "\" text-anchor=\"end\">" << us << "</text>\n";
  for (const double ms : {1.0, 3.0, 10.0, 30.0, 100.0})
    out << "<path d=\"M" << x(ms) << ' ' << top << "V" << bottom << "\" stroke=\"#ddd\"/><text x=\"" << x(ms)
        << "\" y=\"" << bottom + 18 << "\" text-anchor=\"middle\">" << ms << "</text>\n";
  out << "<text x=\"335\" y=\"392\" text-anchor=\"middle\">CPU time per record, ms</text>\n"
      << "<text transform=\"translate(22 200) rotate(-90)\" text-anchor=\"middle\">rms error of touch, "
         "us</text>\n";
  for (const bool ring : {false, true}) {
    const char* colour = ring ? "#c0392b" : "#2471a3";
    for (const Mark& m : marks) {
      if (m.ring != ring || !(m.cpu_ms > 0) || !(m.touch_us > 0)) continue;
      out << "<circle cx=\"" << x(m.cpu_ms) << "\" cy=\"" << y(m.touch_us) << "\" r=\"5\" fill=\"" << colour
          << "\"/>"
          << "<text x=\"" << x(m.cpu_ms) + (m.method == "pulse fit" && !ring ? -90 : 9) << "\" y=\""
          << y(m.touch_us) + (ring                      ? -4
                              : m.method == "pulse fit" ? -6
                                                        : 14)
          << "\" fill=\"" << colour << "\">" << m.method << (ring ? ", ringing" : ", clean") << "</text>\n";
    }
  }
  out << "</svg>\n";
  if (!out) throw std::invalid_argument(path + ": cannot be written");
}

}  // namespace powbench::bench
