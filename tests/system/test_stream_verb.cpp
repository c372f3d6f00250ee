#include <catch2/catch.hpp>
#include <cmath>
#include <nlohmann/json.hpp>
#include <sstream>
#include <string>
#include <vector>

#include "tests/system/program.h"

/// `powbench events --stream`: the events of a stored shot and of a waveform file as they would come in.

using namespace powbench::test;
using Catch::Contains;
using nlohmann::json;

namespace {

/// A line of the stream: pvdf_a touch 11.804 ms +- 1.7 us known 20.1 ms later.
struct Line {
  std::string channel, kind;
  double ms = 0, u_us = 0, later_ms = 0;
  bool under_way = true;  ///< before the record's end
};

std::vector<Line> lines_of(const std::string& text) {
  std::vector<Line> all;
  std::istringstream in(text);
  bool under_way = true;
  for (std::string row; std::getline(in, row);) {
    if (row == "  the record ends") under_way = false;
    std::istringstream words(row);
    Line l;
    std::string ms, plus, us, known;
    if (words >> l.channel >> l.kind >> l.ms >> ms >> plus >> l.u_us >> us >> known >> l.later_ms &&
        plus == "+-") {
      l.under_way = under_way;
      all.push_back(l);
    }
  }
  return all;
}

/// Touches of both films in the stream, each beside one of the whole record's.
void compare(const json& whole, const std::vector<Line>& stream) {
  for (const char* film : {"pvdf_a", "pvdf_b"}) {
    CAPTURE(film);
    std::vector<Line> touches;
    for (const Line& l : stream)
      if (l.channel == film && l.kind == "touch") touches.push_back(l);
    const json& contacts = whole.at("channels").at(film).at("contacts");
    CHECK(contacts.size() > 1);
    REQUIRE(touches.size() == contacts.size());
    for (std::size_t i = 0; i < touches.size(); ++i) {
      CAPTURE(i);
      const double apart_us = 1e3 * touches[i].ms - 1e6 * contacts[i].at("touch_s").get<double>();
      CHECK(std::abs(apart_us) < 1 + 1.5 * touches[i].u_us);  // three u; the text ends at 1 us
    }
  }
  int under_way = 0, seats = 0;
  for (const Line& l : stream) {
    seats += l.kind == "seat";
    if (!l.under_way) continue;
    ++under_way;
    CHECK(l.later_ms <= 25.0);
    CHECK(l.later_ms >= 20.0);
  }
  CHECK(under_way > 4);
  CHECK(seats == 1);
}

}  // namespace

TEST_CASE("events --stream: what the whole record shows, at most 25 ms late", "[system]") {
  Folder folder;
  const std::string db = folder.file("lab.db");
  const std::string plan = folder.write("a.plan.toml", "name = \"a\"\nangles_deg = [40]\nrepeats = 1\n");
  REQUIRE(run(folder, {"run", plan, "--rig", "sim:", "--db", db}).status == 0);

  const Finished shot = run(folder, {"events", "1", "--db", db, "--stream"});
  REQUIRE(shot.status == 0);
  CHECK_THAT(shot.out,
             Contains("1: events as they come, at most 25 ms late") && Contains("\n  the record ends\n"));
  compare(json::parse(run(folder, {"events", "1", "--db", db, "--json"}).out), lines_of(shot.out));

  for (const std::vector<std::string>& more :
       std::vector<std::vector<std::string>>{{"--json"},
                                             {"--picture", folder.file("a.svg")},
                                             {"--filter", "lowpass:5kHz"},
                                             {"--force-percent", "10"}}) {
    std::vector<std::string> arguments{"events", "1", "--db", db, "--stream"};
    arguments.insert(arguments.end(), more.begin(), more.end());
    const Finished refused = run(folder, arguments);
    CAPTURE(more.front(), refused.err);
    CHECK(refused.status == 2);
    CHECK(refused.out.empty());
    CHECK_THAT(refused.err, Contains("--stream: not with --json, --picture, --filter or a lab rule"));
  }
}

TEST_CASE("events FILE --stream: a waveform file comes in like a shot", "[system]") {
  Folder folder;
  std::ostringstream csv;
  csv << "time [ms],pvdf_a [N]\n";
  // three blows of 0.4 ms, then closed: each touch where it was put
  const double touches_ms[] = {5.0, 6.1, 7.0, 8.2};
  for (int i = -5000; i < 6000; ++i) {
    const double t = 0.01 * i;
    double force = 0.004 * std::sin(12.9898 * i) + 0.004 * std::sin(78.233 * i + 1);
    for (int k = 0; k < 3; ++k)
      if (t > touches_ms[k] && t < touches_ms[k] + 0.4)
        force += 6 * std::sin(3.14159265 * (t - touches_ms[k]) / 0.4);
    if (t > touches_ms[3]) force += 5 * (1 - std::exp(-(t - touches_ms[3]) / 0.15));
    csv << t << ',' << force << '\n';
  }
  const std::string file = folder.write("blows.csv", csv.str());
  const Finished out = run(folder, {"events", file, "--stream"});
  CAPTURE(out.err, out.out);
  REQUIRE(out.status == 0);
  std::vector<Line> touches;
  for (const Line& l : lines_of(out.out))
    if (l.kind == "touch") touches.push_back(l);
  REQUIRE(touches.size() == 4);
  for (std::size_t i = 0; i < 4; ++i) {
    CHECK(touches[i].channel == "pvdf_a");
    CHECK(touches[i].ms == Approx(touches_ms[i]).margin(0.02));
    CHECK(touches[i].under_way);
  }
}
