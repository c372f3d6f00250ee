#include <catch2/catch.hpp>
#include <nlohmann/json.hpp>

#include "host/gather/pdf.h"
#include "tests/system/program.h"

/// The report in a real browser: what its script makes of it, at the width of a desk and of a phone, and on paper. Without a browser
/// these cases fail; `./dev test --slow` installs one.

using namespace powbench::test;
using Catch::Contains;
using nlohmann::json;

namespace {

/// What a script that is run in the page has put into the page's <pre id="found">, and every line of the browser's console.
struct Seen {
  json found;
  std::string console;
};

Seen look(const Folder& folder, const std::string& page, const std::string& script, const std::string& size) {
  const std::string browser = powbench::host::find_browser();
  REQUIRE_FALSE(browser.empty());
  std::string html = read_file(page);
  const std::string probe =
      "<script>try{(function(){" + script +
      "})()}catch(e){document.body.insertAdjacentHTML('beforeend','<pre id=\"found\">{\"error\":\"'+"
      "String(e).replace(/\"/g,'')+'\"}</pre>')}</script>";
  html.insert(html.rfind("</body>"), probe);
  const std::string copy = folder.write("probed.html", html);
  const std::string root = geteuid() == 0 ? " --no-sandbox" : "";
  const std::string command =
      browser + root + " --headless --disable-gpu --enable-logging=stderr --window-size=" + size +
      " --user-data-dir=" + folder.file("profile") + " --virtual-time-budget=4000 --dump-dom file://" + copy +
      " > " + folder.file("dom.html") + " 2> " + folder.file("console.txt") + " < /dev/null";
  REQUIRE(std::system(command.c_str()) == 0);
  const std::string dom = read_file(folder.file("dom.html")), begin = "<pre id=\"found\">";
  const auto from = dom.rfind(begin);  // behind the probe itself
  INFO(read_file(folder.file("console.txt")));
  REQUIRE(from != std::string::npos);
  const auto end = dom.find("</pre>", from);
  Seen seen;
  seen.found = json::parse(dom.substr(from + begin.size(), end - from - begin.size()));
  std::istringstream lines(read_file(folder.file("console.txt")));
  for (std::string line; std::getline(lines, line);)
    if (line.find("CONSOLE") != std::string::npos) seen.console += line + "\n";
  return seen;
}

const std::string tell =
    "document.body.insertAdjacentHTML('beforeend','<pre id=\"found\">'+JSON.stringify(found)+'</pre>');";

}  // namespace

TEST_CASE("the report in a browser: a closer look, buttons, the phone, paper", "[.slow]") {
  Folder folder;
  REQUIRE(run(folder, {"demo", "-o", folder.file("demo"), "--progress", "none"}).status == 0);
  const std::string page = folder.file("demo/report.html");

  SECTION("panels are drawn and move together") {
    const Seen seen = look(
        folder, page,
        "const found={};const box=document.getElementById('closer');found.hidden=box.hidden;"
        "found.panels=box.querySelectorAll('.closer-panel canvas').length;"
        "found.closings=document.getElementById('closer-shot').options.length;"
        "const labels=()=>[...box.querySelectorAll('.closer-panel.last "
        ".dygraph-axis-label-x')].map(e=>+e.textContent);"
        "const press=w=>{box.querySelector('button[data-do='+w+']').click();const l=labels();"
        "return l[l.length-1]-l[0];};"
        "found.whole=press('whole');found.bounce=press('bounce');found.closer=press('in');found.again="
        "press('out');"
        "const tick=document.getElementById('closer-stripped');tick.checked=true;"
        "tick.dispatchEvent(new "
        "Event('change'));found.legend=box.querySelector('.dygraph-legend').textContent;"
        "const s=document.getElementById('closer-shot');s.selectedIndex=1;s.dispatchEvent(new "
        "Event('change'));"
        "found.after=box.querySelectorAll('.closer-panel').length;"
        "const time=document.getElementById('device-time'),said=()=>document.getElementById('device-says')."
        "textContent;"
        "const paint=()=>{const "
        "c=document.getElementById('device-view'),o=document.createElement('canvas');o.width=c.width;o."
        "height=c."
        "height;const x=o.getContext('2d',{willReadFrequently:true});x.drawImage(c,0,0);const "
        "d=x.getImageData(0,0,o.width,o.height).data;let n=0,h=0;for(let "
        "i=3;i<d.length;i+=4)if(d[i]){++n;h=(h*31+d[i-1]+i)|0}return[n,h]};"
        "const at=t=>{time.value=t;time.dispatchEvent(new Event('input'));return{said:said(),paint:paint()}};"
        "found.open=at(1);found.shut=at(28);"
        "found.fonts=getComputedStyle(document.body).fontFamily;"
        "found.list=[...document.querySelectorAll('button,select,input,[role=img]')].filter(e=>e."
        "offsetParent!==null&&!(e."
        "textContent||"
        "e.getAttribute('aria-label')||(e.labels&&e.labels.length))).map(e=>e.tagName+' '+e.id+' "
        "'+e.getAttribute('class'));" +
            tell,
        "1200,900");
    CAPTURE(seen.found.dump());
    CHECK(seen.console == "");
    CHECK(seen.found.at("hidden") == false);
    CHECK(seen.found.at("closings") == 7);
    CHECK(seen.found.at("panels").get<int>() >= 12);  // two canvases a panel
    CHECK(seen.found.at("after") == 6);
    CHECK(seen.found.at("bounce").get<double>() < 0.5 * seen.found.at("whole").get<double>());
    CHECK(seen.found.at("closer").get<double>() < 0.8 * seen.found.at("bounce").get<double>());
    CHECK(seen.found.at("again").get<double>() > seen.found.at("closer").get<double>());
    CHECK_THAT(seen.found.at("legend").get<std::string>(),
               Contains("raw") && Contains("stripped off") && Contains("measured"));
    // the device stands open, then closed, where the laser and the contact voltage say so
    CHECK_THAT(seen.found.at("open").at("said").get<std::string>(),
               Contains("1.00 ms") && Contains("contacts open"));
    CHECK_THAT(seen.found.at("shut").at("said").get<std::string>(), Contains("contacts closed"));
    CHECK(seen.found.at("open").at("paint").at(0).get<int>() > 5000);
    CHECK(seen.found.at("open").at("paint") != seen.found.at("shut").at("paint"));
    CHECK_THAT(seen.found.at("fonts").get<std::string>(), Contains("sans-serif"));
    CHECK(seen.found.at("list").size() == 0);
  }
  SECTION("a phone's width") {
    const Seen seen =
        look(folder, page,
             "const f=document.createElement('iframe');f.style.cssText='width:390px;height:800px;border:0';"
             "const found={};found.wide=document.documentElement.scrollWidth<=window.innerWidth;"
             "found.width=window.innerWidth;" +
                 tell,
             "500,900");
    CAPTURE(seen.found.dump());
    CHECK(seen.console == "");
    CHECK(seen.found.at("wide") == true);
  }
  SECTION("printed") {
    CHECK(run(folder, {"report", "--db", folder.file("demo/demo.db"), "-o", folder.file("out"), "--pdf"})
              .status == 0);
    const std::string pdf = read_file(folder.file("out/report.pdf"));
    CHECK(pdf.starts_with("%PDF-"));
    std::size_t pages = 0;
    for (auto i = pdf.find("/Type /Page\n"); i != std::string::npos; i = pdf.find("/Type /Page\n", i + 1))
      ++pages;
    CHECK(pages > 8);
    CHECK(pages < 16);
  }
}
