#pragma once

#include <catch2/catch.hpp>
#include <functional>
#include <string>

#include "bench/uart_board.h"
#include "rigs/bridge/bridge.h"
#include "tests/rigs/raw_client.h"
#include "tests/waiting.h"

namespace powbench::test {

/// A short record, so that a slow line does not make slow tests: 4000 scans, 64 000 bytes.
inline rigs::SimRigConfig short_record() {
  rigs::SimRigConfig config;
  config.record_length = 0.040;
  config.pretrigger = 0.010;
  return config;
}

/// A board on a paced line, and the bridge in front of it.
struct Desk {
  explicit Desk(double baud = 2e6, std::chrono::milliseconds check = std::chrono::milliseconds(2000))
      : board(short_record(), {}, baud), bridge(options(board.port(), baud, check)) {}

  static rigs::BridgeOptions options(const std::string& port, double baud, std::chrono::milliseconds check) {
    rigs::BridgeOptions o;
    o.port = port;
    o.baud = static_cast<unsigned>(baud);
    o.check = check;
    // a board that shares a busy machine may stand still for longer than a real one; no test is about these times
    o.silence = std::chrono::milliseconds(1500);
    o.probe = std::chrono::milliseconds(1000);
    return o;
  }

  explicit Desk(const std::function<void(rigs::BridgeOptions&)>& adjust)
      : board(short_record(), {}, 2e6), bridge([&] {
          auto o = options(board.port(), 2e6, std::chrono::milliseconds(2000));
          adjust(o);
          return o;
        }()) {}

  /// Fires one shot through a connection of its own and waits until its record is there.
  void shoot() const {
    RawClient c(bridge.address());
    REQUIRE(c.own() == "14");
    REQUIRE(c.command("iio:device1 arm", "1") == "3");
    REQUIRE(c.command("iio:device1 fire", "1") == "3");
    wait_until("a captured shot", [&] { return c.read("iio:device1 state") == "captured"; });
  }

  bench::UartBoard board;
  rigs::LocalBridge bridge;
};

inline std::size_t count(const std::string& text, const std::string& word) {
  std::size_t n = 0;
  for (std::size_t at = text.find(word); at != std::string::npos; at = text.find(word, at + 1)) ++n;
  return n;
}

}  // namespace powbench::test
