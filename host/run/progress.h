#pragma once

#include <chrono>
#include <cstddef>
#include <cstdio>
#include <string>

namespace powbench::host {

/// Tells a person how far a long job is. On a terminal: one bar that redraws itself, with the time to go. Elsewhere: a
/// line at the start, every 10 s and at the end, so that a log stays readable. Writes to stderr only.
class Progress {
 public:
  enum class Style { automatic, bar, lines, none };

  /// `done` of the total were finished before: the time to go is told from the others.
  Progress(std::string what, std::size_t total, Style style = Style::automatic, std::size_t done = 0);
  ~Progress();
  Progress(const Progress&) = delete;
  Progress& operator=(const Progress&) = delete;

  /// `done` of the total are finished; `note` is about the newest one.
  void update(std::size_t done, const std::string& note = {});
  /// A message that must stay: above the bar, or a line of its own.
  void say(const std::string& message);
  void finish();

  /// "1 min 20 s", "3.2 s": for people.
  static std::string duration(double seconds);

 private:
  void draw(bool last);

  using Clock = std::chrono::steady_clock;
  std::string what_, note_;
  std::size_t total_, before_, done_;
  Style style_;
  Clock::time_point start_ = Clock::now(), last_drawn_{};
  bool finished_ = false;
};

}  // namespace powbench::host
