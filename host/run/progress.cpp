#include "host/run/progress.h"

#include <fmt/format.h>
#include <sys/ioctl.h>
#include <unistd.h>

#include <algorithm>
#include <cmath>
#include <cstdlib>

namespace powbench::host {

namespace {

int terminal_width() {
  winsize size{};
  if (ioctl(STDERR_FILENO, TIOCGWINSZ, &size) == 0 && size.ws_col > 20) return size.ws_col;
  return 80;
}

}  // namespace

Progress::Progress(std::string what, std::size_t total, Style style, std::size_t done)
    : what_(std::move(what)), total_(total), before_(done), done_(done), style_(style) {
  if (style_ == Style::automatic) {
    const char* term = std::getenv("TERM");
    const bool terminal = isatty(STDERR_FILENO) == 1 && term && std::string(term) != "dumb";
    style_ = terminal ? Style::bar : Style::lines;
  }
  if (style_ == Style::lines)
    fmt::print(stderr, "{}: {} to do{}\n", what_, total_ - before_,
               before_ > 0 ? fmt::format(", {} are there", before_) : "");
  last_drawn_ = Clock::now();
  if (style_ == Style::bar) draw(false);
}

Progress::~Progress() {
  finish();
}

std::string Progress::duration(double seconds) {
  if (seconds < 9.95) return fmt::format("{:.1f} s", std::max(seconds, 0.0));
  const auto whole = std::llround(seconds);
  if (whole < 60) return fmt::format("{} s", whole);
  if (whole < 3600) return fmt::format("{} min {:02} s", whole / 60, whole % 60);
  return fmt::format("{} h {:02} min", whole / 3600, whole % 3600 / 60);
}

void Progress::update(std::size_t done, const std::string& note) {
  done_ = done;
  note_ = note;
  const auto now = Clock::now();
  const auto wait = style_ == Style::bar ? std::chrono::milliseconds(50) : std::chrono::milliseconds(10'000);
  if (now - last_drawn_ < wait) return;
  last_drawn_ = now;
  draw(false);
}

void Progress::say(const std::string& message) {
  if (style_ == Style::bar) fmt::print(stderr, "\r\033[K");
  fmt::print(stderr, "{}\n", message);
  if (style_ == Style::bar) draw(false);
}

void Progress::finish() {
  if (finished_) return;
  finished_ = true;
  draw(true);
}

void Progress::draw(bool last) {
  if (style_ == Style::none) return;
  const double elapsed = std::chrono::duration<double>(Clock::now() - start_).count();
  std::string time = fmt::format("in {}", duration(elapsed));
  if (!last) {
    time =
        done_ == before_
            ? "..."
            : duration(elapsed / static_cast<double>(done_ - before_) * static_cast<double>(total_ - done_)) +
                  " to go";
  }
  if (style_ == Style::lines) {
    fmt::print(stderr, "{}: {} of {}, {}\n", what_, done_, total_, time);
    return;
  }
  const std::string head = fmt::format("{} ", what_);
  const std::string tail = fmt::format(" {}/{}  {}  {}", done_, total_, time, last ? "" : note_);
  const int room = std::clamp(terminal_width() - static_cast<int>(head.size() + tail.size()) - 3, 8, 32);
  const auto filled = static_cast<int>(total_ == 0 ? room : static_cast<std::size_t>(room) * done_ / total_);
  std::string line = head + "[" + std::string(static_cast<std::size_t>(filled), '=') +
                     std::string(static_cast<std::size_t>(room - filled), ' ') + "]" + tail;
  line.resize(std::min(line.size(), static_cast<std::size_t>(terminal_width() - 1)));
  fmt::print(stderr, "\r\033[K{}{}", line, last ? "\n" : "");
  std::fflush(stderr);
}

}  // namespace powbench::host
