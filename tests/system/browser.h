#pragma once

#include <memory>
#include <nlohmann/json.hpp>
#include <string>
#include <vector>

#include "tests/folder.h"

namespace powbench::test {

/// One tab of a browser without a screen, driven through its debugging port.
class Tab {
 public:
  Tab(unsigned port, const std::string& websocket_path);
  ~Tab();
  Tab(Tab&&) noexcept;

  /// The value of a JavaScript expression; of a promise what it comes to. Throws std::runtime_error with what the
  /// page threw.
  nlohmann::json value(const std::string& expression);
  /// Waits until the expression is true.
  void until(const std::string& expression);
  void go(const std::string& url);
  /// A key pressed and let go: "Escape", "Tab", "Enter", "ArrowRight", "ArrowDown" or one character.
  void key(const std::string& name);
  void size(int width, int height);
  void dark(bool);
  /// PNG of what is seen.
  void picture(const std::string& file);
  /// Names of the fonts in which the text of the first such element is really drawn.
  std::vector<std::string> fonts(const std::string& selector);
  /// Memory that the page's scripts hold when all garbage has been collected, bytes.
  double heap();
  /// Errors of the console and refusals of the page's policy so far.
  const std::vector<std::string>& errors() const;
  /// Addresses that the page has asked for so far.
  const std::vector<std::string>& requests() const;

 private:
  nlohmann::json call(const std::string& method, const nlohmann::json& parameters = nlohmann::json::object());
  struct Impl;
  std::unique_ptr<Impl> impl_;
};

/// A browser of its own for one test; ends with the object.
class Browser {
 public:
  explicit Browser(const Folder&);
  ~Browser();
  Browser(const Browser&) = delete;
  Browser& operator=(const Browser&) = delete;
  Tab open(const std::string& url);

 private:
  int pid_ = -1;
  unsigned port_ = 0;
};

}  // namespace powbench::test
