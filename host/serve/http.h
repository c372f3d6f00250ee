#pragma once

#include <cstdint>
#include <functional>
#include <memory>
#include <string>

#include "host/serve/message.h"

namespace powbench::host {

/// Where the two kinds of WebSocket are.
inline constexpr const char *state_stream = "/api/live", *record_stream = "/api/scope";

/// HTTP/1.1 and two kinds of WebSocket, which only send: the newest state, and the newest record, whenever it has
/// changed. One thread for the sockets, one for stops, two for everything else. Who comes when all places are taken
/// can still stop; anything else gets 503.
class HttpServer {
 public:
  struct Handlers {
    std::function<Reply(const Request&)> answer;
    std::function<bool(const Request&)> is_stop;  ///< answered by a thread of its own
    std::function<Reply(const Request&)> listen;  ///< status 200: the client may have the state
    std::function<std::string()> state;
    std::function<std::shared_ptr<const std::string>()> record = [] {
      return nullptr;
    };  ///< newest; nothing: none yet
  };
  static constexpr std::size_t most_clients = 2000, largest_body = 262'144;

  /// Listens at once on "127.0.0.1:8080"; port 0: any free one. Throws RigError-like std::runtime_error with one
  /// sentence.
  HttpServer(const std::string& address, std::uint16_t port, Handlers);
  ~HttpServer();
  HttpServer(const HttpServer&) = delete;
  HttpServer& operator=(const HttpServer&) = delete;

  std::uint16_t port() const;
  /// The state has changed. From any thread.
  void changed();
  /// There is a newer record, and a state that names it: sent at once. From any thread.
  void recorded();
  /// Serves until stop() from another thread, or SIGINT / SIGTERM; afterwards no handler runs any more.
  void serve(bool until_interrupted);
  void stop();

 private:
  struct Impl;
  std::unique_ptr<Impl> impl_;
};

}  // namespace powbench::host
