#include "rigs/bridge/reply.h"

#include <algorithm>

#include "firmware/iiod/words.h"

namespace powbench::rigs::bridge {

namespace {
constexpr std::size_t longest_line = 64;        // a number, a mask or a version
constexpr std::int64_t largest_errno = 4095;    // as in the Linux kernel
constexpr std::int64_t longest_text = 1 << 20;  // a description of a context has some 10 kB
}  // namespace

ReplyReader::ReplyReader(const Expected& expected) : expected_(expected) {}

std::size_t ReplyReader::feed(std::string_view bytes) {
  std::size_t used = 0;
  while (used < bytes.size() && !done() && !bad()) {
    if (state_ == State::bytes) {
      const std::size_t n = std::min(owed_, bytes.size() - used);
      reply_.body.append(bytes.substr(used, n));
      used += n;
      owed_ -= n;
      if (owed_ > 0) break;
      if (expected_.shape != Expected::Shape::samples)
        state_ = State::line_end;
      else
        state_ = reply_.body.size() == expected_.count ? State::done : State::number;
      continue;
    }
    const char c = bytes[used++];
    if (state_ == State::line_end)
      state_ = c == '\n' ? State::done : State::bad;
    else if (c == '\n')
      take_line();
    else if (line_.size() < longest_line)
      line_ += c;
    else
      state_ = State::bad;
  }
  return used;
}

void ReplyReader::take_line() {
  if (state_ == State::mask) {
    std::uint32_t mask = 0;
    state_ = firmware::iiod::parse_mask(line_, mask) && mask == expected_.mask ? State::bytes : State::bad;
    mask_seen_ = true;
  } else if (expected_.shape == Expected::Shape::line) {
    reply_.body = line_;
    state_ = State::done;
  } else if (const auto value = firmware::parse_int(line_)) {
    take_number(*value);
  } else {
    state_ = State::bad;
  }
  line_.clear();
}

void ReplyReader::take_number(std::int64_t value) {
  using Shape = Expected::Shape;
  reply_.status = value;
  if (value < 0) {
    state_ = value < -largest_errno ? State::bad : State::done;
    return;
  }
  switch (expected_.shape) {
    case Shape::number:
      state_ = value == static_cast<std::int64_t>(expected_.count) ? State::done : State::bad;
      return;
    case Shape::optional_text:
    case Shape::text:
      if (value == 0 && expected_.shape == Shape::optional_text) {
        state_ = State::done;
        return;
      }
      owed_ = static_cast<std::size_t>(value);
      state_ = value > longest_text ? State::bad : (value == 0 ? State::line_end : State::bytes);
      return;
    case Shape::samples:
      if (value == 0) {
        reply_.ended = true;
        state_ = State::done;
        return;
      }
      owed_ = static_cast<std::size_t>(value);
      // never more than was asked for
      if (owed_ > expected_.count - reply_.body.size())
        state_ = State::bad;
      else
        state_ = mask_seen_ ? State::bytes : State::mask;
      return;
    case Shape::line:
      break;
  }
  state_ = State::bad;
}

}  // namespace powbench::rigs::bridge
