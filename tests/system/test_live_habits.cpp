#include <catch2/catch.hpp>

#include "tests/system/browser.h"
#include "tests/system/live_bench.h"

/// The live bench under the habits of people: a decimal comma, a narrow phone, a plan that was ended too early.

using namespace powbench::test;

TEST_CASE("live page: an angle with a decimal comma is that angle, and no other is fired", "[.slow]") {
  const Folder folder;
  LiveBench bench(folder);
  Browser browser(folder);
  Tab tab = browser.open(bench.url);
  tab.until("document.getElementById('fire').disabled === false");
  const auto type = [&](const std::string& text) {
    tab.value("(()=>{const a=document.getElementById('angle');a.focus();a.select()})()");
    for (const char c : text) tab.key(std::string(1, c));
    tab.key("Enter");
  };
  type("90,5,1");
  tab.until(says("Not fired: \"90,5,1\" is no angle"));
  type("905");
  tab.until(says("Not fired: \"905\" is no angle"));
  CHECK(tab.value("fetch('/api/bench').then(r=>r.json()).then(b=>b.newest_shot)").is_null());
  type("90,5");
  tab.until(says("Shot 1 at 90.5\xC2\xB0"));
  CHECK(tab.errors() == std::vector<std::string>());
}

TEST_CASE("live page: a fault says why and how it ends, and its button ends it", "[.slow]") {
  const Folder folder;
  LiveBench bench(folder);
  Browser browser(folder);
  Tab tab = browser.open(bench.url);
  const auto volts = [&](const char* v) {
    tab.until("document.getElementById('volts').value !== ''");
    tab.value("(()=>{const a=document.getElementById('volts');a.focus();a.value='" + std::string(v) +
              "';a.dispatchEvent(new Event('change'))})()");
  };
  tab.until("document.getElementById('fire').disabled === false");
  volts("20");
  press(tab, "fire");
  tab.until("document.getElementById('fault').hidden === false");
  CHECK(tab.value(says("FAULT 1: mains lost: check the supply, then acknowledge the fault")) == true);
  CHECK(tab.value(says("The coil is off.") + " && " +
                  says("not the usual 230 V: the rig takes so low a mains")) == true);
  tab.until(says("Shot 1 at 90\xC2\xB0: ERROR, nothing was recorded"));
  tab.until("document.getElementById('state').className === 'state fault'");  // once the job is over
  CHECK(tab.value("document.getElementById('fire').disabled") == true);
  picture(tab, "live-fault.png");
  volts("230");
  tab.key("Escape");  // a stop leaves it to be read
  tab.until(says("coil off, confirmed by the rig"));
  CHECK(tab.value("document.getElementById('fault').hidden") == false);
  press(tab, "acknowledge");
  tab.until("document.getElementById('fault').hidden === true");
  press(tab, "fire");
  tab.until(says("Shot 2 at 90\xC2\xB0: touch"));
  tab.until(no_job);
  CHECK(tab.value("fetch('/api/bench').then(r=>r.json()).then(b=>b.status.state)") == "captured");
  CHECK(tab.errors() == std::vector<std::string>());
}

TEST_CASE("live page: what the rig confirmed is not shown once the program is gone", "[.slow]") {
  const Folder folder;
  auto bench = std::make_unique<LiveBench>(folder);
  Browser browser(folder);
  Tab tab = browser.open(bench->url);
  tab.until("document.getElementById('fire').disabled === false");
  press(tab, "stop");
  tab.until(says("coil off, confirmed by the rig"));
  bench.reset();
  tab.until(says("does not answer"));
  CHECK(tab.value("document.getElementById('alarm').hidden") == true);
  CHECK(tab.value("document.getElementById('fire').disabled") == true);
  press(tab, "stop");
  tab.until(says("STOP FAILED"));
}

TEST_CASE(
    "live page: the program gone in mid-plan is an alarm, and nothing of the rig is shown as if it were "
    "known",
    "[.slow]") {
  const Folder folder;
  auto bench = std::make_unique<LiveBench>(folder);
  Browser browser(folder);
  Tab tab = browser.open(bench->url);
  tab.until("document.getElementById('fire').disabled === false");
  press(tab, "tab-rig");  // the first visit
  tab.until("document.querySelectorAll('#interlocks tr').length === 22");
  const std::string guards = "document.getElementById('guards').textContent";
  tab.until("/gate of the coil\\s*off/.test(" + guards + ")");
  write_plan(tab, "angles_deg = [0, 90]\nrepeats = 100\npause_s = 0.5\n");
  press(tab, "run");
  tab.until("/cooling, next shot in 1 s/.test(document.getElementById('job').textContent)");
  bench->program.send(SIGKILL);
  tab.until(says("does not answer since") + " && " + says("Use the emergency switch of the rig."));
  press(tab, "tab-rig");
  tab.until("/not known.*does not answer/.test(" + guards + ")");
  CHECK(tab.value("/gate of the coil|would it fire/.test(" + guards + ")") == false);
  CHECK(tab.value("document.getElementById('pause').disabled") == true);
  const std::string port = bench->url.substr(bench->url.rfind(':') + 1);
  bench.reset();
  LiveBench again(folder, "sim:", port);
  tab.until(says("The bench answers again") + " && " + says("its coil is off"));
  tab.until("/gate of the coil\\s*off/.test(" + guards + ")");
}

TEST_CASE("live page: STOP stands still, whatever is said beside it", "[.slow]") {
  const Folder folder;
  LiveBench bench(folder);
  Browser browser(folder);
  Tab tab = browser.open(bench.url);
  const std::string place =
      "(()=>{const b=document.getElementById('stop').getBoundingClientRect();return "
      "[b.left,b.top].join()})()";
  for (const int width : {390, 780, 1000, 1400}) {
    CAPTURE(width);
    tab.size(width, 800);
    tab.until("document.getElementById('fire').disabled === false");
    const auto idle = tab.value(place);
    write_plan(
        tab,
        "name = \"a plan whose name takes some room in the line\"\nangles_deg = [0, 90]\nrepeats = 100\n"
        "pause_s = 0.5\n");
    press(tab, "run");
    tab.until("/cooling/.test(document.getElementById('job').textContent)");
    CHECK(tab.value(place) == idle);
    press(tab, "pause");
    tab.until("document.getElementById('state').textContent === 'paused'");
    CHECK(tab.value(place) == idle);
    picture(tab, "live-header-" + std::to_string(width) + ".png");
    press(tab, "stop");
    tab.until(says("coil off, confirmed by the rig"));
    CHECK(tab.value(place) == idle);
    tab.until(no_job);
  }
}

TEST_CASE("live page: what differs from the simulation by more than U is marked", "[.slow]") {
  const Folder folder;
  folder.write("other.specimen.toml", "[bridges]\ngap_mm = 2.2\n");
  const std::string rig = folder.write("other.rig.toml", "specimen = \"other.specimen.toml\"\n");
  LiveBench bench(folder, "sim:" + rig);
  Browser browser(folder);
  Tab tab = browser.open(bench.url);
  tab.until("document.getElementById('fire').disabled === false");
  press(tab, "fire");
  const std::string touch =
      "[...document.querySelectorAll('#quantities tr')].find(r=>r.cells[0].textContent==='t_ct1')";
  tab.until(touch + ".cells[6].textContent === 'differs' && " + touch + ".cells[6].className === 'bad'");
  CHECK(tab.value("+" + touch + ".cells[5].textContent").get<double>() > 1);
}

TEST_CASE("live page: an unfinished plan is gone on with from the list of campaigns", "[.slow]") {
  const Folder folder;
  LiveBench bench(folder);
  Browser browser(folder);
  Tab tab = browser.open(bench.url);
  press(tab, "tab-parameters");
  tab.until("document.getElementById('text').value.length > 10");
  tab.value(
      "(()=>{const t=document.getElementById('text');t.value='name = \"half\"\\nangles_deg = [0, 90]\\n"
      "repeats = 4\\npause_s = 0.3\\n';t.dispatchEvent(new Event('input'))})()");
  tab.until(says("8 shots in about"));
  press(tab, "run");
  tab.until("document.getElementById('end').hidden === false");
  tab.until(
      "document.getElementById('shot-reason').textContent.includes('simulated after the last closing of the "
      "plan')");
  press(tab, "end");
  const std::string no_job = "fetch('/api/bench').then(r=>r.json()).then(b=>b.job===null)";
  tab.until(no_job);
  tab.until("document.getElementById('shot-reason').textContent.includes('; not simulated: a plan')");
  press(tab, "tab-documents");
  const std::string go_on =
      "[...document.querySelectorAll('#campaigns button')].find(b=>b.textContent.startsWith('Fire the "
      "rest'))";
  tab.until(go_on);
  CHECK(tab.value("/unfinished: .*(0|90)°.* missing/.test(document.getElementById('campaigns').innerText)") ==
        true);
  // it asks first, names the campaign, and stays asked where the list is made anew; in one go, for it forgets after 6 s
  CHECK(tab.value("(async()=>{const button=()=>" + go_on +
                  ";button().click();"
                  "const old=button(),named=/of campaign \\d+ now/.test(old.textContent);"
                  "document.getElementById('tab-documents').click();"
                  "while(old.isConnected||!button())await new Promise(requestAnimationFrame);"
                  "const kept=/of campaign \\d+ now/.test(button().textContent),idle=await " +
                  no_job + ";button().click();return [named,kept,idle]})()") ==
        nlohmann::json({true, true, true}));
  tab.until("document.getElementById('test').hidden === false");
  tab.until("/ of 8/.test(document.getElementById('job').textContent)");
  tab.until(no_job);
  press(tab, "tab-documents");
  tab.until("document.querySelectorAll('#campaigns tr').length === 1 && !(" + go_on + ")");
  CHECK(tab.value("fetch('/api/campaigns').then(r=>r.json()).then(l=>l[0].shots)") == 8);
  CHECK(tab.errors() == std::vector<std::string>());
}

TEST_CASE("live page: what is typed and not saved outlives a reload, and says so", "[.slow]") {
  const Folder folder;
  const std::string text = "name = \"typed\"\nangles_deg = [0, 90]\nrepeats = 2\n",
                    plan = folder.write("lab.plan.toml", text);
  LiveBench bench(folder, "sim:", "0", {"--plan", plan});
  Browser browser(folder);
  Tab tab = browser.open(bench.url + "/#parameters");
  const auto repeats = [](const char* n) {
    return "/repeats = " + std::string(n) + "/.test(document.getElementById('text').value)";
  };
  tab.until(repeats("2"));
  tab.value(
      "(()=>{const t=document.getElementById('text');t.value=t.value.replace('repeats = 2','repeats = 3');"
      "t.dispatchEvent(new Event('input'))})()");
  tab.value("window.old = true");
  tab.value("void setTimeout(() => location.reload())");
  tab.until("window.old === undefined && document.readyState === 'complete'");
  press(tab, "tab-parameters");
  tab.until(says("not saved is back"));
  CHECK(tab.value(repeats("3")) == true);
  CHECK(read_file(plan) == text);
  press(tab, "reload");
  tab.until(repeats("2"));
  // an angle of the touch must not become one of the coil
  const std::string at = "document.getElementById('at')";
  tab.value("(()=>{" + at + ".value='touch';" + at + ".dispatchEvent(new Event('input'));" +
            "const a=document.getElementById('angle');a.value='45';a.dispatchEvent(new Event('input'))})()");
  tab.value("window.old = true");
  tab.value("void setTimeout(() => location.reload())");
  tab.until("window.old === undefined && document.readyState === 'complete'");
  tab.until("document.getElementById('angle').value === '45' && " + at + ".value === 'touch' && " + at +
            ".parentElement.innerText.includes('Contacts touch at')");
  CHECK(tab.errors() == std::vector<std::string>());
}

TEST_CASE("live page: what comes while another page is looked at has its size and its place", "[.slow]") {
  const Folder folder;
  LiveBench bench(folder);
  Browser browser(folder);
  Tab tab = browser.open(bench.url + "#documents");
  tab.size(1200, 1000);
  tab.until("!document.getElementById('fire').disabled");
  const auto fire = [&](int shot) {
    tab.value("document.getElementById('fire-form').requestSubmit()");
    tab.until("fetch('/api/bench').then(r=>r.json()).then(b=>b.newest_shot>=" + std::to_string(shot) +
              "&&b.job===null)");
  };
  const auto widths = [&](const std::string& of) {
    return tab.value("Math.min(...[...document.querySelectorAll('" + of +
                     " canvas')].map(c=>c.clientWidth))");
  };
  const std::string drawn =
      "document.querySelectorAll('#panels .closer-panel canvas').length > 0 && "
      "document.querySelectorAll('#trend canvas').length > 0";
  fire(1);
  press(tab, "tab-test");
  tab.until(drawn);
  CHECK(widths("#panels") > 800);
  CHECK(widths("#trend") > 800);
  press(tab, "tab-documents");
  tab.size(1000, 900);
  fire(2);
  press(tab, "tab-test");
  tab.until("document.getElementById('shot-title').textContent.startsWith('Shot ') && " + drawn);
  CHECK(widths("#panels") > 700);
  CHECK(widths("#panels") < 1000);
  CHECK(widths("#trend") > 700);
  CHECK(widths("#trend") < 1000);
  // a plan that was ended says so where it ran, and the list of shots that stands open grows
  press(tab, "tab-parameters");
  tab.until("document.getElementById('text').value.length > 10");
  tab.value(
      "(()=>{const t=document.getElementById('text');t.value='name = \"half\"\\nangles_deg = [0, 90]\\n"
      "repeats = 3\\npause_s = 2\\n';t.dispatchEvent(new Event('input'))})()");
  tab.until(says("6 shots in about"));
  press(tab, "run");
  tab.until("fetch('/api/bench').then(r=>r.json()).then(b=>b.job&&b.job.done>=1)");
  press(tab, "end");
  tab.until("/^half: [1-5] of 6 recorded; /.test(document.getElementById('job').textContent)");
  press(tab, "tab-documents");
  const std::string half =
      "[...document.querySelectorAll('#campaigns tr')].find(r=>/half/.test(r.textContent))";
  tab.until(half);
  tab.value(half + ".cells[0].querySelector('button').click()");
  const std::string shots = "document.querySelectorAll('#shots tr').length";
  tab.until(shots + " > 0 && " + shots + " < 6");
  const std::string go_on =
      "[...document.querySelectorAll('#campaigns button')].find(b=>b.textContent.startsWith('Fire the "
      "rest'))";
  tab.until(go_on);
  tab.value(go_on + ".click()");  // it asks first, and names the campaign
  CHECK(tab.value("/of campaign \\d+ now/.test(" + go_on + ".textContent)") == true);
  CHECK(tab.value("fetch('/api/bench').then(r=>r.json()).then(b=>b.job===null)") == true);
  tab.value(go_on + ".click()");
  tab.until("/^half: all 6 done/.test(document.getElementById('job').textContent)");
  press(tab, "tab-documents");
  tab.until(shots + " >= 6");
  CHECK(tab.errors() == std::vector<std::string>());
}

TEST_CASE("live page: tables wider than a phone say so, and the scope's labels are whole", "[.slow]") {
  const Folder folder;
  LiveBench bench(folder);
  Browser browser(folder);
  Tab tab = browser.open(bench.url);
  press(tab, "fire");
  tab.until(row_of_each("#quantities"));
  const std::string hint = "document.querySelector('#shot .wide + .aside').offsetParent !== null";
  tab.size(1200, 1000);
  tab.until("!(" + hint + ")");
  tab.size(390, 800);
  tab.until(hint);
  const char* pictures = std::getenv("POWBENCH_PICTURES");
  if (pictures != nullptr) {
    tab.value("document.querySelector('#shot .wide').scrollIntoView()");
    tab.picture(std::string(pictures) + "/live-phone-table.png");
  }
  press(tab, "tab-rig");
  tab.until("document.getElementById('scope').dataset.labels");
  CAPTURE(tab.value("document.getElementById('scope').dataset.labels"));
  CHECK(tab.value("(()=>{const g=document.createElement('canvas').getContext('2d');g.font='12px sans-serif';"
                  "const s=document.getElementById('scope').dataset;"
                  "return s.labels.split(', ').every(l=>g.measureText(l).width<=s.gutter-3)})()") == true);
  CHECK(tab.value("/-0(\\.0*)? /.test(document.getElementById('scope').dataset.labels)") == false);
  CHECK(tab.value("document.documentElement.scrollWidth <= window.innerWidth") == true);
  if (pictures != nullptr) tab.picture(std::string(pictures) + "/live-phone-scope.png");
  CHECK(tab.errors() == std::vector<std::string>());
}
