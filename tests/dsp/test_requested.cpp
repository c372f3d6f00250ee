#include "dsp/events/requested.h"

#include <catch2/catch.hpp>
#include <cmath>

#include "bench/dsp_synth.h"
#include "bench/events/scenes.h"
#include "core/units.h"
#include "dsp/events/extract.h"
#include "dsp/filter/bands.h"
#include "dsp/filter/sos.h"
#include "tests/effort.h"

using namespace powbench;
using namespace powbench::dsp;
using Catch::Contains;

namespace {

using Kind = EventFilter::Kind;

EventFilter low_pass(double hertz, FilterPhase phase) {
  return {Kind::low, 0, hertz, phase, false};
}
EventFilter band_stop(double low, double high, FilterPhase phase) {
  return {Kind::stop, low, high, phase, false};
}

/// Errors over u against the truth, edge by edge.
struct Score {
  int edges = 0, beyond = 0, applied = 0, exact = 0;
  double touch_error = 0;  ///< s, sum
  int touches = 0;

  void add(const std::vector<bench::TrueContact>& truth, const Extracted& got) {
    if (!got.filter || !got.filter->refused.empty()) return;
    ++applied;
    const auto& found = got.events.pvdf_a.contacts;
    if (found.size() != truth.size()) return;
    ++exact;
    for (std::size_t i = 0; i < truth.size(); ++i) {
      edge(found[i].touch, truth[i].touch);
      touch_error += found[i].touch.value - truth[i].touch;
      ++touches;
      if (found[i].release.known() && std::isfinite(truth[i].release))
        edge(found[i].release, truth[i].release);
    }
  }
  void edge(const Measured& m, double truth) {
    ++edges;
    beyond += !(std::abs(m.value - truth) <= 3 * m.u);
  }
};

bench::SynthRecord ringing(std::uint64_t seed) {
  return bench::synthesise({.force_case = bench::ForceCase::ring_out_of_band,
                            .form = static_cast<bench::PulseForm>(seed % 3),
                            .rate = 200e3},
                           seed);
}

Extracted with(const Record& record, const EventFilter& filter) {
  ExtractOptions o;
  o.filter = filter;
  return extract_on_request(record, o);
}

/// Half-sine pulses in silence, a millisecond open between them, then closed.
Record pulses(double width) {
  Record r;
  r.sample_rate = 200e3;
  r.fire_sample = 9000;
  r.calibration = "made up";
  ChannelRecord film;
  film.channel = Channel::pvdf_a;
  film.scale = 1e-3;
  bench::Random random(5);
  for (std::size_t i = 0; i < 19000; ++i) {
    const double t = r.time(i), v = (t - 10e-3) / width, after = t - 10e-3 - width - 1e-3;
    double force = v > 0 && v < 1 ? 8 * std::sin(pi * v) : 0.0;
    if (after > 0) force = 4 * (1 - std::exp(-after / 0.5e-3));
    film.raw.push_back(static_cast<std::int16_t>(std::lround(1e3 * (force + 0.02 * random.normal()))));
  }
  r.channels = {film};
  return r;
}

}  // namespace

TEST_CASE("without a filter nothing changes, and a text without one names none") {
  const auto s = ringing(3);
  const Events plain = extract_events(s.record), same = extract_on_request(s.record, {}).events;
  REQUIRE(plain.pvdf_a.contacts.size() == same.pvdf_a.contacts.size());
  for (std::size_t i = 0; i < plain.pvdf_a.contacts.size(); ++i)
    CHECK(plain.pvdf_a.contacts[i].touch.value == same.pvdf_a.contacts[i].touch.value);
  CHECK(plain.parameters_hash == same.parameters_hash);
  CHECK(to_text({}).find("filter") == std::string::npos);
  ExtractOptions o;
  o.filter = low_pass(8e3, FilterPhase::causal);
  CHECK_THAT(to_text(o), Contains("filter=lowpass\n") && Contains("filter_phase=causal\n"));
  CHECK(parameters_hash(o) != parameters_hash({}));
}

TEST_CASE("a step: zero phase moves it nowhere, a causal filter by the delay that it states") {
  const double rate = 200e3;
  for (const auto& filter :
       {low_pass(8e3, FilterPhase::zero), low_pass(2e3, FilterPhase::causal),
        band_stop(3e3, 4e3, FilterPhase::zero), band_stop(3e3, 4e3, FilterPhase::causal)}) {
    CAPTURE(name_of(filter));
    Signal s;
    s.dt = 1 / rate;
    s.t0 = -0.05;
    s.value.assign(20000, 0.0);
    s.masked.assign(20000, mask_none);
    for (std::size_t i = 10000; i < 20000; ++i) s.value[i] = 5.0;
    const double step = s.time(10000) - 0.5 * s.dt;
    const FilterEffect e = effect_of(filter, rate);
    apply_filter(s, filter);
    std::size_t i = 1;
    while (s.value[i] < 2.5) ++i;
    const double half = s.time(i - 1) + s.dt * (2.5 - s.value[i - 1]) / (s.value[i] - s.value[i - 1]);
    CHECK(std::abs(half - step) < 0.01 * s.dt);
    // nothing stands out earlier or later than stated
    for (std::size_t k = 0; k < s.size(); ++k) {
      if (s.time(k) < step - e.before - s.dt) CHECK(std::abs(s.value[k]) <= 0.03 * 5);
      if (s.time(k) > step + e.after + s.dt) CHECK(std::abs(s.value[k] - 5) <= 0.03 * 5);
    }
  }
  // a Butterworth of order 2 is late by sqrt(2) / w at low frequency; half of a step comes somewhat later
  const FilterEffect causal = effect_of(low_pass(2e3, FilterPhase::causal), rate);
  CHECK(causal.delay == Approx(std::sqrt(2.0) / (2 * pi * 2e3)).epsilon(0.05));
  CHECK(effect_of(low_pass(2e3, FilterPhase::zero), rate).delay == 0.0);
}

TEST_CASE("with a ring, behind any filter: edges within what u says, and every contact there") {
  for (const auto& filter :
       {low_pass(10e3, FilterPhase::zero), low_pass(10e3, FilterPhase::causal),
        band_stop(12e3, 18e3, FilterPhase::zero), band_stop(12e3, 18e3, FilterPhase::causal)}) {
    CAPTURE(name_of(filter));
    Score score;
    int found = 0;
    for (std::uint64_t seed = 31; seed < 37; ++seed) {
      const auto s = ringing(seed);
      const Extracted got = with(s.record, filter);
      REQUIRE(got.filter);
      const FilmFilter& film = got.filter->films.front();
      found += film.found;
      if (film.found) CHECK(film.vibration_db < -5);
      CHECK_THAT(got.events.method, Contains(name_of(filter)));
      score.add(s.contacts, got);
    }
    CHECK(found >= 5);
    CHECK(score.applied >= 5);  // an opening of 0.15 ms refuses a low-pass at 10 kHz
    CHECK(score.exact == score.applied);
    CHECK(score.edges > 25);
    CHECK(score.beyond <= 1);
    // never silently late: the mean touch is not behind the truth by more than what rounding of a sample makes
    CHECK(score.touch_error / score.touches < 5e-6);
  }
}

TEST_CASE("impacts that jump, behind a low-pass: the edge it smears is in u", "[slow]") {
  constexpr int step = effort::every > 1 ? 4 : 1;
  for (const auto& filter : {low_pass(8e3, FilterPhase::zero), low_pass(8e3, FilterPhase::causal)}) {
    CAPTURE(name_of(filter));
    Score score;
    for (const auto& c : bench::scene_classes())
      if (c.name.starts_with("damped") || c.name.starts_with("Hunt"))
        for (std::uint64_t seed = 900; seed < 904; seed += step) {
          const auto s = c.make(seed);
          score.add(s.contacts, with(s.record, filter));
        }
    CHECK(score.exact >= 10 / step);
    CHECK(score.beyond <= score.edges / 25);
  }
}

TEST_CASE(
    "a filter that would eat a contact is refused with its figures, and the events are those without it") {
  const Record brief = pulses(0.2e-3);
  const Extracted got = with(brief, low_pass(2e3, FilterPhase::zero));
  REQUIRE(got.filter);
  CHECK_THAT(got.filter->refused, Contains("low-pass 2 kHz zero phase takes") && Contains("dB") &&
                                      Contains("allowed -20 dB or less") && Contains("a low-pass from"));
  CHECK_FALSE(got.filter->filter.judged);
  CHECK(got.filter->films.front().contact_db > most_taken_db);
  CHECK(got.filter->films.front().shortest == Approx(0.2e-3).epsilon(0.1));
  const Events bare = extract_events(brief);
  REQUIRE(bare.pvdf_a.contacts.size() == got.events.pvdf_a.contacts.size());
  CHECK(bare.pvdf_a.contacts[0].touch.value == got.events.pvdf_a.contacts[0].touch.value);
  CHECK_THAT(got.events.method, Contains("filter refused"));
  // the least low-pass named is one that is taken
  const std::size_t at = got.filter->refused.find("from ");
  const double least = 1e3 * std::stod(got.filter->refused.substr(at + 5));
  CHECK(with(brief, low_pass(1.02 * least, FilterPhase::zero)).filter->refused.empty());
  CHECK_FALSE(with(brief, low_pass(0.97 * least, FilterPhase::zero)).filter->refused.empty());
}

TEST_CASE(
    "the plain filter: taken where vibration lies far above the contacts, refused in dB where it does not") {
  const auto in_band = bench::synthesise({.force_case = bench::ForceCase::ring_in_band, .rate = 200e3}, 4);
  CHECK_THAT(with(in_band.record, {Kind::plain}).filter->refused, Contains("dB of the vibration lies below"));
  const auto far = ringing(31);
  const Extracted got = with(far.record, {Kind::plain});
  REQUIRE(got.filter->refused.empty());
  CHECK(got.filter->filter.high_hertz == Approx(1.5 / got.filter->films.front().shortest));
  CHECK(got.filter->films.front().vibration_db < -30);
  Score score;
  score.add(far.contacts, got);
  CHECK(score.exact == 1);
  CHECK(score.beyond == 0);
}

TEST_CASE("where half the sample rate takes too much of a contact already no low-pass is named") {
  Record slow = pulses(0.4e-3);
  for (ChannelRecord& c : slow.channels) {
    std::vector<std::int16_t> every_tenth;
    for (std::size_t i = 0; i < c.raw.size(); i += 10) every_tenth.push_back(c.raw[i]);
    c.raw = std::move(every_tenth);
  }
  slow.sample_rate /= 10, slow.fire_sample /= 10;
  Extracted bare = extract_on_request(slow, {});
  Contact brief;
  brief.touch = {5e-3, 1e-6}, brief.release = {5.05e-3, 1e-6};
  auto& contacts = bare.events.pvdf_a.contacts;
  contacts.insert(contacts.begin(), brief);
  ExtractOptions o;
  o.filter = low_pass(4e3, FilterPhase::zero);
  const FilterJudgement j = judge_filter(slow, bare.events, bare.bare, o);
  REQUIRE(j.films.front().shortest == Approx(50e-6));
  CHECK_THAT(j.refused, Contains("no low-pass at this sample rate"));
}

TEST_CASE("what cannot be filtered is said") {
  const auto s = ringing(3);
  CHECK_THAT(with(s.record, low_pass(150e3, FilterPhase::zero)).filter->refused, Contains("allowed"));
  Record none;
  none.sample_rate = 1e5;
  CHECK_THAT(with(none, low_pass(2e3, FilterPhase::zero)).filter->refused, Contains("no force channel"));
  const Extracted narrow = with(s.record, band_stop(100, 105, FilterPhase::causal));
  CHECK_THAT(narrow.filter->refused, Contains("shorter than the filter's memory"));
  CHECK_FALSE(narrow.events.pvdf_a.contacts.empty());  // a shot is not lost to its filter
}

TEST_CASE(
    "energy taken from a half sine: all by nothing, none by everything, as much as lies above an edge") {
  CHECK(half_sine_taken_db([](double) { return 0.0; }, 1e-3) == Approx(0).margin(1e-9));
  CHECK(half_sine_taken_db([](double) { return 1.0; }, 1e-3) < -44);
  const double edge = 1e3, below = half_sine_energy_below(edge, 1e-3);
  CHECK(half_sine_taken_db([&](double f) { return f < edge ? 1.0 : 0.0; }, 1e-3) ==
        Approx(10 * std::log10(1 - below)).margin(0.02));
}
