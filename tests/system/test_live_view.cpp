#include <catch2/catch.hpp>
#include <cstdlib>

#include "tests/system/browser.h"
#include "tests/system/live_bench.h"
#include "tests/system/program.h"

/// What a person reads off the pages of the live bench: angles, verdicts, mistakes.

using namespace powbench::test;
using Catch::Contains;

namespace {

void run_plan(Tab& tab, const std::string& plan, int shots) {
  press(tab, "tab-parameters");
  tab.until("document.getElementById('text').value.length > 10");
  tab.value("(()=>{const t=document.getElementById('text');t.value=" + nlohmann::json(plan).dump() +
            ";t.dispatchEvent(new Event('input'))})()");
  tab.until(says(std::to_string(shots) + " shots in about"));
  press(tab, "run");
  tab.until("document.getElementById('test').hidden === false");
  tab.until(no_job);
}

}  // namespace

TEST_CASE("live page: the trend tells the angles apart by colour, marker and name", "[.slow]") {
  const Folder folder;
  LiveBench bench(folder);
  Browser browser(folder);
  Tab tab = browser.open(bench.url);
  tab.size(1200, 1400);
  run_plan(tab, "name = \"angles\"\nangles_deg = [0, 90]\nrepeats = 3\n", 6);
  const std::string items = "[...document.querySelectorAll('#trend-angles li')]";
  tab.until(items + ".map(i=>i.textContent.match(/^ (.+): 3 shots/)?.[1]).join() === '0\u00b0,90\u00b0'");
  CHECK(tab.value("new Set(" + items + ".map(i=>i.dataset.colour)).size") == 2);
  CHECK(tab.value("new Set(" + items + ".map(i=>i.dataset.marker)).size") == 2);
  const auto named = tab.value("document.getElementById('trend').getAttribute('aria-label')");
  CHECK_THAT(named.get<std::string>(), Contains("0\u00b0: 3 shots") && Contains("90\u00b0: 3 shots"));
  // in the picture there is as much ink of one angle as of the other
  const std::string ink =
      "(colour=>{const p=document.createElement('canvas').getContext('2d');p.fillStyle=colour;p.fillRect(0,0,"
      "1,1);const [r,g,b]=p.getImageData(0,0,1,1).data;let n=0;for(const c of "
      "document.querySelectorAll('#trend canvas')){const d=c.getContext('2d').getImageData(0,0,c.width,"
      "c.height).data;for(let i=0;i<d.length;i+=4)n+=d[i+3]===255&&Math.abs(d[i]-r)+Math.abs(d[i+1]-g)+"
      "Math.abs(d[i+2]-b)<6}return n})";
  const auto drawn = [&](int angle) {
    return tab
        .value(ink + "(getComputedStyle(document.documentElement).getPropertyValue('--angle-" +
               std::to_string(angle) + "').trim())")
        .get<int>();
  };
  CHECK(drawn(0) >= 3 * 20);  // a marker has more than 20 points
  CHECK(drawn(1) >= 3 * 20);
  tab.value("document.getElementById('trend').scrollIntoView()");
  picture(tab, "live-trend.png");
  tab.value(
      "(()=>{const s=document.getElementById('trend-at');s.value='90\u00b0';s.dispatchEvent(new "
      "Event('change'))})()");
  tab.until(items + ".length === 1");
  CHECK(drawn(0) == 0);
  CHECK(drawn(1) >= 3 * 20);  // an angle keeps its colour
  CHECK(tab.errors() == std::vector<std::string>());
}

TEST_CASE("live page: U of a mean is that of the report and of powbench compare, digit by digit", "[.slow]") {
  const Folder folder;
  LiveBench bench(folder);
  Browser browser(folder);
  Tab tab = browser.open(bench.url);
  for (const char* name : {"before", "after"})
    run_plan(tab, std::string("name = \"") + name + "\"\nangles_deg = [90]\nrepeats = 3\n", 3);
  press(tab, "tab-documents");
  tab.until("document.querySelectorAll('#first option').length === 2");
  tab.value(
      "document.getElementById('first').value='1';document.getElementById('second').value='2';"
      "document.querySelector('#compare button[type=submit]').click()");
  tab.until(row_of_each("#pair"));
  const std::string db = folder.file("lab.db");
  const std::string one = run(folder, {"compare", "--db", db, "--campaign", "1"}).out,
                    two = run(folder, {"compare", "1", "2", "--db", db}).out;
  REQUIRE(run(folder, {"report", "--db", db, "--campaign", "1", "-o", folder.file("report")}).status == 0);
  const std::string report = read_file(folder.file("report") + "/report.html");
  for (const char* quantity : {"t_ct1", "t_ct_bon", "t_xt1", "v_core", "F_peak", "i_peak"}) {
    CAPTURE(quantity);
    const auto shown =
        tab.value("[...document.querySelectorAll('#pair tr')].find(r=>r.cells[0].textContent==='" +
                  std::string(quantity) + "').cells[3].textContent")
            .get<std::string>();
    const auto at = shown.find(" \u00b1 ");
    REQUIRE(at != std::string::npos);
    const std::string value = shown.substr(0, at), U = shown.substr(at + 4);
    CHECK_THAT(report, Contains(">" + shown + "<"));
    CHECK_THAT(two, Contains(" " + value + " +- " + U + " "));
    const std::string row = one.substr(one.find("\n" + std::string(quantity) + " "));
    std::istringstream words(row);
    std::string word, angle, n, mean, expanded;
    words >> word >> angle >> n >> mean >> expanded;
    CHECK(mean == value);
    CHECK(expanded == U);
  }
  CHECK(tab.errors() == std::vector<std::string>());
}

TEST_CASE("live page: a list of keys that is older than the text says so", "[.slow]") {
  const Folder folder;
  LiveBench bench(folder);
  Browser browser(folder);
  Tab tab = browser.open(bench.url + "/#parameters");
  tab.size(1200, 1000);
  const auto write = [&](const std::string& text) {
    tab.until("document.getElementById('text').value.length > 10");
    tab.value("(()=>{const t=document.getElementById('text');t.value=" + nlohmann::json(text).dump() +
              ";t.dispatchEvent(new Event('input'))})()");
  };
  const std::string repeats = "document.getElementById('key  repeats')",
                    old = "document.getElementById('keys-old')", hint = ".getAttribute('place' + 'holder')",
                    grey = "document.getElementById('keys-table').classList.contains('old')";
  write("name = \"seven\"\nangles_deg = [0]\nrepeats = 7\n");
  tab.until(says("7 shots in about"));
  tab.until(repeats + ".value === '7'");
  CHECK(tab.value(old + ".hidden") == true);
  CHECK(tab.value(grey) == false);
  CHECK(tab.value(repeats + hint) ==
        "must be given");  // a default would be one that the program does not take
  CHECK(tab.value("document.getElementById('key  pause_s')" + hint) != "must be given");

  write("name = \"nine\"\nangles_deg = [0]\nrepeats = 9\nangels_deg = [1]\n");
  tab.until("!" + old + ".hidden");
  CHECK(tab.value(repeats + ".value") == "7");
  CHECK(tab.value(grey) == true);
  CHECK(tab.value(says(
            "Old values: the text has mistakes, and this list is of the last text without one.")) == true);
  // it is seen before the list, not behind it
  CHECK(tab.value(old + ".getBoundingClientRect().bottom <= "
                        "document.getElementById('keys-table').getBoundingClientRect().top") == true);
  picture(tab, "live-plan-mistake.png");
  // keys of another file are no old values of this one
  press(tab, "file-specimen");
  tab.until("document.getElementById('key bridges gap_mm')");
  CHECK(tab.value(old + ".hidden") == true);
  write("gap = \n");
  tab.until("!" + old + ".hidden");
  press(tab, "file-plan");
  tab.until("document.getElementById('text').value.includes('nine')");
  tab.until("document.getElementById('keys-old').textContent === 'No list yet: the text has mistakes.'");
  CHECK(tab.value("document.querySelectorAll('#keys input').length") == 0);

  write("name = \"nine\"\nangles_deg = [0]\nrepeats = 9\n");
  tab.until(repeats + "?.value === '9'");
  CHECK(tab.value(old + ".hidden") == true);
  CHECK(tab.value(grey) == false);
  CHECK(tab.errors() == std::vector<std::string>());
}

TEST_CASE("live page: no page is wider than a phone, with long names and a comparison too", "[.slow]") {
  const std::string name = "a_plan_whose_name_has_no_blank_and_is_longer_than_a_phone_is_wide";
  const Folder folder;
  folder.write("a_specimen_with_a_long_name.specimen.toml", "name = \"" + name + "_device\"\n");
  const std::string plan = folder.write(
      "a_plan_file_with_a_long_name_that_somebody_has_given.plan.toml",
      "specimen = \"a_specimen_with_a_long_name.specimen.toml\"\nangles_deg = [0]\nrepeats = 1\n");
  LiveBench bench(folder, "sim:", "0", {"--plan", plan});
  Browser browser(folder);
  Tab tab = browser.open(bench.url);
  tab.size(390, 800);
  for (const char* end : {"_one", "_two"})
    run_plan(tab,
             "name = \"" + name + end +
                 "\"\nspecimen = \"a_specimen_with_a_long_name.specimen.toml\"\nangles_deg = [0]\nrepeats = "
                 "1\n[limits.t_ct1]\nmax_ms = 2\n",
             1);
  const auto width = [&] {
    // of a phone the window itself grows with what is too wide for it
    return tab.value("Math.max(document.documentElement.scrollWidth, document.body.scrollWidth, innerWidth)")
        .get<int>();
  };
  tab.until(row_of_each("#quantities"));
  CHECK(width() <= 390);
  tab.value("document.getElementById('trend').scrollIntoView()");
  picture(tab, "live-phone-test.png");
  press(tab, "tab-parameters");
  tab.until("document.querySelectorAll('#keys tr').length > 10");
  CHECK(width() <= 390);
  picture(tab, "live-phone-plan.png");
  press(tab, "tab-documents");
  tab.until("document.querySelectorAll('#campaigns tr').length === 2");
  CHECK(width() <= 390);
  tab.value("document.querySelector('#campaigns button').click()");
  tab.until("document.querySelectorAll('#shots tr').length >= 1");
  tab.value("(()=>{document.getElementById('note-text').value='" + name + name +
            "';document.getElementById('annotate').requestSubmit()})()");
  tab.until("document.querySelectorAll('#notes li').length === 1");
  CHECK(width() <= 390);
  picture(tab, "live-phone-documents.png");
  tab.value("document.querySelector('#compare button[type=submit]').click()");
  tab.until(row_of_each("#pair"));
  CHECK(width() <= 390);
  tab.value("document.getElementById('compare').scrollIntoView()");
  picture(tab, "live-phone-compare.png");
  press(tab, "tab-rig");
  tab.until("document.querySelectorAll('#facts tr').length > 4");
  press(tab, "read-attributes");
  tab.until("document.querySelectorAll('#attributes tr').length > 60");
  CHECK(width() <= 390);
  picture(tab, "live-phone-rig.png");
  CHECK(tab.errors() == std::vector<std::string>());
}
