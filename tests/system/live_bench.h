#pragma once

#include <stdexcept>
#include <string>
#include <vector>

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

}  // namespace powbench::test
