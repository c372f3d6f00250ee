#pragma once

#include <deque>
#include <functional>
#include <optional>
#include <string>

#include "rigs/bridge/inbox.h"
#include "rigs/bridge/options.h"
#include "rigs/bridge/reply.h"

namespace powbench::rigs::bridge {

/// The serial line to one board. One request at a time: whoever asks next waits until the whole answer of the
/// one before is in. When an answer is late or garbled, the line is drained and the board probed before
/// anything else is asked.
class Line {
 public:
  /// Opens the port for this process alone; throws RigError.
  Line(boost::asio::io_context& io, const BridgeOptions& options);

  /// Finds the board and reads its description. Throws RigError.
  boost::asio::awaitable<void> start();

  /// One whole transaction. When the line fails, the status is -110 and failures() has counted on; while a
  /// board does not answer at all, -110 comes at once.
  boost::asio::awaitable<Reply> ask(std::string request, Expected expected);

  /// Compares the board's description with the one known, soon: something it said was odd.
  void doubt() { doubted_ = true; }

  const std::string& description() const { return description_; }
  const std::string& version() const { return version_; }
  int failures() const { return failures_; }  ///< answers that were late or garbled
  void close();

  std::function<void()> on_new_board = [] {};              ///< the description is another one
  std::function<void(std::string)> on_lost = [](auto) {};  ///< the port is gone
  std::function<bool()> in_use = [] { return true; };  ///< somebody cares whether the board is still there

 private:
  using Clock = std::chrono::steady_clock;
  struct Waiter {
    explicit Waiter(boost::asio::io_context& io) : timer(io) {}
    boost::asio::steady_timer timer;
    bool granted = false;
  };

  boost::asio::awaitable<bool> take_turn();
  void end_turn();
  void refuse_waiting();
  boost::asio::awaitable<bool> send(const std::string& bytes);
  boost::asio::awaitable<std::optional<Reply>> transfer(std::string request, Expected expected,
                                                        std::chrono::milliseconds silence);
  boost::asio::awaitable<bool> probe();
  boost::asio::awaitable<void> recover(int tries);
  boost::asio::awaitable<void> recover_and_end_turn();
  boost::asio::awaitable<bool> check_board();
  boost::asio::awaitable<void> receive();
  void port_is_gone(const boost::system::error_code& why);
  boost::asio::awaitable<void> watch();

  boost::asio::io_context& io_;
  BridgeOptions options_;
  boost::asio::serial_port port_;
  boost::asio::steady_timer write_limit_, watch_timer_;
  Inbox inbox_;
  std::deque<Waiter*> waiting_;
  bool busy_ = false, answering_ = false, dead_ = false, doubted_ = false, closed_ = false;
  int writes_ = 0, failures_ = 0;
  Clock::time_point last_answer_{};
  std::string description_, version_;
};

}  // namespace powbench::rigs::bridge
