#pragma once

#include <arpa/inet.h>
#include <netinet/in.h>
#include <netinet/tcp.h>
#include <poll.h>
#include <sys/socket.h>
#include <unistd.h>

#include <stdexcept>
#include <string>

namespace powbench::test {

/// An IIOD client that says exactly what it is told, byte by byte.
class RawClient {
 public:
  explicit RawClient(const std::string& address) : socket_(socket(AF_INET, SOCK_STREAM, 0)) {
    sockaddr_in to{};
    to.sin_family = AF_INET;
    to.sin_port = htons(30431);
    inet_pton(AF_INET, address.c_str(), &to.sin_addr);
    if (connect(socket_, reinterpret_cast<const sockaddr*>(&to), sizeof to) != 0)
      throw std::runtime_error("nothing listens on " + address);
    const int yes = 1;
    setsockopt(socket_, IPPROTO_TCP, TCP_NODELAY, &yes, sizeof yes);
  }
  ~RawClient() { hang_up(); }
  RawClient(const RawClient&) = delete;
  RawClient& operator=(const RawClient&) = delete;

  void hang_up() {
    if (socket_ >= 0) close(socket_);
    socket_ = -1;
  }
  void say(const std::string& bytes) const { send(socket_, bytes.data(), bytes.size(), MSG_NOSIGNAL); }

  /// The next line of an answer, without its end; "(gone)" when the server has hung up. A server that says nothing for
  /// a minute hangs: the answer is "(silent)".
  std::string line() {
    while (buffer_.find('\n') == std::string::npos)
      if (const char* trouble = receive(patience_ms)) return trouble;
    const std::size_t end = buffer_.find('\n');
    const std::string text = buffer_.substr(0, end);
    buffer_.erase(0, end + 1);
    return text;
  }
  std::string bytes(std::size_t n) {
    while (buffer_.size() < n)
      if (const char* trouble = receive(patience_ms)) return trouble;
    const std::string text = buffer_.substr(0, n);
    buffer_.erase(0, n);
    return text;
  }
  /// Nothing has arrived so far. What the server owes for certain by now, another client's answer proves.
  bool silent() { return buffer_.empty() && receive(0) == std::string("(silent)"); }
  std::string ask(const std::string& request) {
    say(request + "\r\n");
    return line();
  }
  /// Value of an attribute, or the error number.
  std::string read(const std::string& what) {
    const std::string n = ask("READ " + what);
    if (n.starts_with("-") || n.starts_with("(")) return n;
    const std::string value = bytes(static_cast<std::size_t>(std::stoi(n)) + 1);
    return value.substr(0, value.find('\0'));
  }
  /// Claims the bench for as long as any test lasts.
  std::string own() { return write("iio:device1 lease", "t 3600000 test"); }
  /// A command of the owner: writes `value` with the token of own().
  std::string command(const std::string& what, const std::string& value) { return write(what, value + " t"); }
  std::string write(const std::string& what, const std::string& value) {
    say("WRITE " + what + " " + std::to_string(value.size()) + "\r\n" + value);
    return line();
  }

 private:
  const char* receive(int limit_ms) {
    pollfd p{socket_, POLLIN, 0};
    if (poll(&p, 1, limit_ms) <= 0) return "(silent)";
    char data[65536];
    const ssize_t n = recv(socket_, data, sizeof data, 0);
    if (n <= 0) return "(gone)";
    buffer_.append(data, static_cast<std::size_t>(n));
    return nullptr;
  }

  static constexpr int patience_ms = 60'000;  // far longer than any answer takes: it only ends a hang

  int socket_;
  std::string buffer_;
};

}  // namespace powbench::test
