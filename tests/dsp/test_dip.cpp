#include <algorithm>
#include <catch2/catch.hpp>
#include <cmath>
#include <vector>

#include "bench/dsp_rig_truth.h"
#include "bench/dsp_synth.h"
#include "dsp/contacts/dip.h"
#include "dsp/contacts/openings.h"
#include "dsp/events/extract.h"

/// Whether a contact opened in a dip, on indentations whose least value is drawn, with the friction of a guide; and
/// what an opening too short to be listed does to the times around it.

using namespace powbench;
using namespace powbench::dsp;

namespace {

constexpr double middle = 2e-3, noise = 0.03;  // s, N

/// Least indentation `least`, um; the force of `law` is 10 N at 80 um. 200 kS/s.
Signal dip_of(double least, double law, double friction, double zero, bench::Random& r) {
  Signal s;
  s.dt = 5e-6;
  s.value.resize(800);
  s.masked.assign(800, mask_none);
  for (std::size_t i = 0; i < s.size(); ++i) {
    const double t = s.time(i) - middle, side = t < 0 ? -1 : 1;
    const double um = least + 0.5e6 * 800 * (1 + side * friction) * t * t;  // 4 N on 5 g
    s.value[i] = zero + (um > 0 ? 10 * std::pow(um / 80, law) : 0.0) + noise * r.normal();
  }
  return s;
}

}  // namespace

TEST_CASE("dip: an opening and a force that stays are told apart where the noise allows", "[dip]") {
  bench::Random r(4711);
  for (const double law : {1.0, 1.5}) {
    const Dip open =
        look_at_dip(dip_of(-8, law, 0.1, 0.01, r), middle - 140e-6, middle + 140e-6, 1e-3, noise);
    CHECK(open.known);
    CHECK(open.opened > 0.997);
    const Dip closed = look_at_dip(dip_of(8, law, 0.1, 0.01, r), middle - 30e-6, middle + 30e-6, 1e-3, noise);
    CHECK(closed.known);
    CHECK(closed.opened < 0.003);
  }
}

TEST_CASE("dip: of those called open with a probability, that share is open", "[dip]") {
  bench::Random r(4712);
  int known = 0;
  double expected = 0, opened = 0, variance = 0, doubtful = 0;
  constexpr int trials = 240;
  for (int k = 0; k < trials; ++k) {
    const double least = r.uniform(-4, 4), law = r.uniform() < 0.5 ? 1.0 : 1.5;
    const Signal s = dip_of(least, law, r.uniform(-0.12, 0.12), r.uniform(-0.02, 0.02), r);
    const Dip d = look_at_dip(s, middle - 60e-6, middle + 60e-6, 1e-3, noise);
    known += d.known;
    if (!d.known) continue;
    expected += d.opened, opened += least < 0, variance += d.opened * (1 - d.opened);
    doubtful += d.opened > 0.003 && d.opened < 0.997;
  }
  CAPTURE(expected, opened, doubtful);
  CHECK(known > 0.9 * trials);
  CHECK(std::abs(opened - expected) < 3 * std::sqrt(variance) + 1);
  CHECK(doubtful > 0.2 * trials);  // else the noise would decide nothing here
}

TEST_CASE("dip: an opening that is not listed is a doubt of the contact it lies in", "[dip]") {
  bench::Random r(4713);
  const auto doubts = [&](double least) {
    std::vector<Contact> one(1);
    one[0].touch = {middle - 0.35e-3, 1e-6}, one[0].release = {middle + 0.35e-3, 1e-6};
    std::vector<Grazing> grazing;
    doubt_dips(one, grazing, dip_of(least, 1.25, 0.1, 0, r), noise, 0);
    CHECK(grazing.empty() == !(one[0].flags & flag_grazing));
    return grazing;
  };
  CHECK(doubts(8).empty());  // 0.6 N stand clear of zero
  const std::vector<Grazing> open = doubts(-0.5);
  REQUIRE(open.size() == 1);
  CHECK_FALSE(open[0].listed);
  CHECK(open[0].opened > 0.2);
  CHECK(std::abs(open[0].release - middle) < 0.1e-3);
  CHECK(open[0].after > open[0].release);
}

/// At this angle both contacts of the rig open for 17 us, shorter than the levels resolve, a millisecond before they
/// part: the one contact that is listed ends at either.
TEST_CASE("dip: a short opening of the simulated rig is in u", "[dip]") {
  bench::RigTruth rig = bench::rig_record(200e3, 2 * pi * 9.3 / 25, 50.0, 310009);
  std::erase_if(rig.record.channels, [](const ChannelRecord& c) {
    return c.channel == Channel::contact_a || c.channel == Channel::aux;
  });
  const ContactTrain film = extract_events(rig.record, {}).pvdf_a;
  const auto truth = std::find_if(rig.film_a.begin(), rig.film_a.end(),
                                  [](const bench::TrueContact& c) { return c.release > 16.4e-3; });
  REQUIRE(std::next(truth)->touch - truth->release < 20e-6);
  const auto found = std::find_if(film.contacts.begin(), film.contacts.end(), [&](const Contact& c) {
    return std::abs(c.touch.value - truth->touch) < 10e-6;
  });
  REQUIRE(found != film.contacts.end());
  CHECK((found->flags & flag_grazing) != 0);
  CHECK(std::abs(found->release.value - truth->release) < 3 * found->release.u);
}
