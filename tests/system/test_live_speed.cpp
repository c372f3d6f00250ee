#include <algorithm>
#include <atomic>
#include <catch2/catch.hpp>
#include <ctime>
#include <mutex>
#include <thread>
#include <vector>

#include "host/config/plan_file.h"
#include "host/gather/scene.h"
#include "host/serve/api.h"
#include "host/serve/bench.h"
#include "host/serve/frame.h"
#include "host/serve/http.h"

#include "tests/system/browser.h"
#include "tests/system/live_bench.h"

using namespace powbench::test;

/// From the click until measured and simulated curves of the new shot are drawn, as the browser's own clock sees it.
/// Printed, not asserted.
TEST_CASE("live bench: from the click to the picture in a browser", "[.slow]") {
  const Folder folder;
  LiveBench bench(folder);
  Browser browser(folder);
  Tab tab = browser.open(bench.url);
  tab.size(1200, 1000);
  std::vector<double> usable;
  for (int k = 0; k < 5; ++k) {
    tab.go(bench.url);
    usable.push_back(
        tab.value("new Promise(done=>{const look=()=>document.getElementById('fire').disabled===false?"
                  "done(performance.now()):requestAnimationFrame(look);look()})")
            .get<double>());
  }
  std::sort(usable.begin(), usable.end());
  WARN("from asking for the page until a closing can be fired, 5 times: median " << usable[2] << " ms, worst "
                                                                                 << usable[4] << " ms");
  std::vector<double> ms, answered, told, data;
  for (int shot = 1; shot <= 31; ++shot) {
    tab.until("document.getElementById('fire').disabled === false");
    tab.value("(()=>{const a=document.getElementById('angle');a.value=" + std::to_string(11 * shot) +
              ";a.dispatchEvent(new Event('input'))})()");
    tab.value("new Promise(r=>setTimeout(r,700))");  // a person looks at what was typed
    const auto one =
        tab.value(
               "new Promise(done=>{performance.clearResourceTimings();const t=performance.now();"
               "const all=()=>{const e=performance.getEntriesByType('resource'),"
               "c=e.filter(r=>r.name.endsWith('/closing'));return [performance.now()-t,"
               "e.find(r=>r.name.endsWith('/api/fire')).responseEnd-t,c[0].startTime-t,"
               "c[c.length-1].responseEnd-t]};"
               // the title comes before the curves: until then the picture is that of the shot before
               "const before=document.querySelector('#panels .dygraph-legend');"
               "document.getElementById('fire').click();"
               "const look=()=>{const l=document.querySelector('#panels .dygraph-legend');"
               "if(document.getElementById('shot-title').textContent.includes(' at " +
               std::to_string(11 * shot) +
               "\u00b0')&&l&&(document.getElementById('panels').dataset.closing?document.getElementById('"
               "panels').dataset.closing.startsWith('shot "
               "'+document.getElementById('shot-title').textContent.split(' ')[1]+' "
               "'):l!==before)&&/simulated/.test(l.textContent))"
               "requestAnimationFrame(()=>done(all()));else "
               "requestAnimationFrame(look)};look()})")
            .get<std::vector<double>>();
    if (shot == 1) continue;  // it warms the page up
    ms.push_back(one[0]);
    answered.push_back(one[1]);
    told.push_back(one[2]);
    data.push_back(one[3]);
  }
  std::sort(ms.begin(), ms.end());
  WARN("click to picture in the browser, measured over simulated, 30 closings: median "
       << ms[15] << " ms, 95 % " << ms[28] << " ms, worst " << ms[29] << " ms");
  for (auto* part : {&answered, &told, &data}) std::sort(part->begin(), part->end());
  WARN("of that, medians from the click: the program has begun "
       << answered[15] << " ms, the page knows of the stored shot " << told[15] << " ms, has the curves "
       << data[15] << " ms");
  CHECK(tab.errors() == std::vector<std::string>());
}

/// Records of 6 channels x 20 000 points until the browser's scope has drawn them. The page asks for the next one
/// every 40 ms, and its clock counts. Printed, not asserted.
TEST_CASE("live bench: records drawn a second in a browser", "[.slow]") {
  namespace host = powbench::host;
  powbench::Record record;
  record.sample_rate = 100e3;
  for (std::size_t c = 0; c < 6; ++c) {
    powbench::ChannelRecord channel;
    channel.channel = static_cast<powbench::Channel>(c);
    for (std::size_t i = 0; i < 20'000; ++i) channel.raw.push_back(static_cast<std::int16_t>(i * (c + 1)));
    record.channels.push_back(std::move(channel));
  }
  const Folder folder;
  std::mutex mutex;
  std::int64_t shot = 0;
  std::shared_ptr<const std::string> newest;
  std::atomic<host::HttpServer*> told = nullptr;
  const auto next = [&] {
    {
      const std::scoped_lock lock(mutex);
      newest = std::make_shared<const std::string>(host::record_frame(record, ++shot, "SIMULATED RIG"));
    }
    if (host::HttpServer* s = told) s->recorded();
  };
  auto bench = std::make_unique<host::Bench>(
      "sim:", host::make_scene(host::parse_plan("angles_deg = [0]\nrepeats = 1\n", "plan")),
      folder.file("lab.db"), [&] {
        if (host::HttpServer* s = told) s->changed();
      });
  std::unique_ptr<host::Api> api;
  host::HttpServer server("127.0.0.1", 0,
                          {[&](const host::Request& r) {
                             if (r.path == "/api/campaigns") next();
                             return api->answer(r);
                           },
                           host::Api::is_stop, [&](const host::Request& r) { return api->listen(r); },
                           [&] { return bench->state(); },
                           [&] {
                             const std::scoped_lock lock(mutex);
                             return newest;
                           }});
  const std::string place = "127.0.0.1:" + std::to_string(server.port());
  api = std::make_unique<host::Api>(*bench, host::Access::made({place}));
  told = &server;
  std::thread serving([&] { server.serve(false); });
  {
    Browser browser(folder);
    Tab tab = browser.open("http://" + place);
    press(tab, "tab-rig");
    tab.value("setInterval(()=>fetch('/api/campaigns'),40)");
    const std::string drawn = "Number(document.getElementById('scope').dataset.drawn)";
    tab.until(drawn + " > 5");
    const std::clock_t used = std::clock();
    const double a_second =
        tab.value("new Promise(r=>{const t=performance.now(),n=" + drawn + ";setTimeout(()=>r((" + drawn +
                  "-n)/(performance.now()-t)*1e3),5000)})")
            .get<double>();
    const double cpu = static_cast<double>(std::clock() - used) / CLOCKS_PER_SEC;
    WARN("records of 6 x 20 000 points drawn in the browser: "
         << a_second << " a second, asked for every 40 ms; the server took " << 100 * cpu / 5
         << " % of a core");
    CHECK(a_second > 0);
    CHECK(tab.errors() == std::vector<std::string>());
  }
  server.stop();
  serving.join();
  told = nullptr;
  bench->stop();
  bench.reset();
}
