#include <catch2/catch.hpp>
#include <cctype>
#include <cmath>
#include <string>

#include "host/compare/compare.h"
#include "host/report/best_angle.h"
#include "host/report/number.h"
#include "host/report/report.h"
#include "host/report/view.h"
#include "tests/effort.h"
#include "tests/host/report_samples.h"
#include "tests/host/report_xml_check.h"

using namespace powbench;
using namespace powbench::host;
using test::without_own_scripts;
using test::xml_error;

namespace {

bool has_word(const std::string& text, const std::string& word) {
  const auto letter = [](char c) { return std::isalpha(static_cast<unsigned char>(c)) != 0; };
  for (auto i = text.find(word); i != std::string::npos; i = text.find(word, i + 1)) {
    const bool before = i > 0 && letter(text[i - 1]);
    const bool after = i + word.size() < text.size() && letter(text[i + word.size()]);
    if (!before && !after) return true;
  }
  return false;
}

bool contains(const std::string& text, const std::string& part) {
  return text.find(part) != std::string::npos;
}

/// What must hold for every report whatsoever.
void check_page(const ReportInput& in) {
  const std::string page = render_html(in), junit = render_junit(in), html = without_own_scripts(page);
  CHECK(xml_error(page) == "");
  CHECK(xml_error(junit) == "");
  for (const std::string word : {"nan", "inf", "NaN", "-nan"}) {
    CHECK_FALSE(has_word(html, word));
    CHECK_FALSE(has_word(junit, word));
  }
  CHECK_FALSE(contains(html, "<script"));
  CHECK_FALSE(contains(html, "src="));
  CHECK_FALSE(contains(html, "href="));
  CHECK_FALSE(contains(html, "@import"));
  CHECK_FALSE(contains(html, "url("));
}

}  // namespace

TEST_CASE("an empty campaign gives a complete page", "[report]") {
  ReportInput in;
  check_page(in);
  CHECK(verdict(in) == Outcome::aborted);
  CHECK(contains(render_html(in), "No shot has been fired"));
  in.planned = 21;
  check_page(in);
  CHECK(count(in).missing == 21);
  CHECK(contains(render_junit(in), "0 of 21 planned shots fired"));
}

TEST_CASE("one shot, without simulation or publication", "[report]") {
  ReportInput in;
  in.campaign = "single";
  in.planned = 1;
  in.shots = {some_shot(1)};
  compare_into(in);
  check_page(in);
  CHECK(verdict(in) == Outcome::pass);
  const std::string html = render_html(in);
  CHECK(contains(html, "Closing angle 30\xC2\xB0"));
  CHECK(contains(html, "12.000"));         // t_ct1 in ms
  CHECK(contains(html, "0123456789ab<"));  // record hash, shortened
  CHECK_FALSE(contains(html, "<td>0.066</td>"));
  in.shots[0].phase_u = radians(0.0331);               // of the mains, by the rig
  CHECK(contains(render_html(in), "<td>0.066</td>"));  // U, k = 2
  CHECK(contains(html, "@media print"));
}

TEST_CASE("everything unknown in a shot's events prints dashes", "[report]") {
  ReportInput in;
  in.planned = 1;
  in.shots = {some_shot(1)};
  in.shots[0].events = Events{};
  in.shots[0].waveforms = {Waveform{"pvdf_a", "N", 0, 1e-5, std::vector<float>(50, std::nanf(""))},
                           Waveform{"laser", "m", 0, 0, {1, 2}}, Waveform{"coil_current", "A", 0, 1e-5, {}}};
  in.published = published_rows();
  Limit limit;
  limit.quantity = "t_ct1";
  limit.high = 1;
  in.limits = {limit};
  compare_into(in);
  check_page(in);
  CHECK(verdict(in) == Outcome::not_observed);  // a limited quantity that nobody saw is no pass
}

TEST_CASE("hostile names stay text", "[report]") {
  const std::string evil = "<script>alert(1)</script>\"'&\x01\xff]]>";
  ReportInput in;
  in.campaign = in.specimen = evil;
  in.planned = 2;
  in.provenance = {evil, evil, evil, {{evil, evil, evil}}, evil, evil, evil, evil, evil,
                   evil, evil, evil, {{evil, evil}}};
  for (const RecordField& f : record_fields) in.test.*f.place = evil;
  in.test.instruments = {evil, evil + "; " + evil + "; 2001-01-01"};
  in.annotations = 1;
  in.annotated = evil;
  in.shots = {some_shot(1), some_shot(2)};
  in.shots[0].reason = evil;
  in.shots[0].record_hash = evil;
  in.shots[0].events->method = evil;
  in.shots[1].waveforms[0].channel = evil;
  in.extraction_parameters = evil + "=" + evil + "\nno equal sign\n=\n";
  compare_into(in);
  check_page(in);
}

TEST_CASE("shots without a record are counted, listed and explained", "[report]") {
  ReportInput in;
  in.campaign = "rough day";
  in.planned = 6;
  for (int i = 1; i <= 5; ++i) in.shots.push_back(some_shot(i));
  const Outcome outcomes[] = {Outcome::pass, Outcome::fail, Outcome::error, Outcome::timeout,
                              Outcome::aborted};
  for (std::size_t i = 0; i < 5; ++i) in.shots[i].outcome = outcomes[i];
  for (std::size_t i = 2; i < 5; ++i) {
    in.shots[i].events.reset();
    in.shots[i].waveforms.clear();
    in.shots[i].record_hash.clear();
    in.shots[i].reason = "rig lost in shot " + std::to_string(i + 1);
  }
  compare_into(in);
  check_page(in);
  const Counts c = count(in);
  CHECK(c.planned == 6);
  CHECK(c.done == 2);
  CHECK(c.passed == 1);
  CHECK(c.failed == 1);
  CHECK(c.errors == 3);
  CHECK(c.missing == 1);
  CHECK(verdict(in) == Outcome::fail);
  const std::string html = render_html(in), junit = render_junit(in);
  CHECK(contains(html, "rig lost in shot 4"));
  CHECK(contains(html, "2 of 5 shots measured"));
  // 5 shots + completeness; completeness is an error as well
  CHECK(contains(junit, "tests=\"6\" failures=\"1\" errors=\"4\" skipped=\"0\""));
  CHECK(contains(junit, "<error type=\"TIMEOUT\" message=\"rig lost in shot 4\"/>"));
  CHECK(contains(junit, "<failure type=\"FAIL\""));
}

TEST_CASE("the verdict follows the worst outcome", "[report]") {
  ReportInput in;
  in.planned = 2;
  in.shots = {some_shot(1), some_shot(2)};
  CHECK(verdict(in) == Outcome::pass);
  for (const Outcome o : {Outcome::not_judged, Outcome::not_observed, Outcome::aborted, Outcome::timeout,
                          Outcome::error, Outcome::fail}) {
    in.shots[1].outcome = o;
    CHECK(verdict(in) == o);
  }
  in.shots[1].outcome = Outcome::pass;
  in.planned = 3;
  CHECK(verdict(in) == Outcome::aborted);
}

TEST_CASE("a limit is a JUnit case of its own", "[report]") {
  ReportInput in;
  in.campaign = "limits";
  in.planned = 1;
  in.shots = {some_shot(1)};
  Limit tight;
  tight.quantity = "t_ct_bon";
  tight.high = 2e-3;
  Limit wide = tight;
  wide.high = 9e-3;
  in.limits = {tight, wide};
  compare_into(in);
  const std::string junit = render_junit(in);
  CHECK(contains(
      junit,
      "name=\"t_ct_bon \xE2\x89\xA4 2 ms\"><failure type=\"FAIL\" message=\"outside at 30.00 deg\"/>"));
  check_page(in);
}

TEST_CASE("measured, simulated and published stand side by side", "[report]") {
  ReportInput in;
  in.planned = 1;
  in.shots = {some_shot(1)};
  in.published = published_rows();
  in.simulated = {{radians(30), some_events(12.34e-3), {wave("pvdf_a", "N", 6000)}},
                  {radians(90), some_events(17.05e-3), {wave("pvdf_a", "N", 6000)}}};
  compare_into(in);
  check_page(in);
  const std::string html = render_html(in);
  CHECK(contains(html, "<td class=\"sim\">12.340"));  // to the digits of the measured U
  CHECK(contains(html, "<td class=\"pub\">11.86</td>"));
  CHECK(contains(html, "<td class=\"pub\">11.65</td>"));
  CHECK(contains(html, "<td class=\"pub\">16.82 \xE2\x80\xA0</td>"));  // excluded row at 90 deg
  CHECK(contains(html, "0 of 0 shots measured"));
}

TEST_CASE("curves of both are compared where both were recorded, with the largest difference", "[report]") {
  ReportInput in;
  in.planned = 1;
  in.shots = {some_shot(1)};
  Waveform late = wave("laser", "m", 6000);
  for (std::size_t i = 2200; i < 2300; ++i) late.values[i] += 0.5F;  // 12 .. 13 ms
  in.simulated = {{radians(30), some_events(12.34e-3), {late, wave("pvdf_a", "N", 6000)}}};
  in.simulated[0].spread = {{"laser", "", 0, 1e-4, std::vector<float>(300, 1e-4F)}};
  compare_into(in);
  check_page(in);
  CHECK(contains(render_html(in), "fill=\"#D55E00\" fill-opacity=\"0.22\"/>"));
  in.simulated[0].spread[0].values.assign(300, std::nanf(""));
  CHECK(!contains(render_html(in), "fill-opacity=\"0.22\""));
  const auto rows = curve_rows(angles_of(in).front());
  REQUIRE(rows.size() == 1);  // no current in either
  CHECK(rows[0].quantity == "x_m");
  CHECK(rows[0].repeats == 1);
  CHECK(rows[0].median.largest == Approx(0.5).epsilon(1e-5));
  CHECK(rows[0].median.at > 12e-3);
  CHECK(rows[0].median.at < 13e-3);
  const std::string html = render_html(in);
  CHECK(contains(html, "Simulated curve against measured"));
  CHECK(contains(html, "500.00"));  // mm
  in.simulated.front().waveforms.clear();
  CHECK(curve_rows(angles_of(in).front()).empty());
  CHECK_FALSE(contains(render_html(in), "Simulated curve against measured"));
}

TEST_CASE("core vibration: bands, refusal and pictures, whatever the numbers are", "[report]") {
  ReportInput in;
  VibrationView v;
  v.shot = 3;
  v.angle = radians(60);
  v.impact_ms = 14.2;
  v.film = "film A";
  v.films.push_back({"film A",
                     "coherence with aux over 20 closings",
                     {{2900, 3200}, {7e3, 7.2e3}},
                     3220,
                     -0.7,
                     -28.4,
                     true,
                     "refused",
                     "aux explains 91 %"});
  v.films.push_back(
      {"film B", "1 <mode> & more", {}, 1500, -INFINITY, -INFINITY, false, "low-pass 1.50 kHz", ""});
  for (const char* label : {"before switch-on", "at the impact", "less the fitted modes"})
    v.spectra.push_back({label, {0, 1e3, 2e3, 30e3}, {-80, -20, -40, NAN}});
  v.maps.push_back({"before / kHz", 4, 0.5, 400, 20, 60, std::vector<float>(1200, -30.0F)});
  v.maps.push_back({"after / kHz", 4, 0.5, 400, 20, 60, std::vector<float>(1200, -300.0F)});
  in.vibration = v;
  check_page(in);
  const std::string html = render_html(in);
  CHECK(contains(html, "Core vibration on the films"));
  CHECK(contains(html, ">refused<"));
  CHECK(contains(html,
                 "2.90\xE2\x80\x93"
                 "3.20"));
  CHECK(contains(html, "1 &lt;mode&gt; &amp; more"));
  in.vibration->spectra.clear();
  in.vibration->maps.clear();
  in.vibration->films.clear();
  check_page(in);
}

namespace {

ComparisonRow bounce_row(double deg, double value, double u, int repeats) {
  ComparisonRow r;
  r.quantity = "t_ct_bon";
  r.unit = "s";
  r.closing_angle = radians(deg);
  r.measured = {value, u};
  r.repeats = repeats;
  r.dof = repeats - 1;
  r.coverage = 2;
  return r;
}

}  // namespace

TEST_CASE("the best angle, how sure it is and what it is worth", "[report]") {
  Comparison c;
  CHECK(best_angle(c).angles == 0);
  c.rows = {bounce_row(0, 6e-3, 0.1e-3, 5), bounce_row(60, 5e-3, 0.1e-3, 5),
            bounce_row(120, 7e-3, 0.1e-3, 5)};
  const BestAngle b = best_angle(c);
  CHECK(b.angles == 3);
  CHECK(degrees(b.angle) == Approx(60));
  CHECK(degrees(b.runner_up) == Approx(0));
  CHECK(b.gain.value == Approx(1e-3));
  CHECK(b.gain.u == Approx(0.1e-3 * std::sqrt(4.0 / 9 + 2.0 / 9 - 0.0)));
  // t = 1 / (0.1 sqrt 2) = 7.07 and 14.1 with 4 degrees of freedom: 0.00105 and 0.00007 one-sided
  CHECK(b.confidence == Approx(1 - 0.00105 - 0.00007).margin(5e-5));
  c.rows[1].repeats = 1;  // the scatter of a single closing is not known
  CHECK(std::isnan(best_angle(c).confidence));
  c.rows = {bounce_row(0, 5.01e-3, 0.1e-3, 5), bounce_row(60, 5e-3, 0.1e-3, 5)};
  CHECK(best_angle(c).confidence == Approx(0.53).margin(0.02));
}

TEST_CASE("no number claims to be exact: a U below the digits shown says so", "[report]") {
  CHECK(with_uncertainty({0, 0}, 2, 1e3, 2) == "0");
  CHECK(with_uncertainty({0, 1e-12}, 2, 1e3, 2) == "0");
  CHECK(with_uncertainty({12e-3, 1e-12}, 2, 1e3, 2) == "12.0000 \xC2\xB1 <0.0001");
  CHECK(with_uncertainty({12e-3, 1.5e-6}, 2, 1e3, 2) == "12.0000 \xC2\xB1 0.0030");
}

TEST_CASE("a long campaign gives a bounded list of shots, what is not in order first", "[report]") {
  ReportInput in;
  const int shots = 20'000 / effort::every;
  in.planned = static_cast<std::size_t>(shots);
  for (int i = 1; i <= shots; ++i) {
    ReportShot s;
    s.index = i;
    s.outcome = i == shots - 1 ? Outcome::fail : Outcome::pass;
    s.reason = i == shots - 1 ? "the late one" : "";
    s.events = some_events(12e-3);
    s.conditions.closing_angle = radians(i % 36 * 10);
    in.shots.push_back(std::move(s));
  }
  compare_into(in);
  const std::string html = render_html(in);
  CHECK(html.size() < 10'000'000);
  CHECK(contains(html, "the late one"));
  CHECK(contains(html, "more are not listed here"));
}

TEST_CASE("a long campaign's page does not grow with its shots", "[report]") {
  const auto size = [](int shots) {
    ReportInput in;
    in.campaign = "long";
    in.angle_tolerance = radians(1);
    in.planned = static_cast<std::size_t>(shots);
    for (int i = 0; i < shots; ++i) {
      in.shots.push_back(some_shot(i));
      in.shots.back().waveforms.clear();
    }
    compare_into(in);
    const std::string html = render_html(in);
    CHECK(xml_error(html) == "");
    return html.size();
  };
  const std::size_t few = size(800), many = size(8000 / effort::every);
  CHECK(many < few + few / 100);
}
