#pragma once

#include <chrono>
#include <cstdint>
#include <string>

namespace powbench::rigs {

/// Where a bridge stands. The times are what a board at 921600 baud needs, with room.
struct BridgeOptions {
  std::string port;            ///< "/dev/ttyACM0"
  unsigned baud = 2'000'000;   ///< 8 data bits, no parity, 1 stop bit
  std::string address;         ///< loopback address to serve on; "" = the first free one from 127.0.0.2 on
  std::string token_prefix{};  ///< what a lease claimed through this bridge must begin with; empty: anything
  std::uint16_t tcp_port = 30431;  ///< libiio 0.24 knows no other when it clones a context

  std::chrono::milliseconds silence{500};  ///< an answer that pauses for longer is lost
  std::chrono::milliseconds quiet{50};     ///< a line silent for this long is drained
  std::chrono::milliseconds probe{300};   ///< a board answers VERSION within this time, at one of three tries
  std::chrono::milliseconds check{2000};  ///< an idle line is asked this often whether it is the same board
  std::chrono::milliseconds poll{10};     ///< between two looks for samples
  std::chrono::milliseconds handover{
      200};  ///< a second reader waits this long for the first one's end: one that was
             ///< killed is gone within this time
};

}  // namespace powbench::rigs
