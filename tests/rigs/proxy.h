#pragma once

#include <arpa/inet.h>
#include <netinet/in.h>
#include <poll.h>
#include <sys/socket.h>
#include <unistd.h>

#include <atomic>
#include <chrono>
#include <mutex>
#include <stdexcept>
#include <string>
#include <thread>
#include <vector>

/// A line with faults between client and rig: forwards bytes on loopback, stalls or cuts on request. Ends by
/// itself.
namespace powbench::test {

class Proxy {
 public:
  explicit Proxy(std::string target) : target_(std::move(target)) {
    for (int host = 100; host < 250 && listener_ < 0; ++host) try_listen("127.0.1." + std::to_string(host));
    if (listener_ < 0) throw std::runtime_error("no loopback address is free for the proxy");
    acceptor_ = std::thread([this] { accept_loop(); });
  }
  ~Proxy() {
    stop_ = true;
    acceptor_.join();
    for (auto& t : pumps_) t.join();
    close(listener_);
  }

  const std::string& address() const { return address_; }
  /// The next answer is held back for this long, once.
  void stall_next_answer(std::chrono::milliseconds t) { stall_ms_ = static_cast<int>(t.count()); }
  /// Cuts every connection and refuses new ones until mended.
  void cut(bool broken) { broken_ = broken; }

 private:
  static sockaddr_in endpoint(const std::string& address) {
    sockaddr_in a{};
    a.sin_family = AF_INET;
    a.sin_port = htons(30431);
    inet_pton(AF_INET, address.c_str(), &a.sin_addr);
    return a;
  }

  void try_listen(const std::string& address) {
    const int s = socket(AF_INET, SOCK_STREAM, 0);
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

  static bool readable(int fd) {
    pollfd p{fd, POLLIN, 0};
    return poll(&p, 1, 20) > 0;
  }

  void accept_loop() {
    while (!stop_) {
      if (!readable(listener_)) continue;
      const int client = accept(listener_, nullptr, nullptr);
      if (client < 0) continue;
      const int server = socket(AF_INET, SOCK_STREAM, 0);
      const sockaddr_in a = endpoint(target_);
      if (broken_ || connect(server, reinterpret_cast<const sockaddr*>(&a), sizeof a) != 0) {
        close(client);
        close(server);
        continue;
      }
      pumps_.emplace_back([this, client, server] { pump(client, server); });
    }
  }

  void pump(int client, int server) {
    char bytes[65536];
    while (!stop_ && !broken_) {
      pollfd p[2] = {{client, POLLIN, 0}, {server, POLLIN, 0}};
      if (poll(p, 2, 20) <= 0) continue;
      bool gone = false;
      for (const int side : {0, 1}) {
        if ((p[side].revents & (POLLIN | POLLHUP)) == 0) continue;
        const ssize_t n = recv(p[side].fd, bytes, sizeof bytes, 0);
        if (n <= 0) {
          gone = true;
          break;
        }
        if (side == 1) std::this_thread::sleep_for(std::chrono::milliseconds(stall_ms_.exchange(0)));
        send(side == 0 ? server : client, bytes, static_cast<std::size_t>(n), MSG_NOSIGNAL);
      }
      if (gone) break;
    }
    close(client);
    close(server);
  }

  std::string target_, address_;
  int listener_ = -1;
  std::atomic<bool> stop_ = false, broken_ = false;
  std::atomic<int> stall_ms_ = 0;
  std::thread acceptor_;
  std::vector<std::thread> pumps_;
};

}  // namespace powbench::test
