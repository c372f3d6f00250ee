#pragma once

#include <cstddef>
#include <cstdint>
#include <string>
#include <string_view>

/// Answers of a board, taken apart as their bytes arrive. The line has no checksum, so everything that is
/// known about an answer beforehand is checked: what does not fit means that line and board are out of step.

namespace powbench::rigs::bridge {

/// What the answer to a request looks like.
struct Expected {
  enum class Shape : std::uint8_t {
    number,         ///< `<n>\n`: a success is exactly `count`
    text,           ///< `<n>\n<n bytes>\n`, or a negative number alone
    optional_text,  ///< the same, but 0 has no body
    line,           ///< one line of text
    samples,  ///< `<k>\n<mask>\n<k bytes>`, then further `<k>\n<k bytes>` up to `count`, or a number <= 0
  };
  Shape shape = Shape::number;
  std::size_t count = 0;
  std::uint32_t mask = 0;
};

struct Reply {
  std::int64_t status = 0;  ///< the (last) number; negative: -errno
  std::string body;         ///< text, or samples without their framing
  bool ended = false;       ///< samples: the board stopped short with a 0
  bool lost = false;        ///< no answer that could be understood; the status is -110
};

class ReplyReader {
 public:
  explicit ReplyReader(const Expected& expected);

  /// Takes bytes until the answer is complete or wrong; returns how many were taken.
  std::size_t feed(std::string_view bytes);
  bool done() const { return state_ == State::done; }
  bool bad() const { return state_ == State::bad; }
  Reply& reply() { return reply_; }

 private:
  enum class State : std::uint8_t { number, mask, bytes, line_end, done, bad };
  void take_line();
  void take_number(std::int64_t value);

  Expected expected_;
  State state_ = State::number;
  std::string line_;
  std::size_t owed_ = 0;  ///< bytes of the body still to come
  bool mask_seen_ = false;
  Reply reply_;
};

}  // namespace powbench::rigs::bridge
