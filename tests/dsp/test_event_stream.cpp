#include <algorithm>
#include <catch2/catch.hpp>
#include <cmath>
#include <limits>
#include <stdexcept>
#include <string>
#include <vector>

#include "bench/dsp_synth.h"
#include "bench/events/scenes.h"
#include "dsp/events/event_stream.h"
#include "dsp/events/extract.h"
#include "tests/effort.h"

// Events of a record that comes in piece by piece, against the same record at once.

using namespace powbench;
using namespace powbench::dsp;

namespace {

Record shape_of(Record r) {
  for (ChannelRecord& c : r.channels) c.raw.clear();
  return r;
}

std::vector<StreamEvent> streamed(const Record& r, std::size_t chunk) {
  EventStream stream(shape_of(r));
  std::vector<StreamEvent> all;
  std::vector<std::int16_t> scans;
  for (std::size_t i = 0; i < r.samples(); i += chunk) {
    scans.clear();
    for (std::size_t k = i; k < std::min(i + chunk, r.samples()); ++k)
      for (const ChannelRecord& c : r.channels) scans.push_back(c.raw[k]);
    for (const StreamEvent& e : stream.push(static_cast<std::int64_t>(i), scans)) all.push_back(e);
  }
  for (const StreamEvent& e : stream.finish()) all.push_back(e);
  return all;
}

bool same_bits(const StreamEvent& a, const StreamEvent& b) {
  return a.channel == b.channel && a.kind == b.kind && a.time.value == b.time.value && a.time.u == b.time.u &&
         a.known == b.known;
}

struct Agreement {
  int batch = 0, stream = 0, matched = 0, beyond = 0, late = 0, under_way = 0;
};

/// Every touch and release of the film, one to one.
void compare(const Record& r, Agreement& sum) {
  const ContactTrain t = extract_events(r).pvdf_a;
  std::vector<StreamEvent> left;
  for (const StreamEvent& e : streamed(r, 997))
    if (e.channel == Channel::pvdf_a) left.push_back(e);
  sum.stream += static_cast<int>(left.size());
  const double end = r.time(r.samples() - 1);
  for (const StreamEvent& e : left)
    if (e.known < end - 1e-6) ++sum.under_way, sum.late += e.latency() > stream_latency;
  const auto match = [&](const Measured& m, StreamEvent::Kind kind) {
    if (!m.known()) return;
    ++sum.batch;
    const auto found = std::find_if(left.begin(), left.end(), [&](const StreamEvent& e) {
      return e.kind == kind && std::abs(e.time.value - m.value) < 100e-6;
    });
    if (found == left.end()) return;
    ++sum.matched;
    sum.beyond += std::abs(found->time.value - m.value) > 3 * std::hypot(found->time.u, m.u);
    left.erase(found);
  };
  for (const Contact& c : t.contacts)
    match(c.touch, StreamEvent::Kind::touch), match(c.release, StreamEvent::Kind::release);
}

}  // namespace

TEST_CASE("a stream gives the same events to the last bit, however it is cut into pieces") {
  const Record r = bench::synthesise_full(1e5, 50, 1.0, 11);
  const auto once = streamed(r, r.samples());
  REQUIRE(once.size() > 12);
  for (const std::size_t chunk : {std::size_t{1}, std::size_t{7}, std::size_t{500}, std::size_t{4096}}) {
    const auto pieces = streamed(r, chunk);
    REQUIRE(pieces.size() == once.size());
    for (std::size_t k = 0; k < once.size(); ++k) CHECK(same_bits(pieces[k], once[k]));
  }
}

TEST_CASE("a stream agrees with the record at once, and keeps its latency") {
  constexpr std::uint64_t seeds = effort::every > 1 ? 1 : 3;
  Agreement sum;
  for (const bench::SceneClass& c : bench::scene_classes()) {
    if (!c.touches || c.name == "all at once" || c.name.find("ring") != std::string::npos) continue;
    for (std::uint64_t seed = 810001; seed < 810001 + seeds; ++seed) compare(c.make(seed).record, sum);
  }
  for (const std::uint64_t seed : {61, 62})  // with core vibration
    compare(bench::synthesise_full(1e5, 50, 1.0, seed), sum);
  CAPTURE(sum.batch, sum.stream, sum.matched, sum.beyond, sum.late, sum.under_way);
  REQUIRE(sum.batch > 66 * static_cast<int>(seeds));
  CHECK(sum.matched >= 0.98 * sum.batch);
  CHECK(sum.stream <= 1.02 * sum.batch);
  CHECK(sum.beyond <= 0.01 * sum.matched);
  CHECK(sum.under_way > 0.8 * sum.stream);  // the rest when the record ends
  CHECK(sum.late == 0);
}

TEST_CASE("a stream refuses what cannot be one, and takes nothing of it") {
  const Record r = shape_of(bench::synthesise_full(1e5, 50, 1.0, 3));
  const std::vector<std::int16_t> scans(10 * r.channels.size());
  EventStream stream(r);
  stream.push(0, scans);
  CHECK_THROWS_WITH(stream.push(11, scans), Catch::Contains("sample 11 came, 10 follows"));
  CHECK_THROWS_WITH(stream.push(9, scans), Catch::Contains("sample 9 came, 10 follows"));
  CHECK_THROWS_WITH(stream.push(10, std::span(scans).first(3)), Catch::Contains("whole scans"));
  CHECK_NOTHROW(stream.push(10, scans));
  Record bad = r;
  bad.sample_rate = std::numeric_limits<double>::quiet_NaN();
  CHECK_THROWS_AS(EventStream(bad), std::invalid_argument);
  bad = r, bad.channels.clear();
  CHECK_THROWS_AS(EventStream(bad), std::invalid_argument);
  bad = r, bad.fire_sample = 200000;
  CHECK_THROWS_WITH(EventStream(bad), Catch::Contains("fire_sample = 200000"));
}
