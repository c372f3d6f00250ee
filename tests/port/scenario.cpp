#include "tests/port/scenario.h"

#include <algorithm>
#include <cmath>
#include <fstream>
#include <sstream>
#include <stdexcept>

namespace powbench::test {

namespace {

using Words = std::vector<std::string>;

/// Form of each statement: `*` takes any word, `T` a time's number, with its unit behind it.
const Words forms[] = {{"needs", "*"},
                       {"shot", "*", "*"},
                       {"set", "*", "*"},
                       {"refused", "*", "*"},
                       {"is", "*", "*"},
                       {"is", "*", "*", "*"},
                       {"until", "*", "*", "within", "T", "U"},
                       {"until", "*", "*", "*", "within", "T", "U"},
                       {"wait", "T", "U"},
                       {"cause", "*"},
                       {"end", "*"},
                       {"gate", "on", "within", "T", "U"},
                       {"gate", "off", "within", "T", "U"},
                       {"gate", "off", "for", "T", "U"},
                       {"held", "T", "U", "within", "T", "U"},
                       {"angle", "*", "within", "*"},
                       {"relay", "in"},
                       {"relay", "out", "within", "T", "U"}};

bool fits(const Words& form, const Words& words) {
  if (form.size() != words.size()) return false;
  for (std::size_t i = 0; i < form.size(); ++i) {
    if (form[i] == "U" && words[i] != "us" && words[i] != "ms") return false;
    if (form[i] == "T" && words[i].find_first_not_of("0123456789.") != std::string::npos) return false;
    if (form[i] != "*" && form[i] != "T" && form[i] != "U" && form[i] != words[i]) return false;
  }
  return true;
}

/// us; number and unit stand at `at`.
double time_of(const Words& words, std::size_t at) {
  return std::stod(words[at]) * (words[at + 1] == "ms" ? 1000.0 : 1.0);
}

/// The value of `is` and `until`: one word, or two with a space.
std::string value_of(const Words& words, std::size_t behind) {
  std::string value = words[2];
  if (behind > 3) value += ' ' + words[3];
  return value;
}

class Player {
 public:
  explicit Player(Driver& driver) : driver_(driver), mark_(driver.now()) {}

  Played outcome;

  /// What was found where the statement does not hold.
  std::string run(const Words& w) {
    if (w[0] == "shot") return shot(w);
    if (w[0] == "set") return set(w[1], w[2]);
    if (w[0] == "refused") {
      const int answer = driver_.write(w[1], w[2]);
      return answer < 0 ? "" : "accepted";
    }
    if (w[0] == "is") return compare(driver_.read(w[1]), value_of(w, w.size()));
    if (w[0] == "until") return until(w);
    if (w[0] == "wait") driver_.run(time_of(w, 1));
    if (w[0] == "cause" || w[0] == "end") {
      mark_ = driver_.now();
      driver_.cause(w[1], w[0] == "cause");
    }
    if (w[0] == "gate") return gate(w);
    if (w[0] == "held") {
      const double held = driver_.gate_off_at() - driver_.gate_on_at();
      return std::fabs(held - time_of(w, 1)) <= time_of(w, 4) ? "" : std::to_string(held) + " us";
    }
    if (w[0] == "angle") {
      const double error = std::remainder(driver_.angle() - std::stod(w[1]), 360.0);
      return std::fabs(error) <= std::stod(w[3]) ? "" : std::to_string(driver_.angle()) + " degrees";
    }
    if (w[0] == "relay") return relay(w);
    return "";
  }

 private:
  static std::string compare(const std::string& found, const std::string& wanted) {
    return found == wanted ? "" : "it is " + found;
  }
  std::string set(const std::string& attribute, const std::string& value) {
    const int answer = driver_.write(attribute, value);
    mark_ = driver_.now();
    return answer > 0 ? "" : "refused: " + driver_.read("last_error");
  }
  std::string shot(const Words& w) {
    for (const auto& [attribute, value] :
         {std::pair<std::string, std::string>{"angle", std::to_string(std::lround(100 * std::stod(w[1])))},
          {"hold_time_ms", w[2]},
          {"arm", "1"}})
      if (const std::string found = set(attribute, value); !found.empty()) return found;
    driver_.run(80'000);
    return "";
  }
  std::string until(const Words& w) {
    const std::string wanted = value_of(w, w.size() - 3);
    const double end = driver_.now() + time_of(w, w.size() - 2);
    std::string found = driver_.read(w[1]);
    while (found != wanted && driver_.now() < end) {
      driver_.run(200);
      found = driver_.read(w[1]);
    }
    return compare(found, wanted);
  }
  std::string gate(const Words& w) {
    const double time = time_of(w, 3);
    if (w[1] == "on") {
      const double end = driver_.now() + time;
      while (!driver_.gate() && driver_.now() < end) driver_.run(100);
      mark_ = driver_.now();
      return driver_.gate() ? "" : "it is off; " + driver_.read("last_error");
    }
    if (w[2] == "for") {
      const double on = driver_.gate_on_at();
      driver_.run(time);
      return !driver_.gate() && driver_.gate_on_at() == on ? "" : "it was on";
    }
    driver_.run(mark_ + time + 500.0 - driver_.now());
    if (driver_.gate()) return "it is on";
    const double took = std::max(0.0, driver_.gate_off_at() - mark_);
    outcome.slowest_off = std::max(outcome.slowest_off, took);
    return took <= time ? "" : "after " + std::to_string(took) + " us";
  }
  std::string relay(const Words& w) {
    if (w[1] == "in") return driver_.relay() ? "" : "it is out";
    const double end = driver_.now() + time_of(w, 3);
    while (driver_.relay() && driver_.now() < end) driver_.run(200);
    return driver_.relay() ? "it is in" : "";
  }

  Driver& driver_;
  double mark_;  ///< us: what `gate off within` counts from
};

}  // namespace

std::vector<Statement> read_scenario(const std::filesystem::path& path) {
  std::ifstream file(path);
  std::vector<Statement> statements;
  std::string text;
  for (int line = 1; std::getline(file, text); ++line) {
    text.erase(std::min(text.find('#'), text.size()));
    std::istringstream stream(text);
    Words words;
    for (std::string word; stream >> word;) words.push_back(word);
    if (words.empty()) continue;
    bool known = false;
    for (const Words& form : forms) known = known || fits(form, words);
    if (!known)
      throw std::runtime_error(path.filename().string() + ":" + std::to_string(line) +
                               ": no statement: " + text);
    statements.push_back({line, text, words});
  }
  if (statements.empty()) throw std::runtime_error(path.string() + ": no statements, or no such file");
  return statements;
}

Played play(const std::vector<Statement>& statements, Driver& driver) {
  Player player(driver);
  for (const Statement& s : statements) {
    if (s.words[0] == "needs") {
      if (driver.offers(s.words[1])) continue;
      player.outcome.played = false;
      break;
    }
    if (const std::string found = player.run(s.words); !found.empty()) {
      player.outcome.failure = "line " + std::to_string(s.line) + ": " + s.text + ": " + found;
      break;
    }
  }
  return player.outcome;
}

}  // namespace powbench::test
