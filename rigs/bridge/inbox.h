#pragma once

#include <utility>  // ahead of Asio: 1.74 forgets it under C++20

#include <boost/asio.hpp>
#include <chrono>
#include <string>

namespace powbench::rigs::bridge {

// In the coroutines of this folder every argument with a destructor has a name: gcc 12 destroys a temporary
// that stands inside a co_await expression twice.

/// Pauses; returns early when the timer is cancelled.
inline boost::asio::awaitable<void> pause(boost::asio::steady_timer& timer, std::chrono::milliseconds limit) {
  boost::system::error_code ignored;
  timer.expires_after(limit);
  co_await timer.async_wait(boost::asio::redirect_error(boost::asio::use_awaitable, ignored));
}

/// Bytes that have arrived from a port or a socket, and one coroutine that waits for them.
struct Inbox {
  explicit Inbox(boost::asio::io_context& io) : signal(io) {}

  /// Returns when something arrives, the other end goes away, or the limit is over.
  boost::asio::awaitable<void> change(std::chrono::milliseconds limit) {
    if (!closed) co_await pause(signal, limit);
  }
  void put(const char* data, std::size_t n) {
    bytes.append(data, n);
    signal.cancel();
  }
  void close() {
    closed = true;
    signal.cancel();
  }

  std::string bytes;
  bool closed = false;
  boost::asio::steady_timer signal;
};

}  // namespace powbench::rigs::bridge
