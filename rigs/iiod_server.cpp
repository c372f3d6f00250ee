#include "rigs/iiod_server.h"

#include <utility>  // ahead of Asio: 1.74 forgets it under C++20

#include <algorithm>
#include <boost/asio.hpp>
#include <chrono>
#include <cstring>
#include <deque>
#include <vector>

#include "rigs/boot_id.h"
#include "rigs/fault_line.h"
#include "rigs/iiod_client.h"
#include "rigs/rig.h"
#include "rigs/sim_world.h"

namespace powbench::rigs {

namespace asio = boost::asio;
using asio::ip::tcp;

namespace {

using Clock = std::chrono::steady_clock;
using std::chrono::milliseconds;

constexpr double slice = 0.010;           // s of virtual time between two looks at the sockets
constexpr milliseconds pulse_period{50};  // wall time between two accounts of it, while there is a lease
constexpr milliseconds typing_limit{
    1000};  // from the first byte of a request to its last, and from connecting on
// a client that has said nothing for this long makes room when all places are taken
constexpr milliseconds idle_limit{10'000};
// if there is none, the one that came last and has been here for this long: a stop always gets a place
constexpr milliseconds stay_limit{250};
constexpr std::size_t most_farewells = 64;  // clients being told at one time that there is no place
constexpr const char* no_place =
    "-16\nall connections of this rig are taken: close one of its other clients, then try again\n";

}  // namespace

struct IiodServer::Impl {
  struct Session;

  Impl(const SimRigConfig& config, const sim::Specimen& specimen, std::string where, std::uint16_t port,
       const BoardOptions& options)
      : acceptor(io),
        signals(io),
        pulse_timer(io),
        address(std::move(where)),
        idle(options.idle.value_or(idle_limit)),
        stay(options.stay.value_or(stay_limit)) {
    if (config.faults.line.seed == 0)
      listen(address, port);
    else
      listen_behind(config.faults.line, port);
    // behind the address: a board is not started for nothing
    BoardOptions started = options;
    if (started.boot_id.empty()) started.boot_id = next_boot_id(config.serial);
    world = std::make_unique<SimWorld>(config, specimen, started);
  }

  void listen(const std::string& where, std::uint16_t port);
  void listen_behind(const BadLine&, std::uint16_t port);
  void accept();
  void work();
  void drop(const Session* session);
  void wake_readers();
  void say_farewell(tcp::socket socket);
  void pulse();
  int free_connection() const;
  void make_room();
  Board& board() { return world->board(); }

  std::unique_ptr<SimWorld> world;
  asio::io_context io{1};
  tcp::acceptor acceptor;
  asio::signal_set signals;
  asio::steady_timer pulse_timer;
  std::string address;
  std::unique_ptr<FaultLine> line;  ///< the one that `address` leads to, where a bad one is asked for
  std::vector<std::shared_ptr<Session>> sessions;
  std::size_t farewells = 0;
  std::uint64_t turns = 0;  ///< requests or pieces of them so far
  bool working = false, pulsing = false;
  const milliseconds idle, stay;
};

/// One client connection: bytes in, answers out, in order.
struct IiodServer::Impl::Session : std::enable_shared_from_this<Session> {
  Session(Impl& owner, tcp::socket s, unsigned number)
      : server(owner),
        socket(std::move(s)),
        deadline(owner.io),
        typing(owner.io),
        client(*owner.world, number) {
    boost::system::error_code ignored;
    peer = socket.remote_endpoint(ignored).address();
    socket.set_option(tcp::no_delay(true), ignored);  // without it a refill takes 44 ms
  }

  void start() {
    limit_typing();
    next();
  }

  /// Answers what was heard; reads on unless a READBUF waits for samples.
  void consume() {
    active = ++server.turns;
    spoke = Clock::now();
    auto bytes = client.answer();
    if (!client.halfway()) typing.cancel();
    if (client.halfway() && !was_halfway) limit_typing();
    was_halfway = client.halfway();
    if (client.status() == Board::Status::pending) wait_for_samples();
    send(std::move(bytes));
    server.work();
    server.pulse();
  }

  /// A request that is never finished holds one of few places.
  void limit_typing() {
    typing.expires_after(typing_limit);
    typing.async_wait([self = shared_from_this()](auto error) {
      if (!error) self->close();
    });
  }

  /// A READBUF is owed an answer within the client's time-out, whatever happens. A client of libiio 0.24 sets it on its
  /// other connection: that is the one from the same address which spoke last.
  void wait_for_samples() {
    const Session* speaker = client.timeout_ms() >= 0 ? this : nullptr;
    for (const auto& other : server.sessions)
      if (client.timeout_ms() < 0 && other->client.timeout_ms() >= 0 && other->peer == peer &&
          (!speaker || other->active > speaker->active))
        speaker = other.get();
    const std::int32_t ms = speaker ? speaker->client.timeout_ms() : 0;
    if (ms == 0) return;
    deadline.expires_after(milliseconds(ms));
    deadline.async_wait([self = shared_from_this()](auto error) {
      if (error || self->client.status() != Board::Status::pending || !self->socket.is_open()) return;
      self->send(self->client.expire());
    });
  }

  void samples_arrived() {
    if (client.status() != Board::Status::pending || !socket.is_open()) return;
    auto bytes = client.resume();
    if (client.status() == Board::Status::ready) deadline.cancel();
    send(std::move(bytes));
  }

  void send(std::vector<std::uint8_t> bytes) {
    if (bytes.empty()) return next();
    outgoing.push_back(std::move(bytes));
    if (outgoing.size() == 1) write();
  }

  void write() {
    asio::async_write(socket, asio::buffer(outgoing.front()),
                      [self = shared_from_this()](auto error, std::size_t) {
                        if (error) return self->close();
                        self->outgoing.pop_front();
                        if (!self->outgoing.empty()) return self->write();
                        self->next();
                      });
  }

  /// Everything is answered: go on with bytes already here, else read more. While a READBUF is pending the
  /// socket is read all the same, so that a vanished client is noticed.
  void next() {
    if (client.status() == Board::Status::closed) return close();
    if (reading || !outgoing.empty()) return;
    if (client.unanswered() && client.status() == Board::Status::ready) {
      asio::post(server.io, [self = shared_from_this()] { self->consume(); });
      return;
    }
    reading = true;
    socket.async_read_some(asio::buffer(incoming), [self = shared_from_this()](auto error, std::size_t n) {
      self->reading = false;
      if (error) return self->close();
      if (!self->client.hear(std::span(self->incoming).first(n))) return self->close();
      if (self->client.status() == Board::Status::ready)
        self->consume();
      else
        self->next();
    });
  }

  void close() {
    if (!socket.is_open()) return;
    boost::system::error_code ignored;
    deadline.cancel();
    typing.cancel();
    socket.close(ignored);
    client.leave();
    server.drop(this);
  }

  Impl& server;
  tcp::socket socket;
  asio::steady_timer deadline, typing;
  asio::ip::address peer;
  std::uint64_t active = 0;  ///< when it spoke last, in turns of the server
  const Clock::time_point came = Clock::now();
  Clock::time_point spoke = came;  ///< when it spoke last, or came
  bool was_halfway = true;         ///< a new connection owes a request
  IiodClient client;
  std::array<std::uint8_t, 4096> incoming{};
  std::deque<std::vector<std::uint8_t>> outgoing;
  bool reading = false;
};

void IiodServer::Impl::listen(const std::string& where, std::uint16_t port) try {
  const tcp::endpoint endpoint(asio::ip::make_address(where), port);
  acceptor.open(endpoint.protocol());
  acceptor.set_option(tcp::acceptor::reuse_address(true));
  acceptor.bind(endpoint);
  acceptor.listen();
} catch (const boost::system::system_error& e) {
  boost::system::error_code ignored;
  acceptor.close(ignored);
  throw AddressError("cannot serve on " + where + " port " + std::to_string(port) + ": " +
                     e.code().message() + "; choose another loopback address, such as 127.0.0.8");
}

/// On a loopback address that is not published, behind the disturbed line.
void IiodServer::Impl::listen_behind(const BadLine& bad, std::uint16_t port) {
  std::string inner;
  for (int host = 1; host < 255 && inner.empty(); ++host) {
    const std::string where = "127.0.3." + std::to_string(host);
    try {
      listen(where, port);
      inner = where;
    } catch (const AddressError&) {
      if (host == 254) throw;
    }
  }
  try {
    line = std::make_unique<FaultLine>(inner, bad_line_stall_ms, bad, address);
  } catch (const std::runtime_error& e) {
    throw AddressError(e.what());
  }
}

void IiodServer::Impl::accept() {
  acceptor.async_accept([this](auto error, tcp::socket socket) {
    if (error) return;
    // a board has memory for so many clients; one more gets a sentence
    if (free_connection() < 0) make_room();
    if (const int number = free_connection(); number >= 0) {
      sessions.push_back(std::make_shared<Session>(*this, std::move(socket), static_cast<unsigned>(number)));
      sessions.back()->start();
    } else if (farewells < most_farewells) {
      say_farewell(std::move(socket));
    }
    accept();
  });
}

/// Closes the client that has been silent the longest, if that is long enough; else the one that came last, if it has
/// had its time. Never the owner.
void IiodServer::Impl::make_room() {
  std::shared_ptr<Session> silent, last;
  for (const auto& session : sessions) {
    if (session->client.claims() && board().report().lease_held) continue;
    const bool waits = session->client.status() == Board::Status::pending;
    if (!waits && (!silent || session->active < silent->active)) silent = session;
    if (!last || session->came >= last->came) last = session;
  }
  if (silent && Clock::now() - silent->spoke >= idle)
    silent->close();
  else if (last && Clock::now() - last->came >= stay)
    last->close();
}

/// Tells a client in one sentence that there is no place. What it said is read first: closing over unread bytes would
/// take the sentence away again.
void IiodServer::Impl::say_farewell(tcp::socket socket) {
  struct Farewell {
    Farewell(tcp::socket s, asio::io_context& io) : socket(std::move(s)), limit(io) {}
    tcp::socket socket;
    asio::steady_timer limit;
    std::array<char, 512> heard{};
  };
  ++farewells;
  auto guest = std::make_shared<Farewell>(std::move(socket), io);
  guest->limit.expires_after(typing_limit);
  guest->limit.async_wait([guest](auto) {
    boost::system::error_code ignored;
    guest->socket.close(ignored);
  });
  asio::async_write(
      guest->socket, asio::buffer(no_place, std::strlen(no_place)), [this, guest](auto, std::size_t) {
        boost::system::error_code ignored;
        guest->socket.shutdown(tcp::socket::shutdown_send, ignored);
        guest->socket.async_read_some(asio::buffer(guest->heard), [this, guest](auto, std::size_t) {
          --farewells;
          guest->limit.cancel();
        });
      });
}

/// Wall time counts for the lease, which must end also while virtual time stands still.
void IiodServer::Impl::pulse() {
  if (pulsing || !board().report().lease_held) return;
  pulsing = true;
  pulse_timer.expires_after(pulse_period);
  pulse_timer.async_wait([this, since = Clock::now()](auto error) {
    pulsing = false;
    if (error) return;
    board().rest(std::chrono::duration_cast<milliseconds>(Clock::now() - since).count());
    work();
    pulse();
  });
}

int IiodServer::Impl::free_connection() const {
  for (unsigned number = 0; number < firmware::Bench::max_connections; ++number)
    if (std::none_of(sessions.begin(), sessions.end(),
                     [&](const auto& s) { return s->client.connection() == number; }))
      return static_cast<int>(number);
  return -1;
}

/// Lets virtual time pass in slices, with the sockets served in between.
void IiodServer::Impl::work() {
  if (working || !world->busy()) return;
  working = true;
  asio::post(io, [this] {
    world->run(slice);
    working = false;
    if (!world->busy()) wake_readers();
    work();
  });
}

void IiodServer::Impl::wake_readers() {
  const auto waiting = sessions;  // answering may close a session
  for (const auto& session : waiting) session->samples_arrived();
}

void IiodServer::Impl::drop(const Session* session) {
  std::erase_if(sessions, [session](const auto& s) { return s.get() == session; });
}

IiodServer::IiodServer(const SimRigConfig& config, const sim::Specimen& specimen, const std::string& address,
                       std::uint16_t port, const BoardOptions& options)
    : impl_(std::make_unique<Impl>(config, specimen, address, port, options)) {}
IiodServer::~IiodServer() = default;
const std::string& IiodServer::address() const {
  return impl_->address;
}

void IiodServer::serve(bool until_interrupted) {
  if (until_interrupted) {
    impl_->signals.add(SIGINT);
    impl_->signals.add(SIGTERM);
    impl_->signals.async_wait([this](auto error, int) {
      if (!error) impl_->io.stop();
    });
  }
  impl_->board().adopt_thread();
  impl_->accept();
  try {
    impl_->io.run();
  } catch (const RigError&) {
    // a board that is gone: its clients must not wait for it
    boost::system::error_code ignored;
    impl_->acceptor.close(ignored);
    for (const auto& session : impl_->sessions) session->socket.close(ignored);
    throw;
  }
}

void IiodServer::stop() {
  impl_->io.stop();
}

}  // namespace powbench::rigs
