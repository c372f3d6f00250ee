#pragma once

#include <arpa/inet.h>
#include <netinet/in.h>
#include <poll.h>
#include <sys/socket.h>
#include <unistd.h>

#include <cstdint>
#include <functional>
#include <list>
#include <mutex>
#include <stdexcept>
#include <string>
#include <thread>
#include <utility>

/// A line with faults between client and rig: forwards bytes on loopback; holds an answer back, cuts the line or acts
/// at a chosen byte. Nothing in it depends on time: a fault happens at a byte or when the test says so.
namespace powbench::test {

class Proxy {
 public:
  explicit Proxy(std::string target) : target_(std::move(target)) {
    for (int host = 100; host < 250 && listener_ < 0; ++host) try_listen("127.0.1." + std::to_string(host));
    if (listener_ < 0) throw std::runtime_error("no loopback address is free for the proxy");
    acceptor_ = std::thread([this] { accept_loop(); });
  }
  ~Proxy() {
    {
      const std::lock_guard hold(mutex_);
      stop_ = true;
      hang_up_all();
    }
    shutdown(listener_, SHUT_RDWR);
    acceptor_.join();
    for (auto& l : links_) {
      l.thread.join();
      close(l.client);
      close(l.server);
    }
    close(listener_);
  }
  Proxy(const Proxy&) = delete;
  Proxy& operator=(const Proxy&) = delete;

  const std::string& address() const { return address_; }

  /// The next answer is late: it stays in the line until its client has hung up.
  void hold_next_answer() {
    const std::lock_guard lock(mutex_);
    hold_next_ = true;
  }
  /// Bytes of answers that have arrived from the rig, over all connections.
  std::uint64_t answered() const {
    const std::lock_guard lock(mutex_);
    return answered_;
  }
  /// Runs `action` once, when the n-th byte of answers from now on has arrived and before the piece that holds it goes
  /// to the client. The client cannot have read that byte; the action may call cut() and refuse().
  void at_answer_byte(std::uint64_t n, std::function<void()> action) {
    const std::lock_guard lock(mutex_);
    action_at_ = answered_ + n;
    action_ = std::move(action);
  }
  /// Cuts every connection, at once; new ones are refused until mended.
  void cut(bool broken) {
    const std::lock_guard lock(mutex_);
    refusals_ = broken ? forever : 0;
    if (broken) hang_up_all();
  }
  /// Cuts every connection, at once; the next `n` new ones are refused, later ones are not.
  void cut_and_refuse(int n) {
    const std::lock_guard lock(mutex_);
    refusals_ = n;
    hang_up_all();
  }

 private:
  static constexpr int forever = -1;
  struct Link {
    int client, server;
    std::thread thread;
  };

  static sockaddr_in endpoint(const std::string& address) {
    sockaddr_in a{};
    a.sin_family = AF_INET;
    a.sin_port = htons(30431);
    inet_pton(AF_INET, address.c_str(), &a.sin_addr);
    return a;
  }

  void try_listen(const std::string& address) {
    const int s = socket(AF_INET, SOCK_STREAM | SOCK_CLOEXEC, 0);
    const int yes = 1;
    setsockopt(s, SOL_SOCKET, SO_REUSEADDR, &yes, sizeof yes);
    const sockaddr_in a = endpoint(address);
    if (bind(s, reinterpret_cast<const sockaddr*>(&a), sizeof a) != 0 || listen(s, 8) != 0) {
      close(s);
      return;
    }
    listener_ = s;
    address_ = address;
  }

  bool refused() {
    const std::lock_guard lock(mutex_);
    if (refusals_ > 0) return refusals_-- > 0;
    return refusals_ == forever;
  }

  void hang_up_all() {
    for (const auto& l : links_)
      for (const int s : {l.client, l.server}) shutdown(s, SHUT_RDWR);
  }

  void accept_loop() {
    for (;;) {
      const int client = accept4(listener_, nullptr, nullptr, SOCK_CLOEXEC);
      if (client < 0) return;  // the destructor
      const int server = socket(AF_INET, SOCK_STREAM | SOCK_CLOEXEC, 0);
      const sockaddr_in a = endpoint(target_);
      if (refused() || connect(server, reinterpret_cast<const sockaddr*>(&a), sizeof a) != 0) {
        close(client);
        close(server);
        continue;
      }
      const std::lock_guard lock(mutex_);
      links_.push_back({client, server, {}});
      links_.back().thread = std::thread([this, client, server] { pump(client, server); });
      if (stop_) hang_up_all();
    }
  }

  /// An answer of n bytes has arrived: counts it, acts if its byte is in it, waits if it is the one to be late.
  void arrived(std::size_t n, int client) {
    std::function<void()> action;
    bool late = false;
    {
      const std::lock_guard lock(mutex_);
      late = std::exchange(hold_next_, false);
      answered_ += n;
      if (action_ && answered_ >= action_at_) action.swap(action_);
    }
    if (action) action();
    pollfd hung_up{client, POLLRDHUP, 0};
    while (late && poll(&hung_up, 1, -1) <= 0) {
    }
  }

  /// The sockets stay open until the destructor, so that a number is never another socket's.
  void pump(int client, int server) {
    char bytes[65536];
    for (bool gone = false; !gone;) {
      pollfd p[2] = {{client, POLLIN, 0}, {server, POLLIN, 0}};
      if (poll(p, 2, -1) <= 0) continue;
      for (const int side : {0, 1}) {
        if (p[side].revents == 0) continue;
        const ssize_t n = recv(p[side].fd, bytes, sizeof bytes, 0);
        if ((gone = n <= 0)) break;
        if (side == 1) arrived(static_cast<std::size_t>(n), client);
        send(side == 0 ? server : client, bytes, static_cast<std::size_t>(n), MSG_NOSIGNAL);
      }
    }
    for (const int s : {client, server}) shutdown(s, SHUT_RDWR);
  }

  std::string target_, address_;
  int listener_ = -1;
  mutable std::mutex mutex_;  // what follows is shared
  bool stop_ = false, hold_next_ = false;
  int refusals_ = 0;
  std::uint64_t answered_ = 0, action_at_ = 0;
  std::function<void()> action_;
  std::list<Link> links_;
  std::thread acceptor_;
};

}  // namespace powbench::test
