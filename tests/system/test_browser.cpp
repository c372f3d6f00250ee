#include <catch2/catch.hpp>
#include <nlohmann/json.hpp>
#include <set>

#include "tests/places.h"
#include "tests/system/browser.h"
#include "tests/system/program.h"

/// The report in a real browser, opened as a file: at a desk, on a phone, in the dark, by keyboard, and on paper.
/// Without a browser these cases fail; `./dev test --slow` installs one.

using namespace powbench::test;
using Catch::Contains;
using nlohmann::json;

namespace {

/// One function of the page per probe: what it finds comes back as JSON.
json probe(Tab& tab, const std::string& body) {
  return tab.value("(()=>{" + body + "})()");
}

/// Lines of text on each page of the PDF, by `pdftotext`: pages end with a form feed.
std::vector<int> lines_of_pages(const std::string& pdf, const std::string& text) {
  REQUIRE(std::system(("pdftotext -layout '" + pdf + "' '" + text + "'").c_str()) == 0);
  std::vector<int> lines{0};
  bool blank = true;
  for (const char c : read_file(text)) {
    if (c == '\f') lines.push_back(0);
    if (c == '\n' && !std::exchange(blank, true)) ++lines.back();
    if (c > ' ') blank = false;
  }
  lines.pop_back();
  return lines;
}

void at_a_desk(Tab& tab) {
  tab.size(1200, 900);
  const json panels = probe(tab, R"(
    const found={},box=document.getElementById('closer');
    found.hidden=box.hidden;
    found.panels=box.querySelectorAll('.closer-panel canvas').length;
    found.closings=document.getElementById('closer-shot').options.length;
    const labels=()=>[...box.querySelectorAll('.closer-panel.last .dygraph-axis-label-x')].map(e=>+e.textContent);
    const press=w=>{box.querySelector('button[data-do='+w+']').click();const l=labels();return l[l.length-1]-l[0]};
    for(const w of ['whole','bounce','in','out'])found[w]=press(w);
    const tick=document.getElementById('closer-stripped');tick.checked=true;tick.dispatchEvent(new Event('change'));
    found.legend=box.querySelector('.dygraph-legend').textContent;
    const s=document.getElementById('closer-shot');s.selectedIndex=1;s.dispatchEvent(new Event('change'));
    found.after=box.querySelectorAll('.closer-panel').length;
    return found)");
  CAPTURE(panels.dump());
  CHECK(panels.at("hidden") == false);
  CHECK(panels.at("closings") == 7);
  CHECK(panels.at("panels").get<int>() >= 12);  // two canvases a panel
  CHECK(panels.at("after") == 6);
  CHECK(panels.at("bounce").get<double>() < 0.5 * panels.at("whole").get<double>());
  CHECK(panels.at("in").get<double>() < 0.8 * panels.at("bounce").get<double>());
  CHECK(panels.at("out").get<double>() > panels.at("in").get<double>());
  CHECK_THAT(panels.at("legend").get<std::string>(), Contains("raw minus measured") && Contains("simulated"));

  // the device stands open, then closed, where the laser and the contact voltage say so
  const json device = probe(tab, R"(
    const time=document.getElementById('device-time'),said=()=>document.getElementById('device-says').textContent;
    const paint=()=>{const c=document.getElementById('device-view'),o=document.createElement('canvas');
      o.width=c.width;o.height=c.height;const x=o.getContext('2d',{willReadFrequently:true});x.drawImage(c,0,0);
      const d=x.getImageData(0,0,o.width,o.height).data;let n=0,h=0;
      for(let i=3;i<d.length;i+=4)if(d[i]){++n;h=(h*31+d[i-1]+i)|0}return[n,h]};
    const at=t=>{time.value=t;time.dispatchEvent(new Event('input'));return{said:said(),paint:paint()}};
    return{open:at(1),shut:at(28)})");
  CAPTURE(device.dump());
  CHECK_THAT(device.at("open").at("said").get<std::string>(),
             Contains("1.00 ms") && Contains("contacts open"));
  CHECK_THAT(device.at("shut").at("said").get<std::string>(), Contains("contacts closed"));
  CHECK(device.at("open").at("paint").at(0).get<int>() > 5000);
  CHECK(device.at("open").at("paint") != device.at("shut").at("paint"));

  // text is drawn in a sans-serif face, whichever of the list this machine has
  const std::vector<std::string> fonts = tab.fonts("h1");
  REQUIRE(!fonts.empty());
  for (const std::string& font : fonts)
    CHECK_THAT(font, !Contains("Serif") && !Contains("Times") && !Contains("Tinos"));
}

/// Every control is reached by the Tab key, has a name, and shows that it has the focus.
void by_keyboard(Tab& tab) {
  CHECK(probe(tab, R"(return [...document.querySelectorAll('button,select,input,[role=img]')]
    .filter(e=>e.offsetParent!==null&&!(e.textContent||e.getAttribute('aria-label')||(e.labels&&e.labels.length)))
    .map(e=>e.tagName+' '+e.id))") == json::array());
  const json wanted = probe(tab, R"(return [...document.querySelectorAll('button,select,input')]
    .filter(e=>e.offsetParent!==null).map((e,i)=>e.dataset.n=i).map(String))");
  REQUIRE(wanted.size() > 8);
  std::set<std::string> reached;
  probe(tab, "document.body.focus();window.scrollTo(0,0)");
  for (std::size_t i = 0; i < 3 * wanted.size() + 10; ++i) {
    tab.key("Tab");
    const json at = probe(tab, "const e=document.activeElement;return e&&e.dataset.n?e.dataset.n:''");
    if (at != "") reached.insert(at.get<std::string>());
  }
  CHECK(reached.size() == wanted.size());
}

void on_a_phone(Tab& tab) {
  tab.size(390, 844);
  const json seen = probe(tab, R"(
    const wide=[...document.querySelectorAll('p,h1,h2,h3,figcaption,li,.verdict')].filter(e=>e.offsetParent!==null)
      .filter(e=>{const r=e.getBoundingClientRect();return r.width>0&&(r.left<-1||r.right>391)
        &&!e.closest('.wide,.scroll,figure,table')}).map(e=>e.textContent.slice(0,40));
    return{page:document.documentElement.scrollWidth,wide,
      small:[...document.querySelectorAll('p,td,th,figcaption')].filter(e=>e.offsetParent!==null
        &&parseFloat(getComputedStyle(e).fontSize)<10).length}
  )");
  CAPTURE(seen.dump());
  CHECK(seen.at("page").get<int>() <= 390);
  CHECK(seen.at("wide") == json::array());
  CHECK(seen.at("small") == 0);
}

}  // namespace

TEST_CASE("the report in a browser: desk, keyboard, phone, dark, paper", "[.slow]") {
  Folder folder;
  REQUIRE(run(folder, {"demo", "-o", folder.file("demo"), "--progress", "none"}).status == 0);
  Browser browser(folder);
  Tab tab = browser.open("file://" + folder.file("demo/report.html"));
  const auto picture = [&](const char* name) {
    if (const char* pictures = std::getenv("POWBENCH_PICTURES"))
      tab.picture(std::string(pictures) + "/" + name);
  };
  tab.size(900, 1180);  // about a page of paper
  picture("report-page.png");
  at_a_desk(tab);
  picture("report.png");
  by_keyboard(tab);
  on_a_phone(tab);
  picture("report-phone.png");

  const std::string axe = read_file(powbench::test::page_tools() + "/axe-core/axe.min.js");
  REQUIRE(axe.size() > 100'000);
  tab.size(1200, 900);
  tab.value("(()=>{" + axe + ";window.axe=window.axe||axe;})()");
  for (const bool dark : {false, true}) {
    CAPTURE(dark);
    tab.dark(dark);
    const json paper = probe(tab, R"(
      const light=c=>c.match(/\d+/g).slice(0,3).reduce((a,v)=>a+ +v,0)/3;
      return[light(getComputedStyle(document.documentElement).backgroundColor),
      light(getComputedStyle(document.body).color)])");
    CHECK((paper.at(0).get<double>() > 128) == !dark);
    CHECK((paper.at(1).get<double>() > 128) == dark);
    const auto found = tab.value(
        "axe.run({resultTypes:['violations']}).then(r=>r.violations.filter(v=>['serious','critical']."
        "includes("
        "v.impact)).map(v=>v.id+': '+v.nodes.slice(0,3).map(n=>n.target.join(' ')).join(', ')))");
    CHECK(found.dump() == "[]");
  }
  picture("report-dark.png");
  CHECK(tab.errors() == std::vector<std::string>());
  for (const std::string& asked : tab.requests())
    CHECK_THAT(asked, Catch::StartsWith("file://") || Catch::StartsWith("data:"));

  CHECK(run(folder, {"report", "--db", folder.file("demo/demo.db"), "-o", folder.file("out"), "--pdf"})
            .status == 0);
  CHECK(read_file(folder.file("out/report.pdf")).starts_with("%PDF-"));
  const std::vector<int> pages = lines_of_pages(folder.file("out/report.pdf"), folder.file("report.txt"));
  CAPTURE(pages);
  CHECK(pages.size() > 8);
  CHECK(pages.size() < 14);
  for (const int lines : pages) CHECK(lines >= 15);
}

TEST_CASE("the device of the report opens and closes by the contact voltage that the rig has", "[.slow]") {
  const Folder folder;
  const std::string rig = folder.write("low.rig.toml", "[electrical]\ncontact_open_V = 2\n"),
                    plan = folder.write("p.toml", "angles_deg = [60]\nrepeats = 1\n"),
                    db = folder.file("a.db");
  REQUIRE(run(folder, {"run", plan, "--rig", "sim:" + rig, "--db", db, "--progress", "none"}).status == 0);
  REQUIRE(run(folder, {"report", "--db", db, "-o", folder.file("out")}).status == 0);
  Browser browser(folder);
  Tab tab = browser.open("file://" + folder.file("out/report.html"));
  const json said = probe(tab, R"(
    const time=document.getElementById('device-time');
    const says=document.getElementById('device-says');
    const at=t=>{time.value=t;time.dispatchEvent(new Event('input'));return says.textContent};
    return[at(1),at(28)])");
  CHECK_THAT(said.at(0).get<std::string>(), Contains("contacts open"));
  CHECK_THAT(said.at(1).get<std::string>(), Contains("contacts closed"));
}

/// As the browser's own clock sees it. Printed, not asserted.
TEST_CASE("the report of 60 closings in a browser: when it can be used, how long a zoom takes", "[.slow]") {
  const Folder folder;
  const std::string plan = folder.write(
      "p.toml", "angles_deg = [0, 15, 30, 45, 60, 75, 90, 105, 120, 135, 150, 165]\nrepeats = 5\n");
  const std::string db = folder.file("60.db");
  REQUIRE(run(folder, {"run", plan, "--rig", "sim:", "--db", db}).status == 0);
  REQUIRE(run(folder, {"report", "--db", db, "-o", folder.file("out")}).status == 0);
  Browser browser(folder);
  const std::string page = "file://" + folder.file("out/report.html");
  Tab tab = browser.open(page);
  tab.size(1200, 900);
  std::vector<double> usable, zoom;
  for (int k = 0; k < 5; ++k) {
    tab.go(page);
    usable.push_back(
        tab.value("new Promise(done=>{const look=()=>document.querySelector('#closer .closer-panel canvas')?"
                  "done(performance.now()):requestAnimationFrame(look);look()})")
            .get<double>());
    for (const char* button : {"bounce", "in", "whole"})
      zoom.push_back(
          tab.value(std::string("new Promise(done=>{const t=performance.now();document."
                                "querySelector('button[data-do=") +
                    button +
                    "]').click();"
                    "requestAnimationFrame(()=>requestAnimationFrame(()=>done(performance.now()-t)))})")
              .get<double>());
  }
  std::sort(usable.begin(), usable.end());
  std::sort(zoom.begin(), zoom.end());
  WARN("from asking for the page until its curves can be zoomed, 5 times: median "
       << usable[2] << " ms, worst " << usable[4] << " ms; a zoom until it is drawn, 15 times: median "
       << zoom[7] << " ms, worst " << zoom[14] << " ms");
  CHECK(tab.errors() == std::vector<std::string>());
}
