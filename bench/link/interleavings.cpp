#include <arpa/inet.h>
#include <netinet/in.h>
#include <netinet/tcp.h>
#include <poll.h>
#include <sys/socket.h>
#include <unistd.h>

#include <array>
#include <chrono>
#include <condition_variable>
#include <mutex>
#include <stdexcept>
#include <thread>

#include "bench/link/link_trials.h"
#include "core/phase.h"
#include "core/random.h"
#include "rigs/iio_rig.h"
#include "rigs/iiod_server.h"

/// Two hosts on one rig, their requests in an order that a seed fixes.

namespace powbench::bench {
namespace {

/// Lets one of several hosts take its next step, as a seeded schedule has it: each waits at the gate until all that are
/// still under way wait there too, then one goes on.
class Turns {
 public:
  Turns(int hosts, std::uint64_t seed)
      : random_(seed), waiting_(static_cast<std::size_t>(hosts), false), left_(hosts) {}

  void wait(int host) {
    std::unique_lock hold(mutex_);
    waiting_[static_cast<std::size_t>(host)] = true;
    ++here_;
    choose();
    changed_.wait(hold, [&] { return !waiting_[static_cast<std::size_t>(host)]; });
  }
  void leave() {
    const std::lock_guard hold(mutex_);
    --left_;
    choose();
  }

 private:
  void choose() {
    if (here_ < left_ || here_ == 0) return;
    for (auto skip = random_.below(static_cast<std::uint64_t>(here_));;)
      for (std::size_t i = 0; i < waiting_.size(); ++i)
        if (waiting_[i] && skip-- == 0) {
          waiting_[i] = false;
          --here_;
          changed_.notify_all();
          return;
        }
  }

  std::mutex mutex_;
  std::condition_variable changed_;
  Random random_;
  std::vector<bool> waiting_;
  int left_, here_ = 0;
};

/// Forwards the bytes between one host and the rig; those to the rig when it is the host's turn.
class TurnLine {
 public:
  TurnLine(std::string target, Turns& turns, int host)
      : target_(std::move(target)), turns_(turns), host_(host) {
    for (int last = 1; last < 250 && !listen_on("127.0.3." + std::to_string(last)); ++last) {
    }
    if (listener_ < 0) throw std::runtime_error("no loopback address is free for the line");
    acceptor_ = std::thread([this] { welcome(); });
  }
  ~TurnLine() {
    shutdown(listener_, SHUT_RDWR);
    acceptor_.join();
    for (auto& pump : pumps_) pump.join();
    close(listener_);
  }
  TurnLine(const TurnLine&) = delete;
  TurnLine& operator=(const TurnLine&) = delete;
  const std::string& address() const { return address_; }

 private:
  static sockaddr_in endpoint(const std::string& address) {
    sockaddr_in a{};
    a.sin_family = AF_INET;
    a.sin_port = htons(30431);
    inet_pton(AF_INET, address.c_str(), &a.sin_addr);
    return a;
  }
  bool listen_on(const std::string& where) {
    const int s = socket(AF_INET, SOCK_STREAM | SOCK_CLOEXEC, 0);
    const sockaddr_in a = endpoint(where);
    const int yes = 1;
    setsockopt(s, SOL_SOCKET, SO_REUSEADDR, &yes, sizeof yes);
    if (bind(s, reinterpret_cast<const sockaddr*>(&a), sizeof a) != 0 || listen(s, 8) != 0) {
      close(s);
      return false;
    }
    listener_ = s;
    address_ = where;
    return true;
  }
  void welcome() {
    for (int client; (client = accept4(listener_, nullptr, nullptr, SOCK_CLOEXEC)) >= 0;) {
      const int rig = socket(AF_INET, SOCK_STREAM | SOCK_CLOEXEC, 0);
      const sockaddr_in a = endpoint(target_);
      if (connect(rig, reinterpret_cast<const sockaddr*>(&a), sizeof a) != 0) {
        close(client), close(rig);
        continue;
      }
      const int yes = 1;
      for (const int fd : {client, rig}) setsockopt(fd, IPPROTO_TCP, TCP_NODELAY, &yes, sizeof yes);
      pumps_.emplace_back([this, client, rig] { pump(client, rig); });
    }
  }
  void pump(int client, int rig) {
    std::array<char, 65536> bytes{};
    for (bool open = true; open;) {
      pollfd p[2] = {{client, POLLIN, 0}, {rig, POLLIN, 0}};
      poll(p, 2, -1);
      for (const int side : {0, 1}) {
        if (p[side].revents == 0 || !open) continue;
        const ssize_t n = recv(p[side].fd, bytes.data(), bytes.size(), 0);
        if (n <= 0) {
          open = false;
          continue;
        }
        const std::string_view text(bytes.data(), static_cast<std::size_t>(n));
        // a host says good-bye to one connection while it goes on with another
        if (side == 0 && text.find("EXIT") == std::string_view::npos) turns_.wait(host_);
        send(side == 0 ? rig : client, text.data(), text.size(), MSG_NOSIGNAL);
      }
    }
    close(client), close(rig);
  }

  std::string target_, address_;
  Turns& turns_;
  int host_, listener_ = -1;
  std::thread acceptor_;
  std::vector<std::thread> pumps_;
};

Conditions conditions_of(int host, int shot) {
  Conditions c;
  c.closing_angle = radians(20.0 + 40.0 * shot + 180.0 * host);
  c.hold_time = 0.005 + 0.001 * host;
  c.seed = static_cast<std::uint64_t>(100 * host + shot + 1);
  return c;
}

}  // namespace

InterleavingRow interleavings(int count, std::uint64_t seed, const Progress& progress) {
  constexpr int hosts = 2, shots = 2;
  rigs::SimRigConfig config;
  config.record_length = 0.012;
  config.pretrigger = 0.002;
  // what each shot gives when nobody else is there
  std::array<std::array<std::uint32_t, shots>, hosts> wanted{};
  rigs::LocalRig server(config, {});
  const std::string uri = "ip:" + server.address();
  for (int h = 0; h < hosts; ++h)
    for (int s = 0; s < shots; ++s)
      wanted[static_cast<std::size_t>(h)][static_cast<std::size_t>(s)] =
          rigs::connect_iio(uri)->fire(conditions_of(h, s), std::chrono::seconds(20)).record.crc32;

  InterleavingRow row;
  std::mutex mutex;
  for (int i = 0; i < count; ++i) {
    Turns turns(hosts, seed + static_cast<std::uint64_t>(i));
    std::vector<std::thread> threads;
    for (int h = 0; h < hosts; ++h)
      threads.emplace_back([&, h] {
        TurnLine line(server.address(), turns, h);
        std::unique_ptr<rigs::Rig> rig;
        try {
          rig = rigs::connect_iio("ip:" + line.address(), std::chrono::seconds(30), std::chrono::seconds(30));
        } catch (const rigs::RigError&) {
          // a turn that comes later than the server waits for half a request costs the connection
          const std::lock_guard hold(mutex);
          row.shots += shots;
          row.refused += shots;
          turns.leave();
          return;
        }
        for (int s = 0; s < shots; ++s) {
          const rigs::Shot shot = rig->fire(conditions_of(h, s), std::chrono::seconds(20));
          const std::lock_guard hold(mutex);
          ++row.shots;
          if (shot.outcome != Outcome::pass)
            ++row.refused;
          else
            ++(shot.record.crc32 == wanted[static_cast<std::size_t>(h)][static_cast<std::size_t>(s)]
                   ? row.own
                   : row.foreign);
        }
        rig.reset();  // gives the lease back
        turns.leave();
      });
    for (auto& thread : threads) thread.join();
    ++row.schedules;
    if (progress) progress(i + 1, count);
  }
  return row;
}

}  // namespace powbench::bench
