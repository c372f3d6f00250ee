#include <algorithm>
#include <catch2/catch.hpp>
#include <cstdlib>
#include <sstream>

#include "tests/system/browser.h"
#include "tests/system/live_bench.h"

using namespace powbench::test;

namespace {

/// Resident memory of a process, bytes.
double resident(int pid) {
  std::istringstream lines(read_file("/proc/" + std::to_string(pid) + "/status"));
  for (std::string line; std::getline(lines, line);)
    if (line.starts_with("VmRSS:")) return std::stod(line.substr(6)) * 1024;
  return 0;
}

/// Waits until so many closings of the running plan are done and pauses it: nothing is in flight then. The page itself
/// looks once a second.
void pause_at(Tab& tab, int shots) {
  const auto job = [&](const std::string& what) {
    return tab.value(
        "new "
        "Promise(r=>setTimeout(r,1000)).then(()=>fetch('/api/"
        "bench')).then(r=>r.json()).then(b=>b.job&&b.job." +
        what + ")");
  };
  while (job("done").get<int>() < shots) continue;
  press(tab, "pause");
  while (job("doing") != "paused") continue;
}

/// What the page keeps, bytes: the least of five looks. A picture that is just on its way adds 5 MB to a single one.
double kept(Tab& tab) {
  double least = tab.heap();
  for (int more = 0; more < 4; ++more) {
    tab.value("new Promise(r=>setTimeout(r,300))");
    least = std::min(least, tab.heap());
  }
  return least;
}

}  // namespace

/// POWBENCH_SHOTS sets how many closings it takes; 10 000 are those of docs/how-to/serve.md.
/// The simulations of a plan come after its last closing and need memory of their own: the plan is longer than what is
/// looked at.
TEST_CASE("live bench: shots come, the memory of program and page stays", "[.slow]") {
  const char* wish = std::getenv("POWBENCH_SHOTS");
  const int all = wish ? std::atoi(wish) : 160, first = all / 4, planned = all / 4 * 4 + 200;
  const Folder folder;
  const std::string plan = folder.write(
      "long.plan.toml",
      "name = \"long\"\nangles_deg = [0, 45, 90, 135]\nrepeats = " + std::to_string(planned / 4) + "\n");
  LiveBench bench(folder, "sim:", "0", {"--plan", plan});
  Browser browser(folder);
  Tab tab = browser.open(bench.url);
  tab.until("document.getElementById('fire').disabled === false");
  press(tab, "tab-parameters");
  press(tab, "run");
  press(tab, "tab-test");
  tab.until("fetch('/api/bench').then(r=>r.json()).then(b=>b.job!==null&&b.job.shots===" +
            std::to_string(planned) + ")");
  pause_at(tab, first);
  const double page = kept(tab), program = resident(bench.program.pid());
  press(tab, "pause");  // goes on
  pause_at(tab, all);
  const double page_after = kept(tab), program_after = resident(bench.program.pid());
  press(tab, "stop");
  tab.until(no_job);
  WARN(all - first << " more shots: page " << page / 1e6 << " -> " << page_after / 1e6 << " MB, program "
                   << program / 1e6 << " -> " << program_after / 1e6 << " MB");
  CHECK(page_after < page + 3e6);
  CHECK(program_after < program + 12e6);
  CHECK(tab.errors() == std::vector<std::string>());
}
