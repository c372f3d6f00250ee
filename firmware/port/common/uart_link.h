#pragma once

#include <array>
#include <cstdint>
#include <span>
#include <string_view>

#include "firmware/iiod/responder.h"
#include "firmware/iiod/words.h"

/// One connection over a line that is never closed: the responder behind a serial port.

namespace powbench::firmware::port {

class UartLink {
 public:
  explicit UartLink(iiod::Responder& responder) : responder_(responder) {}

  /// Takes all bytes and writes all answers. A READBUF that finds nothing is answered -EAGAIN at once, so that a client
  /// that waits for a record does not keep the line from the one that fires; EXIT starts a new connection.
  void take(std::span<const std::uint8_t> bytes, iiod::ByteSink& out) {
    using Status = iiod::Connection::Status;
    while (!bytes.empty()) {
      bytes = bytes.subspan(responder_.feed(connection_, bytes, out));
      if (connection_.status() == Status::pending) responder_.expire(connection_, iiod::eagain, out);
      if (connection_.status() == Status::closed) connection_ = {};
    }
  }

  /// Bytes were lost or garbled on the line: what was half received is forgotten, an open buffer with it.
  void line_error() {
    connection_ = {};
    ++line_errors_;
  }
  std::uint32_t line_errors() const { return line_errors_; }

 private:
  iiod::Responder& responder_;
  iiod::Connection connection_;
  std::uint32_t line_errors_ = 0;
};

/// Finds the request to abort among the bytes of a line, whatever stands before it: the value of a request has no
/// line end, and what a damaged line left behind none either. `WRITE DEVICE abort N` and, behind its line end, the
/// value 1. The request itself is answered in its turn; abort may come twice.
class AbortScan {
 public:
  /// True when the byte completes the request.
  bool take(std::uint8_t byte) {
    const char c = static_cast<char>(byte);
    if (value_next_) {
      value_next_ = false;
      if (c == '1') return true;
    }
    if (c != '\n') {
      tail_[length_++ % tail_.size()] = c;
      return false;
    }
    value_next_ = asks_to_abort();
    length_ = 0;
    return false;
  }

 private:
  bool asks_to_abort() const {
    std::array<char, 48> line{};
    const std::size_t n = length_ < tail_.size() ? length_ : tail_.size();
    for (std::size_t i = 0; i < n; ++i) line[i] = tail_[(length_ - n + i) % tail_.size()];
    const std::string_view text(line.data(), n);
    constexpr std::string_view verb = "WRITE ", name = " abort ";
    const std::size_t end = text.find(name);
    if (end == text.npos) return false;
    for (std::size_t i = 0; i + verb.size() <= end; ++i)
      if (iiod::same_word({line.data() + i, verb.size()}, verb)) return true;
    return false;
  }

  std::array<char, 48> tail_{};  ///< the last characters of the line
  std::size_t length_ = 0;
  bool value_next_ = false;
};

/// Reads a circular buffer that a peripheral fills. `written`: its write position, 0 .. size - 1. Gives the bytes that
/// are new since the last call, in one piece; at the end of the buffer a second call gives the rest.
class RingReader {
 public:
  std::span<const std::uint8_t> fresh(std::span<const std::uint8_t> ring, std::size_t written) {
    const std::size_t from = read_, to = written >= read_ ? written : ring.size();
    read_ = to == ring.size() ? 0 : to;
    return ring.subspan(from, to - from);
  }
  void skip_to(std::size_t written) { read_ = written; }

 private:
  std::size_t read_ = 0;
};

}  // namespace powbench::firmware::port
