#include <catch2/catch.hpp>
#include <cmath>

#include "bench/dsp_synth.h"
#include "core/events.h"
#include "core/normal.h"
#include "dsp/events/doubt.h"
#include "dsp/events/extract.h"
#include "dsp/events/prepare.h"
#include "dsp/events/switch_on.h"
#include "dsp/filter/force.h"
#include "dsp/options.h"
#include "dsp/signal/mains.h"
#include "dsp/signal/statistics.h"
#include "rigs/simulated_record.h"

using namespace powbench;
using namespace powbench::dsp;
using powbench::bench::Random;

namespace {

Signal make(std::size_t n, double rate, double t0, auto&& f) {
  Signal s;
  s.dt = 1 / rate;
  s.t0 = t0;
  s.masked.assign(n, 0);
  for (std::size_t i = 0; i < n; ++i) s.value.push_back(f(s.time(i)));
  return s;
}

Record film_record(std::size_t n, double rate, double corner, auto&& force, double scale = 1e-3) {
  Record r;
  r.sample_rate = rate;
  r.fire_sample = std::llround(0.04 * rate);
  ChannelRecord c;
  c.channel = Channel::pvdf_a;
  c.scale = scale;
  c.corner_hertz = corner;
  for (std::size_t i = 0; i < n; ++i)
    c.raw.push_back(
        static_cast<std::int16_t>(std::lround(force(static_cast<double>(i) / rate - 0.04) / scale)));
  r.channels.push_back(std::move(c));
  return r;
}

}  // namespace

TEST_CASE("counts become SI on the channel's own time axis") {
  Record r = film_record(100, 1e4, 0, [](double) { return 0.0; });
  r.fire_sample = 40;
  r.fire_offset = 25e-6;
  auto& c = r.channels[0];
  c.raw.assign(100, 10);
  c.offset = 5;
  c.scale = -0.5;
  c.delay = 100e-6;
  c.clip_high = 100;
  c.raw[7] = 100;
  r.gaps = {{20, 3}, {98, 50}, {-5, 2}};
  const Signal s = to_signal(r, Channel::pvdf_a);
  CHECK(s.size() == 100);
  CHECK(s.value[0] == -7.5);
  CHECK(s.time(40) == Approx(25e-6 - 100e-6));
  CHECK(s.masked[7] == mask_clipped);
  CHECK(s.masked[19] == mask_none);
  CHECK(s.masked[20] == mask_gap);
  CHECK(s.masked[22] == mask_gap);
  CHECK(s.masked[23] == mask_none);
  CHECK(s.masked[99] == mask_gap);
  CHECK(s.mask_within(s.time(5), s.time(9)) == mask_clipped);
  CHECK(to_signal(r, Channel::laser).empty());
}

TEST_CASE("one value that is not finite costs one sample, not the record") {
  Signal s = make(50, 1e3, 0, [](double t) { return t; });
  s.value[10] = std::nan("");
  s.value[11] = INFINITY;
  s.value[0] = -INFINITY;
  bridge_gaps(s);
  CHECK(s.value[10] == Approx(0.010));
  CHECK(s.value[11] == Approx(0.011));
  CHECK(s.value[0] == s.value[1]);
  CHECK(s.masked[10] == mask_gap);
  for (const double v : s.value) CHECK(std::isfinite(v));
  Signal none = make(3, 1e3, 0, [](double) { return std::nan(""); });
  bridge_gaps(none);
  for (const double v : none.value) CHECK(v == 0.0);
}

TEST_CASE("droop inverse restores a 5 N plateau: 0.5 and 5 Hz corner within 0.02 N after 0.1 s") {
  for (const double corner : {0.5, 5.0}) {
    const std::size_t n = 14000;
    std::vector<double> y(n, 0.0);
    const double w = std::tan(pi * corner / 1e5), a = (1 - w) / (1 + w), b = 1 / (1 + w);
    double before = 0, out = 0;
    for (std::size_t i = 0; i < n; ++i) {
      const double in = i >= 4000 ? 5.0 : 0.0;
      out = a * out + b * (in - before);
      before = in;
      y[i] = out;
    }
    const double droop = 5.0 * (1 - std::exp(-2 * pi * corner * 0.1));
    CHECK(y.back() - 5.0 == Approx(-droop).epsilon(0.01));  // -1.34 N and -4.78 N without correction
    undo_droop(y, corner, 1e-5);
    CHECK(std::abs(y.back() - 5.0) < 1e-9);
  }
  // The whole front end on a noisy, quantised record with offset.
  Random random(3);
  for (const double corner : {0.5, 5.0}) {
    const double tau = 1 / (2 * pi * corner);
    const Record r = film_record(14000, 1e5, corner, [&](double t) {
      return (t >= 0 ? 5.0 * std::exp(-t / tau) : 0.0) + 0.05 * random.normal() + 0.8;
    });
    const Force f = restore_force(r, Channel::pvdf_a, {}, std::nullopt);
    CHECK(std::abs(f.settled - 5.0) < 0.02);
    CHECK(f.noise == Approx(0.05).epsilon(0.1));
  }
}

TEST_CASE("hum is fitted on the pre-trigger and refused with less than two periods") {
  Random random(4);
  const auto hum = [](double t) {
    return 0.5 * std::sin(2 * pi * 50.2 * t + 1) + 0.15 * std::sin(2 * pi * 150.6 * t);
  };
  const Record r = film_record(14000, 1e5, 0, [&](double t) { return hum(t) + 0.02 * random.normal() + 2; });
  for (const auto hertz : {std::optional<double>(50.2), std::optional<double>()}) {
    const Force f = restore_force(r, Channel::pvdf_a, {}, hertz);
    CHECK((f.flags & flag_no_hum_fit) == 0);
    double worst = 0;
    for (const double v : gaussian_smooth(f.signal.value, 20)) worst = std::max(worst, std::abs(v));
    CHECK(worst < (hertz ? 0.02 : 0.06));  // 100 ms of extrapolation
  }
  Record brief = r;
  brief.fire_sample = 3000;  // 1.5 periods
  CHECK((restore_force(brief, Channel::pvdf_a, {}, std::nullopt).flags & flag_no_hum_fit) != 0);
}

TEST_CASE("four-parameter fit: exact on a clean sine, honest in noise, refused when short") {
  const auto sine = [](double t) {
    return 325 * std::sin(2 * pi * 50.5 * t + 0.7) + 9.75 * std::sin(5 * 2 * pi * 50.5 * t + 1) + 3;
  };
  const Signal clean = make(4000, 1e5, -0.04, sine);
  const auto fit = fit_harmonics(clean, -1, 0, {1, 3, 5, 7}, 50, true, 1.95);
  REQUIRE(fit);
  CHECK(fit->hertz == Approx(50.5).margin(1e-6));
  CHECK(fit->amplitude(0) == Approx(325).margin(1e-5));
  CHECK(fit->amplitude(2) == Approx(9.75).margin(1e-5));
  CHECK(fit->offset == Approx(3).margin(1e-5));
  CHECK(fit->phase_at(0.0).value == Approx(0.7).margin(1e-6));
  const Signal whole = make(60'000, 1e5, -0.04, sine);
  Signal rest = whole;
  fit->subtract_from(rest);
  double worst = 0;
  for (std::size_t i = 0; i < whole.size(); ++i)
    worst = std::max(worst, std::abs(rest.value[i] - (whole.value[i] - fit->value(whole.time(i)))));
  CHECK(worst < 1e-10);  // of 325

  Random random(5);
  double z2 = 0;
  const int n = 100;
  for (int k = 0; k < n; ++k) {
    const Signal noisy = make(4000, 1e5, -0.04, [&](double t) { return sine(t) + 3.25 * random.normal(); });
    const auto m = fit_harmonics(noisy, -1, 0, {1, 3, 5, 7}, 50, true, 1.95)->phase_at(0.0);
    z2 += std::pow((m.value - 0.7) / m.u, 2) / n;
    CHECK(std::abs(m.value - 0.7) < radians(0.3));
  }
  CHECK(std::sqrt(z2) > 0.8);
  CHECK(std::sqrt(z2) < 1.25);

  CHECK_FALSE(fit_harmonics(clean, -0.03, 0, {1}, 50, true, 1.95));
  CHECK_FALSE(fit_harmonics({}, -1, 0, {1}, 50, true, 1.95));
}

TEST_CASE("an inverted film is turned over and flagged") {
  bench::SynthSettings s;
  s.rate = 1e5;
  auto r = bench::synthesise(s, 1).record;
  const Force upright = restore_force(r, Channel::pvdf_a, {}, std::nullopt);
  CHECK((upright.flags & flag_polarity) == 0);
  r.channels[0].scale = -r.channels[0].scale;
  const Force turned = restore_force(r, Channel::pvdf_a, {}, std::nullopt);
  CHECK((turned.flags & flag_polarity) != 0);
  CHECK(turned.signal.value[7000] == Approx(upright.signal.value[7000]));
}

TEST_CASE("options have one canonical text and are checked") {
  ExtractOptions a, b;
  CHECK(to_text(a) == to_text(b));
  CHECK(parameters_hash(a) == parameters_hash(b));
  CHECK(parameters_hash(a).size() == 16);
  b.min_open = std::nextafter(b.min_open, 1.0);
  CHECK(to_text(a) != to_text(b));
  CHECK(parameters_hash(a) != parameters_hash(b));
  CHECK(to_text(a).find("detection_width=1.2") != std::string::npos);
  b.min_open = std::nan("");
  CHECK_THROWS_AS(check(b), std::invalid_argument);
  b = {};
  b.open_share = 1.0;
  CHECK_THROWS_AS(check(b), std::invalid_argument);
  b = {};
  b.min_open = -1e-6;
  CHECK_THROWS_AS(check(b), std::invalid_argument);
}

TEST_CASE("prepared signals: low-passed force with its edge masked") {
  const Record r = bench::synthesise_full(1e5, 50, 1.0, 1);
  const Prepared p = prepare(r);
  REQUIRE(p.pvdf_a.size() == r.samples());
  CHECK(p.edge_samples > 5);
  CHECK(p.pvdf_a.masked[p.edge_samples - 1] == mask_edge);
  CHECK(p.pvdf_a.masked[p.edge_samples] == mask_none);
  const std::size_t late = p.pvdf_a.index_at(0.09);
  CHECK(p.pvdf_a.value[late] == Approx(3.0).margin(0.2));
  CHECK(p.laser.value[100] == Approx(0.0).margin(5e-6));
}

TEST_CASE("a time 0 that is not the switch-on is flagged, whatever shows it") {
  int cuts = 0, seen = 0;
  for (const double angle : {0.0, 0.7, 1.57, 2.6}) {
    for (const bool voltage : {true, false}) {
      Conditions c;
      c.closing_angle = angle;
      Record r = rigs::simulate_record(sim::Specimen{}, c, rigs::SimRigConfig{}).record;
      if (!voltage)
        std::erase_if(r.channels, [](const auto& x) { return x.channel == Channel::coil_voltage; });
      INFO("angle " << angle << ", voltage " << voltage);
      CHECK((extract_events(r).flags & flag_switch_on) == 0);
      CHECK(std::isnan(contradicted_switch_on(r)));
      const auto shifted = [&](double by) {
        Record other = r;
        other.fire_sample += std::lround(by * r.sample_rate);
        return other;
      };
      for (const double late : {6e-3, 17.2e-3, 40e-3})  // the clock counts from the contact, say
        CHECK(contradicted_switch_on(shifted(late)) == Approx(-late).margin(voltage ? 2.5e-3 : 6e-3));
      CHECK_FALSE(std::isnan(contradicted_switch_on(shifted(-8e-3))));
      if (angle == 0.7) {
        CHECK((extract_events(shifted(6e-3)).flags & flag_switch_on) != 0);
        CHECK((extract_events(shifted(-8e-3)).flags & flag_switch_on) != 0);
      }
      for (const double at : {9e-3, 13e-3, 17e-3, 31e-3}) {  // the record begins where something triggered it
        Record cut = r;
        const auto first = static_cast<std::size_t>(r.fire_sample + std::lround(at * r.sample_rate));
        for (ChannelRecord& x : cut.channels)
          x.raw.erase(x.raw.begin(), x.raw.begin() + std::ptrdiff_t(first));
        cut.fire_sample = 0;
        if (!voltage) ++cuts, seen += !std::isnan(contradicted_switch_on(cut));
      }
    }
  }
  CHECK(seen > 0);  // a current that happens to be near zero looks like one that begins
  CHECK(seen < cuts);
}

TEST_CASE("a contact that chatters to the end of the record has not settled") {
  ContactTrain t;
  for (int k = 0; k < 6; ++k) {  // closed for 6 ms, open for 4
    Contact c;
    c.touch = {0.012 + 0.01 * k, 1e-6};
    if (k < 5) c.release = {c.touch.value + 6e-3, 1e-6};
    t.contacts.push_back(c);
  }
  t.settled = t.contacts.back().touch;
  t.bounce_time = {0.05, 2e-6};
  for (const double end : {0.063, 0.066, 0.0709}) {
    ContactTrain seen = t;
    doubt_settled(seen, {end, end, false});
    CHECK_FALSE(seen.settled.known());
    CHECK_FALSE(seen.bounce_time.known());
    CHECK((seen.flags & flag_chatter) != 0);
  }
  ContactTrain longer = t;  // closed for 9 ms and more
  doubt_settled(longer, {0.0711, 0.0711, false});
  CHECK(longer.settled.known());
  CHECK((longer.flags & flag_chatter) == 0);
}

TEST_CASE("noise on the coil's channels says nothing of the switch-on") {
  Record r = bench::synthesise_full(1e5, 50, 1.0, 1);
  Random random(5);
  for (ChannelRecord& x : r.channels)
    if (x.channel == Channel::coil_voltage || x.channel == Channel::coil_current)
      for (auto& v : x.raw) v = static_cast<std::int16_t>(20 * random.normal());
  CHECK((extract_events(r).coil.flags & flag_switch_on) == 0);
}

TEST_CASE("statistics") {
  CHECK(median(std::vector<double>{3, 1, 2}) == 2);
  CHECK(median(std::vector<double>{4, 1, 2, 3}) == 2.5);
  CHECK(std::isnan(median({})));
  CHECK(normal_quantile(0.975) == Approx(1.959963984540054).epsilon(1e-14));
  CHECK(normal_quantile(0.001) == Approx(-3.090232306167813).epsilon(1e-14));
  CHECK(reduced_chi2_quantile(0.99, 10) == Approx(2.32).epsilon(0.01));
  std::vector<double> step(100, 0.0);
  std::fill(step.begin() + 50, step.end(), 1.0);
  for (const double v : gaussian_smooth(step, 4)) CHECK((v >= -1e-12 && v <= 1 + 1e-12));  // never overshoots
}
