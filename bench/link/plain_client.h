#pragma once

#include <string>

namespace powbench::bench {

/// An IIOD client that says what it is told, on a connection of its own. A server that answers nothing within 20 s, or
/// hangs up, is "(gone)".
class PlainClient {
 public:
  /// What a read or a line gives when the server has hung up or says nothing for 20 s.
  inline static const std::string gone = "(gone)";

  /// Throws std::runtime_error when nothing listens there.
  explicit PlainClient(const std::string& address);
  ~PlainClient();
  PlainClient(const PlainClient&) = delete;
  PlainClient& operator=(const PlainClient&) = delete;

  /// False: the connection is closed.
  bool say(const std::string& bytes) const;
  /// As much as the server takes without waiting; the bytes it took.
  std::size_t push(const std::string& bytes) const;
  std::string line();
  /// Value of an attribute, or the error number.
  std::string read(const std::string& what);
  std::string write(const std::string& what, const std::string& value);
  /// The server has hung up, or does so within `ms`.
  bool hung_up(int ms);

 private:
  bool receive(int limit_ms);

  int socket_;
  std::string buffer_;
};

}  // namespace powbench::bench
