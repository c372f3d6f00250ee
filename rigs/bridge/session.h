#pragma once

#include <map>
#include <memory>
#include <optional>
#include <string>
#include <vector>

#include "firmware/iiod/words.h"
#include "rigs/bridge/inbox.h"
#include "rigs/bridge/layout.h"
#include "rigs/bridge/line.h"

namespace powbench::rigs::bridge {

class Session;

/// What all clients of a bridge share.
struct Hub {
  explicit Hub(boost::asio::io_context& context, const BridgeOptions& o)
      : io(context), options(o), line(io, o) {}

  const DeviceLayout* find(std::string_view id_or_name) const;
  /// How long a READBUF may wait, ms; 0: for ever. Nothing on the wire links the connection that sets the
  /// time-out to the one that reads, so the shortest of all holds: an answer that is early is an answer, one
  /// that is late is taken for the answer to something else.
  std::uint32_t timeout_ms() const;
  void close_sessions();

  boost::asio::io_context& io;
  BridgeOptions options;
  Line line;
  std::vector<DeviceLayout> devices;
  std::map<std::string, const Session*> owners;  ///< by device id: who has its buffer open
  std::vector<std::shared_ptr<Session>> sessions;
};

/// One TCP client: requests in, answers out, in order.
class Session : public std::enable_shared_from_this<Session> {
 public:
  Session(Hub& hub, boost::asio::ip::tcp::socket socket);
  void start();
  void close();
  std::optional<std::uint32_t> timeout_ms() const { return timeout_ms_; }

 private:
  template <class T>
  using awaitable = boost::asio::awaitable<T>;
  using Words = firmware::iiod::Words;

  /// A buffer that this client has open.
  struct Reader {
    std::string device;
    std::uint32_t mask = 0;
    std::size_t step = 0;  ///< bytes a scan
    bool lost = false;     ///< an answer was lost: nobody knows where the board stands
  };

  awaitable<void> receive();
  awaitable<void> serve();
  awaitable<bool> next_line(std::string& line);
  awaitable<void> run(std::string line);
  awaitable<void> forward(std::string line, Expected::Shape shape);
  awaitable<void> write(std::string line, Words words);
  awaitable<void> open(std::string line, Words words);
  awaitable<void> close_reader();
  awaitable<void> readbuf(Words words);
  awaitable<std::int64_t> read_piece(std::size_t& owed, bool& mask_sent);
  awaitable<void> send(std::string bytes);
  awaitable<void> send_number(std::int64_t value);

  Hub& hub_;
  boost::asio::ip::tcp::socket socket_;
  Inbox inbox_;
  std::optional<Reader> reader_;
  std::optional<std::uint32_t> timeout_ms_;
};

}  // namespace powbench::rigs::bridge
