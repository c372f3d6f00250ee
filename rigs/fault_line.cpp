#include "rigs/fault_line.h"

#include <arpa/inet.h>
#include <fcntl.h>
#include <netinet/in.h>
#include <netinet/tcp.h>
#include <poll.h>
#include <sys/eventfd.h>
#include <sys/socket.h>
#include <unistd.h>

#include <array>
#include <atomic>
#include <chrono>
#include <list>
#include <mutex>
#include <stdexcept>
#include <thread>
#include <vector>

#include "core/random.h"

namespace powbench::rigs {
namespace {

using Clock = std::chrono::steady_clock;
constexpr std::uint16_t port = 30431;
constexpr int delay_ms = 20;
constexpr std::size_t most_waiting = 1
                                     << 20;  // bytes held for one side before the other is not read any more

sockaddr_in endpoint(const std::string& address) {
  sockaddr_in a{};
  a.sin_family = AF_INET;
  a.sin_port = htons(port);
  inet_pton(AF_INET, address.c_str(), &a.sin_addr);
  return a;
}

void set_up(int fd) {
  const int yes = 1;
  setsockopt(fd, IPPROTO_TCP, TCP_NODELAY, &yes, sizeof yes);
  fcntl(fd, F_SETFL, fcntl(fd, F_GETFL) | O_NONBLOCK);
}

/// One client and its connection to the rig. Index 0: from the client; 1: from the rig.
struct Pair {
  std::array<int, 2> fd{-1, -1};
  std::array<std::string, 2> waiting;  ///< read from fd[i], to be written to the other one
  std::array<Clock::time_point, 2> not_before{};
  bool mute = false, done = false;
};

}  // namespace

const char* name(LineFault::Kind kind) {
  constexpr std::array names{"none", "flip", "drop", "close", "delay", "stall", "half_open"};
  return names[static_cast<std::size_t>(kind)];
}

struct FaultLine::Impl {
  Impl(std::string to, int ms, const BadLine& bad, const std::string& where)
      : target(std::move(to)),
        stall_ms(ms),
        wake(eventfd(0, EFD_NONBLOCK | EFD_CLOEXEC)),
        bad_line(bad),
        random(bad.seed) {
    if (!where.empty()) listen_on(where);
    for (int host = 1; where.empty() && host < 250 && listener < 0; ++host)
      listen_on("127.0.2." + std::to_string(host));
    if (listener < 0) {
      close(wake);
      throw std::runtime_error("cannot serve on " + (where.empty() ? "any loopback address" : where) +
                               " port " + std::to_string(port) + ": it is taken; choose another address");
    }
    if (bad.seed != 0) fault = draw();
    thread = std::thread([this] { run(); });
  }
  ~Impl() {
    stop = true;
    poke();
    thread.join();
    for (Pair& p : pairs) shut(p);
    close(listener);
    close(wake);
  }

  void listen_on(const std::string& where) {
    const int s = socket(AF_INET, SOCK_STREAM | SOCK_CLOEXEC, 0);
    const int yes = 1;
    setsockopt(s, SOL_SOCKET, SO_REUSEADDR, &yes, sizeof yes);
    const sockaddr_in a = endpoint(where);
    if (bind(s, reinterpret_cast<const sockaddr*>(&a), sizeof a) != 0 || listen(s, 64) != 0) {
      close(s);
      return;
    }
    listener = s;
    address = where;
  }
  void poke() const {
    const std::uint64_t one = 1;
    static_cast<void>(!write(wake, &one, sizeof one));
  }
  static void shut(Pair& p) {
    for (int& fd : p.fd) {
      if (fd >= 0) close(fd);
      fd = -1;
    }
    p.done = true;
  }

  void run();
  void welcome();
  void take(Pair&, int side);
  void give(Pair&, int side);
  void strike(Pair&, int side, std::string& bytes);
  LineFault draw();

  std::string target, address;
  int stall_ms, listener = -1, wake;
  std::atomic<bool> stop = false;
  std::list<Pair> pairs;

  std::mutex mutex;  // what follows is shared
  LineFault fault;
  bool struck = false, changed = false;
  std::array<std::uint64_t, 2> count{};  ///< bytes from client, from rig
  const BadLine bad_line;
  Random random;
  std::thread thread;
};

void FaultLine::Impl::welcome() {
  const int client = accept4(listener, nullptr, nullptr, SOCK_CLOEXEC);
  if (client < 0) return;
  const int rig = socket(AF_INET, SOCK_STREAM | SOCK_CLOEXEC, 0);
  const sockaddr_in a = endpoint(target);
  if (connect(rig, reinterpret_cast<const sockaddr*>(&a), sizeof a) != 0) {
    close(client);
    close(rig);
    return;
  }
  set_up(client);
  set_up(rig);
  Pair p;
  p.fd = {client, rig};
  pairs.push_back(std::move(p));
}

/// The next fault of a bad line, counted from now. Few bytes go towards the rig: there the distance is a hundredth.
LineFault FaultLine::Impl::draw() {
  LineFault next;
  next.kind = static_cast<LineFault::Kind>(1 + random.below(LineFault::kinds - 1));
  next.to_rig = random.below(2) == 0;
  next.byte =
      static_cast<std::uint64_t>(2.0 * random.uniform() * bad_line.mean_bytes / (next.to_rig ? 100 : 1));
  next.bit = static_cast<int>(random.below(8));
  return next;
}

/// `bytes` have just come from `side`; does to them what the fault says, if it is their turn.
void FaultLine::Impl::strike(Pair& p, int side, std::string& bytes) {
  using Kind = LineFault::Kind;
  const std::lock_guard hold(mutex);
  const auto at = static_cast<std::size_t>(side);
  const std::uint64_t first = count[at];
  count[at] += bytes.size();
  if (struck || fault.kind == Kind::none || fault.to_rig != (side == 0) || fault.byte >= count[at] ||
      fault.byte < first)
    return;
  struck = bad_line.seed == 0;
  const LineFault now = fault;
  const auto offset = static_cast<std::size_t>(fault.byte - first);
  const auto later = [&](int ms) { p.not_before[at] = Clock::now() + std::chrono::milliseconds(ms); };
  switch (now.kind) {
    case Kind::none:
      break;
    case Kind::flip:
      bytes[offset] = static_cast<char>(bytes[offset] ^ (1 << now.bit));
      break;
    case Kind::drop:
      bytes.erase(offset, 1);
      break;
    case Kind::close:
      bytes.resize(offset);
      p.done = true;
      break;
    case Kind::delay:
      later(delay_ms);
      break;
    case Kind::stall:
      later(stall_ms);
      break;
    case Kind::half_open:
      bytes.resize(offset);
      p.mute = true;
      break;
  }
  if (bad_line.seed == 0) return;
  count = {};
  fault = draw();
}

void FaultLine::Impl::take(Pair& p, int side) {
  char buffer[65536];
  const auto at = static_cast<std::size_t>(side);
  const ssize_t n = recv(p.fd[at], buffer, sizeof buffer, 0);
  if (n < 0 && (errno == EAGAIN || errno == EINTR)) return;
  if (n <= 0) {
    // a peer behind a dead line does not hear of it
    if (p.mute && side == 1) return shut(p);
    if (!p.mute || side == 0) p.done = true;
    return;
  }
  if (p.mute) return;
  std::string bytes(buffer, static_cast<std::size_t>(n));
  strike(p, side, bytes);
  p.waiting[at] += bytes;
}

void FaultLine::Impl::give(Pair& p, int side) {
  const auto at = static_cast<std::size_t>(side);
  std::string& bytes = p.waiting[at];
  if (bytes.empty() || p.fd[1 - at] < 0 || Clock::now() < p.not_before[at]) return;
  const ssize_t n = send(p.fd[1 - at], bytes.data(), bytes.size(), MSG_NOSIGNAL);
  if (n > 0) bytes.erase(0, static_cast<std::size_t>(n));
  if (n < 0 && errno != EAGAIN && errno != EINTR) p.done = true;
}

void FaultLine::Impl::run() {
  while (!stop) {
    {
      const std::lock_guard hold(mutex);
      if (changed)
        for (Pair& p : pairs) p.done = p.done || p.mute;
      changed = false;
    }
    std::vector<pollfd> polled{{listener, POLLIN, 0}, {wake, POLLIN, 0}};
    std::vector<std::pair<Pair*, int>> sides;
    int limit = -1;
    for (Pair& p : pairs) {
      for (const int side : {0, 1}) {
        const auto at = static_cast<std::size_t>(side);
        short events = p.waiting[at].size() < most_waiting ? POLLIN : 0;
        if (!p.waiting[1 - at].empty()) {
          const auto left =
              std::chrono::ceil<std::chrono::milliseconds>(p.not_before[1 - at] - Clock::now()).count();
          if (left <= 0)
            events |= POLLOUT;
          else
            limit = limit < 0 ? static_cast<int>(left) : std::min(limit, static_cast<int>(left));
        }
        polled.push_back({p.fd[at], events, 0});
        sides.emplace_back(&p, side);
      }
    }
    poll(polled.data(), polled.size(), limit);
    if ((polled[1].revents & POLLIN) != 0) {
      std::uint64_t ignored = 0;
      static_cast<void>(!read(wake, &ignored, sizeof ignored));
    }
    for (std::size_t i = 0; i < sides.size(); ++i) {
      auto& [p, side] = sides[i];
      const short got = polled[i + 2].revents;
      if (p->fd[static_cast<std::size_t>(side)] >= 0 && (got & (POLLIN | POLLHUP | POLLERR)) != 0)
        take(*p, side);
    }
    for (Pair& p : pairs)
      for (const int side : {0, 1}) give(p, side);
    for (auto p = pairs.begin(); p != pairs.end();) {
      if (p->done) shut(*p);
      p = p->done ? pairs.erase(p) : std::next(p);
    }
    if ((polled[0].revents & POLLIN) != 0) welcome();
  }
}

FaultLine::FaultLine(std::string target, int stall_ms, const BadLine& bad, const std::string& address)
    : impl_(std::make_unique<Impl>(std::move(target), stall_ms, bad, address)) {}
FaultLine::~FaultLine() = default;

const std::string& FaultLine::address() const {
  return impl_->address;
}

void FaultLine::set(const LineFault& fault) {
  {
    const std::lock_guard hold(impl_->mutex);
    impl_->fault = fault;
    impl_->struck = false;
    impl_->changed = true;
    impl_->count = {};
  }
  impl_->poke();
}

std::uint64_t FaultLine::passed(bool to_rig) const {
  const std::lock_guard hold(impl_->mutex);
  return impl_->count[to_rig ? 0 : 1];
}

bool FaultLine::struck() const {
  const std::lock_guard hold(impl_->mutex);
  return impl_->struck;
}

}  // namespace powbench::rigs
