#pragma once

#include <cstdlib>
#include <stdexcept>
#include <string>
#include <vector>

#include "core/quantities.h"
#include "tests/system/browser.h"
#include "tests/system/program.h"
#include "tests/waiting.h"

namespace powbench::test {

/// `powbench serve` on a free port.
struct LiveBench {
  explicit LiveBench(const Folder& f, const std::string& rig = "sim:", const std::string& port = "0",
                     const std::vector<std::string>& more = {})
      : program(f, words(f, rig, port, more)) {
    wait_until("the live bench", [&] {
      const std::string text = program.err();
      if (program.poll() != -1000) throw std::runtime_error("it ended: " + text);
      const auto at = text.find("http://"), end = text.find("/,", at);
      if (at == std::string::npos || end == std::string::npos) return false;
      url = text.substr(at, end - at);
      return true;
    });
  }
  static std::vector<std::string> words(const Folder& f, const std::string& rig, const std::string& port,
                                        const std::vector<std::string>& more) {
    std::vector<std::string> all{
        "serve", "--rig", rig, "--db", f.file("lab.db"), "--listen", "127.0.0.1:" + port};
    all.insert(all.end(), more.begin(), more.end());
    return all;
  }
  Program program;
  std::string url;
};

/// JavaScript: does the page show these words?
inline std::string says(const std::string& words) {
  return "document.body.innerText.includes(" + nlohmann::json(words).dump() + ")";
}

/// Presses a button by its id, as soon as it can be pressed.
inline void press(Tab& tab, const std::string& id) {
  tab.until("document.getElementById('" + id + "') && !document.getElementById('" + id + "').disabled");
  tab.value("document.getElementById('" + id + "').click()");
}

/// JavaScript: has this table a row for every quantity?
inline std::string row_of_each(const std::string& table) {
  return "document.querySelectorAll('" + table + " tr').length === " + std::to_string(quantity_table.size());
}

/// JavaScript: is nothing under way?
inline const std::string no_job = "fetch('/api/bench').then(r=>r.json()).then(b=>b.job===null)";

/// Opens the page of the plan and puts this text there.
inline void write_plan(Tab& tab, const std::string& plan) {
  press(tab, "tab-parameters");
  tab.until("document.getElementById('text').value.length > 10");
  tab.value("(()=>{const t=document.getElementById('text');t.value=" + nlohmann::json(plan).dump() +
            ";t.dispatchEvent(new Event('input'))})()");
}

/// A picture of the page where POWBENCH_PICTURES names a folder: those of docs/how-to/serve.md are made so.
inline void picture(Tab& tab, const std::string& name) {
  if (const char* pictures = std::getenv("POWBENCH_PICTURES"))
    tab.picture(std::string(pictures) + "/" + name);
}

}  // namespace powbench::test
