#include <catch2/catch.hpp>
#include <memory>

#include "host/store/store.h"
#include "tests/other_process.h"
#include "tests/system/live_bench.h"

/// Who may do what in the live bench, as a person meets it.

using namespace powbench;
using namespace powbench::test;
using Catch::Contains;

TEST_CASE("live page: a token is asked for in the page, and Esc stays STOP", "[.slow]") {
  const Folder folder;
  const std::string tokens = folder.write("tokens", "fire 0123456789abcdef\nread fedcba9876543210\n");
  LiveBench bench(folder, "sim:", "0", {"--token-file", tokens});
  Browser browser(folder);
  Tab tab = browser.open(bench.url);
  tab.until("!document.getElementById('token-form').hidden");
  CHECK(tab.value("document.getElementById('fire').disabled") == true);
  tab.value("document.getElementById('token').focus()");
  tab.key("Escape");
  tab.until(says("coil off, confirmed by the rig"));
  const auto give = [&](const std::string& token) {
    tab.value("(()=>{document.getElementById('token').value='" + token +
              "';document.getElementById('token-form').requestSubmit()})()");
  };
  give("a token of nobody");
  tab.until(says("does not know this token"));
  give("fedcba9876543210");
  tab.until("document.getElementById('token-form').hidden");
  tab.until("document.getElementById('fire').title === 'the token may not fire'");
  CHECK(tab.value("document.getElementById('fire').disabled") == true);
  tab.value("sessionStorage.clear()");
  tab.go(bench.url + "/?again");
  tab.until("!document.getElementById('token-form').hidden");
  give("0123456789abcdef");
  tab.until("document.getElementById('fire').disabled === false");
  press(tab, "fire");
  tab.until("/Shot 1/.test(document.getElementById('shot-title').textContent)");
  press(tab, "tab-documents");
  tab.until("document.querySelectorAll('#campaigns a').length > 1");
  const std::string links =
      tab.value("[...document.querySelectorAll('#campaigns a')].map(a=>a.href).join(' ')");
  CHECK_THAT(links, Contains("token=") && !Contains("0123456789abcdef"));
  CHECK(tab.value("fetch(document.querySelector('#campaigns a').href).then(r=>r.status)") == 200);
}

TEST_CASE("live page: a shot that was on when the program ended is named", "[.slow]") {
  const Folder folder;
  auto bench = std::make_unique<LiveBench>(folder);
  const std::string url = bench->url, port = url.substr(url.rfind(':') + 1);
  Browser browser(folder);
  Tab tab = browser.open(url);
  press(tab, "fire");
  tab.until("/Shot 1/.test(document.getElementById('shot-title').textContent)");
  tab.until(no_job);
  bench.reset();
  REQUIRE(in_another_process([&] {
            host::Store store(folder.file("lab.db"));
            host::StoredShot next = store.shot(1);
            ++next.number;
            store.begin_shot(next);
          }) == 0);
  LiveBench again(folder, "sim:", port);
  tab.go(url);
  tab.until(
      "/^Shot [0-9]+ of campaign 1, coil on at [0-9.]+°, was on when the program ended: it stands there as "
      "ERROR/.test("
      "document.getElementById('alarm').textContent)");
  CHECK(tab.value("fetch('/api/campaigns').then(r=>r.json()).then(l=>l[0].outcomes.ERROR)") == 1);
  picture(tab, "live-interrupted.png");
  press(tab, "fire");
  tab.until("document.getElementById('alarm').hidden");
}

TEST_CASE("live page: the program started anew under an open page, which fires again", "[.slow]") {
  const Folder folder;
  auto bench = std::make_unique<LiveBench>(folder);
  const std::string url = bench->url, port = url.substr(url.rfind(':') + 1);
  Browser browser(folder);
  Tab tab = browser.open(url);
  tab.until("document.getElementById('fire').disabled === false");
  bench.reset();
  tab.until(says("does not answer"));
  press(tab, "stop");
  tab.until(says("STOP FAILED"));
  LiveBench again(folder, "sim:", port);
  tab.until(says("coil off, confirmed by the rig"));  // told again, without a word from anyone
  tab.until("document.getElementById('fire').disabled === false");
  press(tab, "fire");
  tab.until("/Shot 1/.test(document.getElementById('shot-title').textContent)");
}
