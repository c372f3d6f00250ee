#pragma once

#include <cstdint>
#include <span>

#include "firmware/iiod/responder.h"

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
