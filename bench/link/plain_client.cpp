#include "bench/link/plain_client.h"

#include <arpa/inet.h>
#include <netinet/in.h>
#include <netinet/tcp.h>
#include <poll.h>
#include <sys/socket.h>
#include <unistd.h>

#include <stdexcept>

namespace powbench::bench {

namespace {
constexpr int patience_ms = 20'000;
}  // namespace

PlainClient::PlainClient(const std::string& address)
    : socket_(socket(AF_INET, SOCK_STREAM | SOCK_CLOEXEC, 0)) {
  sockaddr_in to{};
  to.sin_family = AF_INET;
  to.sin_port = htons(30431);
  inet_pton(AF_INET, address.c_str(), &to.sin_addr);
  if (connect(socket_, reinterpret_cast<const sockaddr*>(&to), sizeof to) != 0) {
    close(socket_);
    throw std::runtime_error("nothing listens on " + address);
  }
  const int yes = 1;
  setsockopt(socket_, IPPROTO_TCP, TCP_NODELAY, &yes, sizeof yes);
}

PlainClient::~PlainClient() {
  close(socket_);
}

bool PlainClient::say(const std::string& bytes) const {
  return send(socket_, bytes.data(), bytes.size(), MSG_NOSIGNAL) == static_cast<ssize_t>(bytes.size());
}

std::size_t PlainClient::push(const std::string& bytes) const {
  const ssize_t n = send(socket_, bytes.data(), bytes.size(), MSG_NOSIGNAL | MSG_DONTWAIT);
  return n > 0 ? static_cast<std::size_t>(n) : 0;
}

bool PlainClient::receive(int limit_ms) {
  pollfd p{socket_, POLLIN, 0};
  if (poll(&p, 1, limit_ms) <= 0) return false;
  char data[65536];
  const ssize_t n = recv(socket_, data, sizeof data, 0);
  if (n <= 0) return false;
  buffer_.append(data, static_cast<std::size_t>(n));
  return true;
}

std::string PlainClient::line() {
  while (buffer_.find('\n') == std::string::npos)
    if (!receive(patience_ms)) return gone;
  const std::size_t end = buffer_.find('\n');
  const std::string text = buffer_.substr(0, end);
  buffer_.erase(0, end + 1);
  return text;
}

std::string PlainClient::read(const std::string& what) {
  say("READ " + what + "\r\n");
  const std::string n = line();
  if (n.starts_with("-") || n == gone) return n;
  const std::size_t length = std::stoul(n) + 1;
  while (buffer_.size() < length)
    if (!receive(patience_ms)) return gone;
  const std::string value = buffer_.substr(0, length);
  buffer_.erase(0, length);
  return value.substr(0, value.find('\0'));
}

std::string PlainClient::write(const std::string& what, const std::string& value) {
  say("WRITE " + what + " " + std::to_string(value.size()) + "\r\n" + value);
  return line();
}

bool PlainClient::hung_up(int ms) {
  pollfd p{socket_, POLLIN, 0};
  while (poll(&p, 1, ms) > 0) {
    char data[65536];
    if (recv(socket_, data, sizeof data, 0) <= 0) return true;
  }
  return false;
}

}  // namespace powbench::bench
