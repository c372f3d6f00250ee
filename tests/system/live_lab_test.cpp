#include <catch2/catch.hpp>
#include <cstdlib>

#include "tests/system/browser.h"
#include "tests/system/live_bench.h"

/// The live bench in the hands of an engineer who has never seen it.

using namespace powbench::test;
using Catch::Contains;

namespace {

const std::string no_job = "fetch('/api/bench').then(r=>r.json()).then(b=>b.job===null)";

void write_plan(Tab& tab, const std::string& plan) {
  press(tab, "tab-parameters");
  tab.until("document.getElementById('text').value.length > 10");
  tab.value("(()=>{const t=document.getElementById('text');t.value=" + nlohmann::json(plan).dump() +
            ";t.dispatchEvent(new Event('input'))})()");
}

void picture(Tab& tab, const std::string& name) {
  if (const char* pictures = std::getenv("POWBENCH_PICTURES"))
    tab.picture(std::string(pictures) + "/" + name);
}

}  // namespace

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
                    seeking = "/^seeking the closing angle/.test(document.getElementById('job').textContent)";
  tab.value("document.getElementById('at').value = 'touch'");
  press(tab, "stop");
  tab.until("/gate off .*, coil current [0-9.]+ mA, at \\d\\d:\\d\\d:\\d\\d UTC/.test(" + alarm +
            ".textContent)");
  picture(tab, "live-stopped.png");
  press(tab, "fire");
  tab.until(seeking + " && " + alarm + ".hidden");
  press(tab, "stop");
  tab.until("/^STOP came after this was asked for/.test(" + refused + ".textContent)");
  write_plan(tab, "name = \"long\"\nangles_deg = [0, 90]\nrepeats = 100\n");
  press(tab, "run");
  tab.until("/ of 200/.test(document.getElementById('job').textContent) && " + alarm + ".hidden && " +
            refused + ".textContent === ''");
  press(tab, "stop");
  tab.until(no_job);
  for (const std::string& error : tab.errors()) CHECK_THAT(error, Contains("409"));  // the refusal itself
}
