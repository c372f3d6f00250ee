#include <catch2/catch.hpp>

#include "tests/places.h"
#include "tests/system/browser.h"
#include "tests/system/live_bench.h"
#include "tests/system/program.h"
#include "tests/waiting.h"

/// The live bench as a person meets it: the program, a simulated rig, a browser.

using namespace powbench::test;
using Catch::Contains;

namespace {

const std::string long_plan =
    "name = \"long\"\nangles_deg = [0, 45, 90, 135]\nrepeats = 200\npause_s = 0.05\n";

}  // namespace

TEST_CASE("live page: a closing by keyboard alone, seen with its waveforms", "[.slow]") {
  const Folder folder;
  LiveBench bench(folder);
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
  tab.until(says("Shot 1 at 30\xC2\xB0"));
  tab.until("document.querySelectorAll('#panels canvas').length >= 12");
  tab.until(row_of_each("#quantities"));
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
  for (const char* page : {"parameters", "documents", "rig"}) {
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
  LiveBench bench(folder);
  Browser browser(folder);
  Tab tab = browser.open(bench.url);
  write_plan(tab, "angels_deg = [0]\nrepeats = 0\n");
  press(tab, "check");
  tab.until("document.querySelectorAll('#errors li').length >= 2");
  write_plan(tab, "name = \"three\"\nangles_deg = [0, 60, 120]\nrepeats = 1\n");
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
  press(tab, "tab-rig");
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

TEST_CASE("live page: parameters as text and key by key, stored where they came from", "[.slow]") {
  const Folder folder;
  const std::string specimen = folder.write("one.specimen.toml", "name = \"one\"  # the first\n"),
                    plan =
                        folder.write("lab.plan.toml",
                                     "# ours\nspecimen = \"one.specimen.toml\"\nangles_deg = [0, 90]  # few\n"
                                     "repeats = 2\n");
  LiveBench bench(folder, "sim:", "0", {"--plan", plan});
  Browser browser(folder);
  Tab tab = browser.open(bench.url + "/#parameters");
  tab.size(1200, 1000);
  tab.until(says("4 shots in about"));
  const auto change = [&](const std::string& key, const std::string& value) {
    const std::string id = "document.getElementById(" + nlohmann::json(key).dump() + ")";
    tab.until(id);
    tab.value("(()=>{const e=" + id + ";e.value=" + nlohmann::json(value).dump() +
              ";e.dispatchEvent(new Event('change'))})()");
  };
  change("key  repeats", "7");
  tab.until(says("14 shots in about"));
  picture(tab, "live-plan.png");
  change("key  repeats", "0");
  tab.until("document.querySelectorAll('#errors li').length === 1");
  tab.until("/1..10000/.test(document.getElementById('errors').textContent.replace(/ /g,''))");
  CHECK(tab.value("document.getElementById('run').disabled") == true);
  change("key  repeats", "3");
  tab.until(says("6 shots in about"));
  press(tab, "save");
  tab.until(says("lab.plan.toml saved"));
  CHECK(read_file(plan) ==
        "# ours\nspecimen = \"one.specimen.toml\"\nangles_deg = [0, 90]  # few\nrepeats = 3\n");

  press(tab, "file-specimen");
  tab.until("/the first/.test(document.getElementById('text').value)");
  change("key bridges gap_mm", "2.6");
  tab.until("/\\[bridges\\]\\ngap_mm = 2.6/.test(document.getElementById('text').value)");
  press(tab, "save");
  tab.until(says("one.specimen.toml saved"));
  CHECK(read_file(specimen) == "name = \"one\"  # the first\n\n[bridges]\ngap_mm = 2.6\n");
  press(tab, "file-rig");
  tab.until(says("no rig file was named"));
  CHECK(tab.value("document.getElementById('save').disabled") == true);
  CHECK(tab.errors().empty());
}

TEST_CASE("live page: closing at touch, pause, two campaigns, PDF, exports", "[.slow]") {
  const Folder folder;
  LiveBench bench(folder);
  Browser browser(folder);
  Tab tab = browser.open(bench.url);
  tab.size(1200, 1000);
  tab.until("document.getElementById('fire').disabled === false");
  tab.value("document.getElementById('at').value = 'touch'");
  press(tab, "fire");
  tab.until("/touched at (8[5-9]|9[0-4])\\./.test(document.getElementById('shot-reason').textContent)");
  for (const char* more : {"first", "second"}) {
    write_plan(tab,
               "name = \"" + std::string(more) + "\"\nangles_deg = [0, 90]\nrepeats = 2\npause_s = 0.3\n");
    tab.until(says("4 shots in about"));
    press(tab, "run");
    tab.until("document.getElementById('pause').hidden === false");
    press(tab, "pause");
    tab.until("fetch('/api/bench').then(r=>r.json()).then(b=>b.job&&b.job.doing==='paused')");
    tab.until("document.getElementById('pause').textContent === 'Continue'");
    press(tab, "pause");
    tab.until(no_job);
  }
  press(tab, "tab-documents");
  tab.until("document.querySelectorAll('#campaigns tr').length === 3");
  tab.value("document.querySelector('#compare button[type=submit]').click()");
  tab.until("/of " + std::to_string(2 * powbench::quantity_table.size()) +
            " comparisons differ/.test(document.getElementById('pair-title').textContent)");
  tab.until(
      "/4 shots of the second campaign hold the records of the first, bit for bit: simulated with one seed, "
      "so "
      "their agreement says nothing$/.test(document.getElementById('pair-title').textContent)");
  picture(tab, "live-compare.png");
  const auto find = [&](const std::string& id, const std::string& value) {
    tab.value("(()=>{const e=document.getElementById('" + id + "');e.value='" + value +
              "';e.dispatchEvent(new Event('input'))})()");
  };
  find("find-angle", "90");
  tab.until("document.querySelectorAll('#campaigns tr').length >= 2");
  find("find-angle", "45");
  tab.until("document.querySelectorAll('#campaigns tr').length === 0");
  find("find-angle", "");
  find("find-outcome", "FAIL");
  tab.until("document.querySelectorAll('#campaigns tr').length === 0");
  const auto got = [&](const std::string& path) {
    return tab.value(
        "fetch('" + path +
        "').then(async r=>[r.status, r.headers.get('content-disposition'), (await r.text()).slice(0, 40)])");
  };
  CHECK(got("/api/campaigns/2/report.pdf").at(2).get<std::string>().starts_with("%PDF-"));
  CHECK(
      got("/api/campaigns/2/shots.csv").at(2).get<std::string>().starts_with("# SIMULATED RIG, campaign 2"));
  CHECK(got("/api/campaigns/2/junit.xml").at(2).get<std::string>().starts_with("<?xml"));
  CHECK(got("/api/shots/1/waveforms.csv").at(2).get<std::string>().starts_with("# SIMULATED RIG"));
  CHECK(got("/api/shots/1/events.json").at(1) == "attachment; filename=\"shot-1.json\"");
  CHECK(tab.errors().empty());
}

TEST_CASE("live page: the raw channels with their trigger, the phase tracker, every attribute", "[.slow]") {
  const Folder folder;
  LiveBench bench(folder);
  Browser browser(folder);
  Tab tab = browser.open(bench.url + "/#rig");
  tab.size(1200, 1400);
  // the simulated mains stand still between shots: the tracker has seen none of it yet, and says so
  tab.until(
      "/not yet: the phase is not valid: the history is too "
      "short/.test(document.getElementById('guards').textContent)");
  tab.until("/50\\.0\\d\\d Hz|49\\.9\\d\\d Hz/.test(document.getElementById('tracker').textContent)");
  const std::string drawn = "Number(document.getElementById('scope').dataset.drawn || 0)";
  tab.value("document.getElementById('fire').click()");
  tab.until(drawn + " > 0");
  tab.until(says("Shot 1, SIMULATED RIG"));
  tab.until("/yes: nothing is in the way, and 3 u/.test(document.getElementById('guards').textContent)");
  CHECK(tab.value("/gate of the coil\\s*off/.test(document.getElementById('guards').textContent)") == true);
  CHECK(tab.value("document.querySelectorAll('#interlocks tr').length") == 22);
  const std::string ink =
      "(()=>{const c=document.getElementById('scope');const "
      "d=c.getContext('2d').getImageData(0,0,c.width,c.height).data;"
      "let n=0;for(let i=3;i<d.length;i+=4)n+=d[i]>0;return n})()";
  CHECK(tab.value(ink).get<int>() > 2000);
  // a trigger that this record does not meet is said, and one that it meets moves the picture
  tab.value(
      "(()=>{const t=document.getElementById('trigger');t.value='coil_current';t.dispatchEvent(new "
      "Event('change'));"
      "const l=document.getElementById('level');l.value='1e6';l.dispatchEvent(new Event('input'))})()");
  tab.until(says("the trigger was not met"));
  tab.value(
      "(()=>{const l=document.getElementById('level');l.value='0.5';l.dispatchEvent(new Event('input'))})()");
  tab.until("!/not met/.test(document.getElementById('scope-says').textContent)");
  picture(tab, "live-rig.png");
  press(tab, "read-attributes");
  tab.until("document.querySelectorAll('#attributes tr').length > 60");
  tab.until("/contactor-ctl\\/last_error/.test(document.getElementById('attributes').textContent)");
  CHECK(tab.errors().empty());
}

TEST_CASE("live page: axe-core finds nothing serious on any page", "[.slow]") {
  const std::string axe = read_file(powbench::test::page_tools() + "/axe-core/axe.min.js");
  INFO("axe-core is missing: ./dev test --slow fetches it");
  REQUIRE(axe.size() > 100'000);
  const Folder folder;
  LiveBench bench(folder);
  Browser browser(folder);
  Tab tab = browser.open(bench.url);
  tab.size(1200, 1000);
  tab.until("document.getElementById('fire').disabled === false");
  press(tab, "fire");
  tab.until("document.querySelectorAll('#panels canvas').length >= 12");
  tab.value("(()=>{" + axe + ";window.axe=window.axe||axe;})()");
  for (const bool dark : {false, true}) {
    tab.dark(dark);
    for (const char* page : {"test", "parameters", "documents", "rig"}) {
      CAPTURE(page, dark);
      press(tab, std::string("tab-") + page);
      if (page == std::string("parameters")) tab.until("document.querySelectorAll('#keys tr').length > 10");
      if (page == std::string("documents"))
        tab.until("document.querySelectorAll('#campaigns tr').length === 1");
      const auto found = tab.value(
          "axe.run({resultTypes:['violations']}).then(r=>r.violations.filter(v=>['serious','critical']."
          "includes(v.impact))"
          ".map(v=>v.id+': '+v.nodes.slice(0,3).map(n=>n.target.join(' ')).join(', ')))");
      CHECK(found.dump() == "[]");
    }
  }
}

TEST_CASE("live page: its scripts are checked by TypeScript's compiler", "[.slow]") {
  const Folder folder;
  const std::string compiler = powbench::test::page_tools() + "/typescript/lib/tsc.js";
  INFO("typescript is missing: ./dev test --slow fetches it");
  REQUIRE(!read_file(compiler).empty());
  const std::string command =
      "node " + compiler + " -p " + powbench::test::source_dir() + "/tests/page > " + folder.file("out");
  const int status = std::system(command.c_str());
  CHECK(read_file(folder.file("out")) == "");
  CHECK(status == 0);
}

TEST_CASE("live page: a shot outside limits is said loudly", "[.slow]") {
  const Folder folder;
  LiveBench bench(folder);
  Browser browser(folder);
  Tab tab = browser.open(bench.url);
  write_plan(tab, "name = \"tight\"\nangles_deg = [90]\nrepeats = 1\n[limits.t_ct1]\nmax_ms = 2\n");
  press(tab, "run");
  tab.until(says("Outside limits: 1 of 1 shots of tight"));
  tab.until("document.getElementById('shot-title').className === 'bad'");
  tab.until(no_job);
  press(tab, "stop");  // takes nothing back
  tab.until(says("coil off, confirmed by the rig"));
  CHECK(tab.value(says("Outside limits: 1 of 1 shots of tight")) == true);
}

TEST_CASE("live page: STOP in mid-plan from a second tab, and by Esc", "[.slow]") {
  const Folder folder;
  LiveBench bench(folder);
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
  auto bench = std::make_unique<LiveBench>(folder);
  const std::string url = bench->url, port = url.substr(url.rfind(':') + 1);
  Browser browser(folder);
  Tab tab = browser.open(url);
  write_plan(tab, long_plan);
  press(tab, "run");
  tab.until("/ of 800/.test(document.getElementById('job').textContent)");
  tab.go(url);
  tab.until("/: [1-9][0-9]* of 800/.test((document.getElementById('job')||{}).textContent)");  // stored
  bench.reset();  // killed, not asked
  tab.until(says("does not answer"));
  press(tab, "stop");
  tab.until(says("STOP FAILED"));
  LiveBench again(folder, "sim:", port);
  tab.until("document.getElementById('state').textContent === 'ready'");
  // what was stored is there
  CHECK(tab.value("fetch('/api/campaigns').then(r=>r.json()).then(l=>l.length)") == 1);
}

TEST_CASE("live page: the rig gone and back", "[.slow]") {
  const Folder folder, rig_folder;
  const std::string address = "127.0.0.77";
  auto rig = std::make_unique<Program>(
      rig_folder, std::vector<std::string>{"rig", "--listen", address, "--boot-seed", "4"});
  wait_until("the rig", [&] { return rig->err().find("stop with Ctrl-C") != std::string::npos; });
  LiveBench bench(folder, "ip:" + address);
  Browser browser(folder);
  Tab tab = browser.open(bench.url);
  tab.until("document.getElementById('state').textContent === 'ready'");
  rig.reset();
  tab.until("document.getElementById('state').textContent === 'no answer'");
  press(tab, "stop");
  tab.until(says("THE RIG DOES NOT ANSWER"));
  rig = std::make_unique<Program>(rig_folder,
                                  std::vector<std::string>{"rig", "--listen", address, "--boot-seed", "5"});
  tab.until("document.getElementById('state').textContent === 'ready'");
  tab.until("document.getElementById('fire').disabled === false");
  press(tab, "fire");
  tab.until(says("Shot "));
  tab.until("document.querySelectorAll('#panels canvas').length >= 12");
}
