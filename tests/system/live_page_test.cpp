#include <catch2/catch.hpp>

#include "tests/system/browser.h"
#include "tests/system/program.h"
#include "tests/waiting.h"

/// The live bench as a person meets it: the program, a simulated rig, a browser.

using namespace powbench::test;
using Catch::Contains;

namespace {

/// `powbench serve` on a free port.
struct Bench {
  explicit Bench(const Folder& f, const std::string& rig = "sim:", const std::string& port = "0")
      : program(f, {"serve", "--rig", rig, "--db", f.file("lab.db"), "--listen", "127.0.0.1:" + port}) {
    wait_until("the live bench", [&] {
      const std::string text = program.err();
      if (program.poll() != -1000) throw std::runtime_error("it ended: " + text);
      const auto at = text.find("http://"), end = text.find("/,", at);
      if (at == std::string::npos || end == std::string::npos) return false;
      url = text.substr(at, end - at);
      return true;
    });
  }
  Program program;
  std::string url;
};

const std::string text = "document.body.innerText";
const auto says = [](const std::string& words) {
  return text + ".includes(" + nlohmann::json(words).dump() + ")";
};
const std::string no_job = "fetch('/api/bench').then(r=>r.json()).then(b=>b.job===null)";

void press(Tab& tab, const std::string& id) {
  tab.until("document.getElementById('" + id + "')");
  tab.value("document.getElementById('" + id + "').click()");
}

void write_plan(Tab& tab, const std::string& plan) {
  press(tab, "tab-plan");
  tab.until("document.getElementById('text').value.length > 10");
  tab.value("document.getElementById('text').value = " + nlohmann::json(plan).dump());
}

/// A picture of the page where POWBENCH_PICTURES names a folder: those of docs/serve.md are made so.
void picture(Tab& tab, const std::string& name) {
  if (const char* pictures = std::getenv("POWBENCH_PICTURES"))
    tab.picture(std::string(pictures) + "/" + name);
}

const std::string long_plan =
    "name = \"long\"\nangles_deg = [0, 45, 90, 135]\nrepeats = 200\npause_s = 0.05\n";

}  // namespace

TEST_CASE("live page: a closing by keyboard alone, seen with its waveforms", "[.slow]") {
  const Folder folder;
  Bench bench(folder);
  Browser browser(folder);
  Tab tab = browser.open(bench.url);
  tab.size(1200, 1000);
  tab.until(says("SIMULATED RIG"));
  // the keyboard: to the angle, 9 0, Enter
  tab.until("document.getElementById('fire').disabled === false");
  for (int i = 0; i < 20 && tab.value("document.activeElement.id") != "angle"; ++i) tab.key("Tab");
  REQUIRE(tab.value("document.activeElement.id") == "angle");
  tab.value("document.activeElement.select()");
  tab.key("3");
  tab.key("0");
  tab.key("Enter");
  tab.until(says("Shot 1 at 30.0"));
  tab.until("document.querySelectorAll('#panels canvas').length >= 12");
  tab.until("document.querySelectorAll('#quantities tr').length === 9");
  tab.until("/measured/.test(document.querySelector('#panels .dygraph-legend').textContent)");
  tab.until("/simulated/.test(document.querySelector('#panels .dygraph-legend').textContent)");

  // zoom
  const auto width = [&] {
    return tab
        .value(
            "(()=>{const l=[...document.querySelectorAll('#panels .closer-panel.last "
            ".dygraph-axis-label-x')].map(e=>+e.textContent);return l[l.length-1]-l[0]})()")
        .get<double>();
  };
  tab.value("document.querySelector('#closer [data-do=whole]').click()");
  const double whole = width();
  tab.value("document.querySelector('#closer [data-do=bounce]').click()");
  CHECK(width() < 0.6 * whole);

  // every control has a name; nothing is wider than the window, on a desk and on a phone
  const std::string nameless =
      "[...document.querySelectorAll('button,input,select,textarea,[role=img]')].filter(e=>getComputedStyle("
      "e).display!=='none'&&!(e.textContent."
      "trim()||"
      "e.getAttribute('aria-label')||(e.labels&&e.labels.length))).map(e=>e.outerHTML)";
  CHECK(tab.value(nameless).dump() == "[]");
  picture(tab, "live-test.png");
  tab.size(390, 800);
  picture(tab, "live-phone.png");
  CHECK(tab.value("document.documentElement.scrollWidth <= window.innerWidth") == true);
  CHECK(tab.value("(()=>{const r=document.getElementById('stop').getBoundingClientRect();return "
                  "r.top>=0&&r.bottom<=innerHeight&&r.right<=innerWidth})()") == true);
  for (const char* page : {"plan", "documents", "debug"}) {
    press(tab, std::string("tab-") + page);
    CAPTURE(page);
    CHECK(tab.value("document.documentElement.scrollWidth <= window.innerWidth") == true);
    CHECK(tab.value("document.getElementById('stop').offsetParent !== null") == true);
  }
  CAPTURE(tab.errors());
  CHECK(tab.errors().empty());
  for (const std::string& address : tab.requests()) {
    CAPTURE(address);
    CHECK((address.starts_with(bench.url + "/") || address.starts_with("data:")));
  }
}

TEST_CASE("live page: three angles, documents, report, mistakes in a plan", "[.slow]") {
  const Folder folder;
  Bench bench(folder);
  Browser browser(folder);
  Tab tab = browser.open(bench.url);
  write_plan(tab, "angels_deg = [0]\nrepeats = 0\n");
  press(tab, "check");
  tab.until("document.querySelectorAll('#errors li').length >= 2");
  write_plan(tab, "name = \"three\"\nangles_deg = [0, 60, 120]\nrepeats = 1\n");
  press(tab, "check");
  tab.until(says("3 shots in about"));
  tab.size(1200, 1000);
  picture(tab, "live-plan.png");
  press(tab, "run");
  tab.until("document.getElementById('test').hidden === false");
  tab.until(says("Shot 3"));
  tab.until(no_job);
  press(tab, "tab-documents");
  tab.until("document.querySelectorAll('#campaigns tr').length === 1");
  tab.value("document.querySelector('#campaigns button').click()");
  tab.until("document.querySelectorAll('#shots tr').length === 6");
  picture(tab, "live-documents.png");
  press(tab, "tab-debug");
  picture(tab, "live-rig.png");
  press(tab, "tab-documents");
  tab.value(
      "document.getElementById('search').value='nobody';document.getElementById('search').dispatchEvent(new "
      "Event('input'))");
  tab.until("document.querySelectorAll('#campaigns tr').length === 0");
  CHECK(tab.errors().empty());
  const std::string report = bench.url + "/api/campaigns/1/report.html";
  Tab page = browser.open(report);
  page.until(
      "document.getElementById('closer-panels') && document.querySelectorAll('#closer-panels canvas').length "
      ">= 12");
  CHECK(page.errors().empty());
}

TEST_CASE("live page: a shot outside limits is said loudly", "[.slow]") {
  const Folder folder;
  Bench bench(folder);
  Browser browser(folder);
  Tab tab = browser.open(bench.url);
  write_plan(tab, "name = \"tight\"\nangles_deg = [90]\nrepeats = 1\n[limits.t_ct1]\nmax_ms = 2\n");
  press(tab, "run");
  tab.until("/Outside limits/.test(document.getElementById('alarm').textContent)");
  tab.until("document.getElementById('shot-title').className === 'bad'");
}

TEST_CASE("live page: STOP in mid-plan from a second tab, and by Esc", "[.slow]") {
  const Folder folder;
  Bench bench(folder);
  Browser browser(folder);
  Tab first = browser.open(bench.url), second = browser.open(bench.url);
  second.until(says("SIMULATED RIG"));
  for (const bool by_key : {false, true}) {
    write_plan(first, long_plan);
    press(first, "run");
    first.until("/ of 800/.test(document.getElementById('job').textContent)");
    first.until("fetch('/api/bench').then(r=>r.json()).then(b=>b.job&&b.job.done>2)");
    if (by_key)
      second.key("Escape");
    else
      press(second, "stop");
    second.until(says("coil off, confirmed by the rig"));
    first.until(says("coil off, confirmed by the rig"));  // the other tab hears of it
    first.until(no_job);
    const auto shots =
        first.value("fetch('/api/campaigns').then(r=>r.json()).then(l=>l[0].shots)").get<int>();
    CHECK(shots >= 3);
    CHECK(shots < 800);
  }
}

TEST_CASE("live page: reload in mid-plan, the program killed and back", "[.slow]") {
  const Folder folder;
  auto bench = std::make_unique<Bench>(folder);
  const std::string url = bench->url, port = url.substr(url.rfind(':') + 1);
  Browser browser(folder);
  Tab tab = browser.open(url);
  write_plan(tab, long_plan);
  press(tab, "run");
  tab.until("/ of 800/.test(document.getElementById('job').textContent)");
  tab.go(url);
  tab.until("/ of 800/.test((document.getElementById('job')||{}).textContent)");
  bench.reset();  // killed, not asked
  tab.until(says("does not answer"));
  press(tab, "stop");
  tab.until(says("STOP FAILED"));
  Bench again(folder, "sim:", port);
  tab.until("document.getElementById('state').textContent === 'idle'");
  // what was stored is there
  CHECK(tab.value("fetch('/api/campaigns').then(r=>r.json()).then(l=>l.length)") == 1);
}

TEST_CASE("live page: the rig gone and back", "[.slow]") {
  const Folder folder, rig_folder;
  const std::string address = "127.0.0.77";
  auto rig = std::make_unique<Program>(
      rig_folder, std::vector<std::string>{"rig", "--listen", address, "--boot-seed", "4"});
  wait_until("the rig", [&] { return rig->err().find("stop with Ctrl-C") != std::string::npos; });
  Bench bench(folder, "ip:" + address);
  Browser browser(folder);
  Tab tab = browser.open(bench.url);
  tab.until("document.getElementById('state').textContent === 'idle'");
  rig.reset();
  tab.until("document.getElementById('state').textContent === 'no answer'");
  press(tab, "stop");
  tab.until(says("THE RIG DOES NOT ANSWER"));
  rig = std::make_unique<Program>(rig_folder,
                                  std::vector<std::string>{"rig", "--listen", address, "--boot-seed", "5"});
  tab.until("document.getElementById('state').textContent === 'idle'");
  tab.until("document.getElementById('fire').disabled === false");
  press(tab, "fire");
  tab.until(says("Shot "));
  tab.until("document.querySelectorAll('#panels canvas').length >= 12");
}
