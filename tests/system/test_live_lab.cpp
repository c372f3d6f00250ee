#include <catch2/catch.hpp>
#include <cstdlib>

#include "tests/system/browser.h"
#include "tests/system/live_bench.h"

/// The live bench in the hands of an engineer who has never seen it.

using namespace powbench::test;
using Catch::Contains;

TEST_CASE("live page: Esc stops while a list of choices is open", "[.slow]") {
  const Folder folder;
  LiveBench bench(folder);
  Browser browser(folder);
  Tab tab = browser.open(bench.url);
  tab.size(1200, 1000);
  tab.until("!document.getElementById('fire').disabled");
  // a native drop-down takes Esc for itself: none can be opened, on any page
  CHECK(tab.value("document.querySelectorAll('select').length").get<int>() >= 8);
  for (const char* page : {"test", "parameters", "documents", "rig"}) {
    press(tab, std::string("tab-") + page);
    CHECK(
        tab.value("[...document.querySelectorAll('select')].filter(e=>e.offsetParent).map(e=>e.id)").dump() ==
        "[]");
  }
  // nor a list of what was typed before
  CHECK(
      tab.value(
             "[...document.querySelectorAll('input:not([type=checkbox]):not([type=radio]):not([type=range]),"
             "textarea')].filter(e=>e.autocomplete!=='off').map(e=>e.id)")
          .dump() == "[]");
  write_plan(tab, "name = \"long\"\nangles_deg = [0, 90]\nrepeats = 200\npause_s = 0.05\n");
  press(tab, "run");
  tab.until("document.getElementById('test').hidden === false");
  tab.until("fetch('/api/bench').then(r=>r.json()).then(b=>b.job&&b.job.done>1)");
  tab.value("document.querySelector('#fire-form .choice').focus()");
  tab.key("ArrowDown");
  tab.until("document.getElementById('choices').offsetParent !== null");
  picture(tab, "live-choices.png");
  tab.key("Escape");
  tab.until(says("coil off, confirmed by the rig"));
  tab.until(no_job);
  CHECK(tab.value("document.getElementById('choices').offsetParent === null") == true);
  CHECK(tab.value("fetch('/api/campaigns').then(r=>r.json()).then(l=>l[0].shots<400)") == true);
  CHECK(tab.value("document.getElementById('at').value") == "closing");
  // by keyboard and by mouse it chooses
  tab.key("ArrowDown");
  tab.key("ArrowDown");
  tab.key("Enter");
  CHECK(tab.value("document.getElementById('at').value") == "touch");
  CHECK(tab.value("document.querySelector('#fire-form .choice').textContent") == "Contacts touch at");
  tab.value(
      "document.querySelector('#fire-form .choice').click();document.querySelector('#choices li').click()");
  CHECK(tab.value("document.getElementById('at').value") == "closing");
  tab.value("document.getElementById('at').value = 'touch'");
  CHECK(tab.value("document.querySelector('#fire-form .choice').textContent") == "Contacts touch at");
  CHECK(tab.errors() == std::vector<std::string>());
}

TEST_CASE("live page: what was asked once before a STOP is not fired by a second press after it", "[.slow]") {
  const Folder folder;
  LiveBench bench(folder);
  Browser browser(folder);
  Tab tab = browser.open(bench.url);
  tab.until("!document.getElementById('fire').disabled");
  write_plan(tab, "name = \"rest\"\nangles_deg = [0, 90]\nrepeats = 200\n");
  press(tab, "run");
  tab.until("fetch('/api/bench').then(r=>r.json()).then(b=>b.job&&b.job.done>1)");
  tab.key("Escape");
  tab.until(no_job);
  press(tab, "tab-documents");
  const std::string rest =
      "[...document.querySelectorAll('#campaigns button')].find(b=>b.textContent.startsWith('Fire the "
      "rest'))";
  tab.until("!!" + rest);
  // the news of a STOP takes back what was asked before it came, also after the key: then it is asked again
  const std::string ask = "(" + rest + ".textContent === 'Fire the rest' && " + rest + ".click(), false)";
  tab.until("(" + rest + ".textContent === 'Fire the rest of campaign 1 now') || " + ask);
  tab.key("Escape");
  CHECK(tab.value(rest + ".textContent") == "Fire the rest");
  CHECK(tab.value(says("Nothing was fired: the STOP came between the two presses.")) == true);
  tab.value(rest + ".click()");
  CHECK(tab.value(no_job) == true);
  tab.until(says("Nothing was fired: the button must be pressed twice within 6 s.") + " || " + ask);
  CHECK(tab.value(no_job) == true);
  CHECK(tab.errors() == std::vector<std::string>());
}

TEST_CASE("live page: where Esc is not heard, the button says so", "[.slow]") {
  const Folder folder;
  LiveBench bench(folder);
  Browser browser(folder);
  Tab tab = browser.open(bench.url);
  const std::string key = "document.getElementById('stop-key').textContent";
  tab.until(key + " === (document.hasFocus() ? 'Esc' : 'Esc: click the page first')");
  tab.value("(()=>{document.hasFocus=()=>false;window.dispatchEvent(new Event('blur'))})()");
  CHECK(tab.value(key) == "Esc: click the page first");
  tab.value("(()=>{document.hasFocus=()=>true;window.dispatchEvent(new Event('focus'))})()");
  CHECK(tab.value(key) == "Esc");
}

TEST_CASE("live page: what was said of an older request goes with the next one", "[.slow]") {
  const Folder folder;
  LiveBench bench(folder);
  Browser browser(folder);
  Tab tab = browser.open(bench.url);
  tab.size(1200, 1000);
  tab.until("!document.getElementById('fire').disabled");
  const std::string alarm = "document.getElementById('alarm')",
                    refused = "document.getElementById('refused')",
                    seeking =
                        "/^seeking the angle for the coil/.test(document.getElementById('job').textContent)";
  tab.value("document.getElementById('at').value = 'touch'");
  press(tab, "stop");
  tab.until("/gate off, coil current [0-9.]+ mA, at \\d\\d:\\d\\d:\\d\\d UTC/.test(" + alarm +
            ".textContent)");
  picture(tab, "live-stopped.png");
  press(tab, "fire");
  tab.until(seeking + " && " + alarm + ".hidden");
  press(tab, "stop");
  tab.until("/^Not fired: STOP came after this was asked for/.test(" + refused + ".textContent)");
  write_plan(tab, "name = \"long\"\nangles_deg = [0, 90]\nrepeats = 100\n");
  press(tab, "run");
  tab.until("/ of 200/.test(document.getElementById('job').textContent) && " + alarm + ".hidden && " +
            refused + ".textContent === ''");
  press(tab, "stop");
  tab.until(no_job);
  for (const std::string& error : tab.errors()) CHECK_THAT(error, Contains("409"));  // the refusal itself
}

TEST_CASE(
    "live page: the answer to a STOP that comes behind the next closing does not say that the coil is off",
    "[.slow]") {
  const Folder folder;
  LiveBench bench(folder);
  Browser browser(folder);
  Tab tab = browser.open(bench.url);
  tab.until("!document.getElementById('fire').disabled");
  const std::string hidden = "document.getElementById('alarm').hidden";
  tab.value(
      "(()=>{const send=window.fetch;window.answered=0;window.fetch=(path,options)=>path!=='/api/stop'?"
      "send(path,options):send(path,options).then(r=>new Promise(go=>setTimeout(()=>{go(r);"
      "setTimeout(()=>{++window.answered},50)},2500)))})()");
  press(tab, "stop");
  tab.until(says("coil off, confirmed by the rig"));  // by the stream of states
  press(tab, "fire");
  tab.until("/^Shot 1 /.test(document.getElementById('shot-title').textContent) && " + hidden);
  tab.until("window.answered === 1");
  CHECK(tab.value(hidden) == true);
  // two in one second have one text; the second is answered all the same
  press(tab, "stop");
  press(tab, "stop");
  tab.until("window.answered === 3");
  CHECK(tab.value(says("coil off, confirmed by the rig")) == true);
  CHECK(tab.errors() == std::vector<std::string>());
}

TEST_CASE("live page: openings are counted, and two simulated values have two names", "[.slow]") {
  const Folder folder;
  LiveBench bench(folder);
  Browser browser(folder);
  Tab tab = browser.open(bench.url);
  tab.size(1200, 1500);
  write_plan(tab, "name = \"two\"\nangles_deg = [90]\nrepeats = 2\n");
  tab.until(says("2 shots in about"));
  press(tab, "run");
  tab.until("document.getElementById('test').hidden === false");
  tab.until(no_job);
  const std::string of = "document.getElementById('simulated-of').textContent",
                    row =
                        "[...document.querySelectorAll('#quantities tr')].find(r=>r.cells[0].textContent===";
  tab.until("/^Shot 2/.test(document.getElementById('shot-title').textContent) && /for this closing/.test(" +
            of + ")");
  CHECK_THAT(tab.value(of).get<std::string>(),
             Contains("under the mean conditions of 2 measured closings") && Contains(" V and "));
  // as many openings as the events have between first and last touch
  const auto contacts =
      tab.value(
             "fetch('/api/shots/2/"
             "events.json').then(r=>r.json()).then(e=>e.events.channels.contact_a.contacts.length)")
          .get<int>();
  REQUIRE(contacts > 1);
  const std::string counted = std::to_string(contacts - 1) + (contacts == 2 ? " opening" : " openings");
  CHECK_THAT(tab.value("document.getElementById('shot-title').textContent").get<std::string>(),
             Contains(" ms, " + counted));
  CHECK_THAT(tab.value(row + "'t_ct_bon').cells[1].textContent").get<std::string>(),
             Contains("; " + counted));
  tab.value("document.querySelector('#openings summary').click()");
  CHECK(
      tab.value(
          "[...document.querySelectorAll('#openings-list tr')].filter(r=>r.cells[1].textContent!=='\u2013')."
          "length") == contacts - 1);
  // a bounce time of 0 within a U that is more than 0 has no scale to agree on
  CHECK(tab.value(
            "[...document.querySelectorAll('#quantities tr')].filter(r=>/^0(\\.0*)? \u00b1/.test(r.cells[2]."
            "textContent)&&/^0/.test(r.cells[3].textContent)).every(r=>r.cells[6].textContent==='not "
            "resolved')") == true);
  tab.value("document.getElementById('quantities').scrollIntoView()");
  picture(tab, "live-quantities.png");
  press(tab, "tab-documents");
  tab.until("document.querySelectorAll('#campaigns tr').length === 1");
  tab.value("document.querySelector('#campaigns button').click()");
  tab.until(says("under the mean conditions of 2 measured closings"));
  const std::string report = tab.value("fetch('/api/campaigns/1/report.html').then(r=>r.text())");
  CHECK_THAT(report,
             Contains("one simulation for the angle, under the mean conditions of 2 measured closings"));
  CHECK(tab.errors() == std::vector<std::string>());
}

TEST_CASE("live page: voltage and hold time stand beside the button, and a mistake stays where it was typed",
          "[.slow]") {
  const Folder folder;
  LiveBench bench(folder);
  Browser browser(folder);
  Tab tab = browser.open(bench.url);
  tab.size(1200, 1000);
  const std::string hold = "document.getElementById('hold')",
                    unusual = "document.getElementById('unusual').textContent";
  tab.until("!document.getElementById('fire').disabled && " + hold + ".value === '100'");
  CHECK(tab.value(unusual) == "");
  write_plan(tab, "name = \"long hold\"\nangles_deg = [0]\nrepeats = 1\nhold_time_ms = 600\n");
  press(tab, "run");
  tab.until(hold + ".value === '600' && " + unusual + " === 'not the usual 100 ms'");
  tab.until("document.getElementById('test').hidden === false && !document.getElementById('fire').disabled");
  picture(tab, "live-unusual.png");
  const auto type = [&](const char* text) {
    tab.value(hold + ".focus();" + hold + ".select()");
    for (const char* c = text; *c != '\0'; ++c) tab.key(std::string(1, *c));
    tab.key("Enter");
  };
  type("20000");
  tab.until("/hold_time_ms.*1..10000/.test(document.getElementById('refused').textContent)");
  CHECK(tab.value(hold + ".value") == "20000");
  CHECK(tab.value(hold + ".getAttribute('aria-invalid')") == "true");
  CHECK(tab.value("fetch('/api/bench').then(r=>r.json()).then(b=>b.newest_shot)") == 1);
  CHECK(tab.value(unusual) == "not the usual 100 ms");  // while it is typed
  type("80");
  tab.until("fetch('/api/bench').then(r=>r.json()).then(b=>b.plan.hold_time_ms===80)");
  CHECK(tab.value("fetch('/api/bench').then(r=>r.json()).then(b=>b.newest_shot)") ==
        1);  // Enter took the value, no more
  press(tab, "fire");
  tab.until("fetch('/api/bench').then(r=>r.json()).then(b=>b.job===null&&b.newest_shot>1)");
  CHECK(tab.value(
            "fetch('/api/campaigns/2/shots').then(r=>r.json()).then(c=>fetch('/api/shots/'+c.shots[0].id))."
            "then(r=>r.json()).then(s=>Math.round(1e3*s.hold_time_s))") == 80);
}

TEST_CASE("live page: a mistake is at its field and at its line, and a template asks before it replaces",
          "[.slow]") {
  const Folder folder;
  LiveBench bench(folder);
  Browser browser(folder);
  Tab tab = browser.open(bench.url);
  tab.size(1200, 1000);
  const std::string mine = "# mine\nname = \"mine\"\nangles_deg = [0]\nrepeats = 2\n";
  write_plan(tab, mine);
  tab.until(says("2 shots in about"));
  const std::string angles = "document.getElementById('key  angles_deg')",
                    text = "document.getElementById('text')";
  const auto enter = [&](const char* value) {
    tab.until(angles);
    tab.value("(()=>{const e=" + angles + ";e.value='" + value +
              "';e.dispatchEvent(new Event('change'))})()");
  };
  enter("0, 45, 90");
  tab.until(says("6 shots in about"));
  enter("0, 45, 500");
  tab.until("document.querySelectorAll('#errors button').length === 1");
  tab.until(angles + ".value === '[0, 45, 500]' && " + angles + ".getAttribute('aria-invalid') === 'true'");
  tab.until("/^line 3: .*out of range/.test(" + angles + ".nextSibling.textContent)");
  picture(tab, "live-mistake.png");
  tab.value("document.querySelector('#errors button').click()");
  CHECK(tab.value(text + ".value.slice(" + text + ".selectionStart," + text + ".selectionEnd)") ==
        "angles_deg = [0, 45, 500]");
  enter("0, 45");
  tab.until(says("4 shots in about"));
  press(tab, "template");
  CHECK_THAT(tab.value(text + ".value").get<std::string>(), Contains("# mine"));
  CHECK(tab.value("document.getElementById('template').textContent") == "Replace my text by the template");
  press(tab, "template");
  CHECK_THAT(tab.value(text + ".value").get<std::string>(), !Contains("# mine"));
  CHECK(tab.value("document.getElementById('template').textContent") == "Start from a template");
  CHECK(tab.errors() == std::vector<std::string>());
}

TEST_CASE("live page: Back goes to what was open before, and filters come back empty", "[.slow]") {
  const Folder folder;
  LiveBench bench(folder);
  Browser browser(folder);
  Tab tab = browser.open(bench.url);
  tab.size(1200, 1400);
  tab.until("!document.getElementById('fire').disabled");
  tab.value("document.getElementById('at').value = 'touch';document.getElementById('angle').value = '60'");
  press(tab, "fire");
  // what was asked for, and where the coil was on
  tab.until(
      "/^Shot 1, touch asked 60.0\u00b0, coil on at \\d+(\\.\\d+)?\u00b0: touch /.test(document."
      "getElementById('shot-title').textContent)");
  tab.until(no_job);
  // one point of a trend stands in the middle, not on the axis
  tab.until("document.querySelectorAll('#trend canvas').length > 0");
  tab.value("document.getElementById('trend').scrollIntoView()");
  picture(tab, "live-trend-one.png");
  CHECK(tab.value("[...document.querySelectorAll('#trend "
                  ".dygraph-axis-label-x')].map(e=>e.textContent).includes('1')") == true);
  press(tab, "tab-documents");
  tab.until("document.querySelectorAll('#campaigns button').length >= 1");
  tab.value("document.querySelector('#campaigns button').click()");
  tab.until("location.hash === '#documents/1' && document.querySelectorAll('#shots tr').length >= 1");
  press(tab, "tab-rig");
  tab.until("location.hash === '#rig'");
  tab.value("void setTimeout(() => history.back())");
  tab.until("location.hash === '#documents/1' && !document.getElementById('campaign').hidden");
  tab.value("void setTimeout(() => history.back())");
  tab.until(
      "location.hash === '#documents' && document.getElementById('campaign').hidden && "
      "!document.getElementById('documents').hidden");
  tab.value("void setTimeout(() => history.back())");
  tab.until("location.hash === '#test' && !document.getElementById('test').hidden");
  tab.value("history.go(2)");
  tab.until("location.hash === '#documents/1' && !document.getElementById('campaign').hidden");
  tab.value(
      "(()=>{const e=document.getElementById('find-angle');e.value='1';e.dispatchEvent(new "
      "Event('input'))})()");
  tab.until("document.getElementById('found').textContent === 'no campaign matches, of 1'");
  // away and back: the campaign is there again, the filter is not
  tab.go("data:text/html,elsewhere");
  tab.value("void setTimeout(() => history.back())");
  tab.until(
      "document.getElementById('campaign') && !document.getElementById('campaign').hidden && "
      "document.querySelectorAll('#shots tr').length >= 1");
  CHECK(tab.value("document.getElementById('find-angle').value") == "");
  // a shot that was opened from the list stands in the address, outlives a reload, and Back leads to the list
  const std::string first = "document.querySelector('#shots button')";
  const auto id = tab.value(first + ".textContent").get<std::string>();
  const std::string there = "location.hash === '#test/" + id + "' && /^Shot " + id +
                            "\\b/.test(document.getElementById('shot-title').textContent) && "
                            "document.getElementById('shot').getBoundingClientRect().top < 300 && "
                            "document.getElementById('shot').getBoundingClientRect().top > "
                            "document.querySelector('header').getBoundingClientRect().bottom";
  tab.value(first + ".click()");
  tab.until(there);
  tab.value("void setTimeout(() => location.reload())");
  tab.until(there);
  tab.value("void setTimeout(() => history.back())");
  tab.until("location.hash === '#documents/1' && !document.getElementById('campaign').hidden");
  CHECK(tab.errors() == std::vector<std::string>());
}
