#include "rigs/iiod_server.h"

#include <utility>  // ahead of Asio: 1.74 forgets it under C++20

#include <algorithm>
#include <atomic>
#include <boost/asio.hpp>
#include <chrono>
#include <cstdio>
#include <deque>
#include <mutex>
#include <thread>
#include <vector>

#include "core/random.h"
#include "rigs/rig.h"
#include "rigs/sim_world.h"

namespace powbench::rigs {

namespace asio = boost::asio;
using asio::ip::tcp;

namespace {

constexpr double slice = 0.010;  // s of virtual time between two looks at the sockets

/// The address cannot be had; another one may.
struct AddressError : RigError {
  using RigError::RigError;
};

}  // namespace

std::string next_boot_id(const std::string& serial, std::uint64_t seed) {
  static std::atomic<std::uint64_t> starts{0};
  std::uint64_t state = seed;
  for (const char c : serial) state = splitmix64(state) ^ static_cast<unsigned char>(c);
  state = splitmix64(state) + ++starts;
  char text[17];
  std::snprintf(text, sizeof text, "%016llx", static_cast<unsigned long long>(splitmix64(state)));
  return text;
}

struct IiodServer::Impl {
  struct Session;

  Impl(const SimRigConfig& config, const sim::Specimen& specimen, std::string where, std::uint16_t port,
       const BoardOptions& options)
      : acceptor(io), signals(io), address(std::move(where)) {
    try {
      const tcp::endpoint endpoint(asio::ip::make_address(address), port);
      acceptor.open(endpoint.protocol());
      acceptor.set_option(tcp::acceptor::reuse_address(true));
      acceptor.bind(endpoint);
      acceptor.listen();
    } catch (const boost::system::system_error& e) {
      throw AddressError("cannot serve on " + address + " port " + std::to_string(port) + ": " +
                         e.code().message() + "; choose another loopback address, such as 127.0.0.8");
    }
    // behind the address: a board is not started for nothing
    BoardOptions started = options;
    if (started.boot_id.empty()) started.boot_id = next_boot_id(config.serial);
    world = std::make_unique<SimWorld>(config, specimen, started);
  }

  void accept();
  void work();
  void drop(const Session* session);
  void wake_readers();
  int free_connection() const;
  Board& board() { return world->board(); }

  std::unique_ptr<SimWorld> world;
  asio::io_context io{1};
  tcp::acceptor acceptor;
  asio::signal_set signals;
  std::string address;
  std::vector<std::shared_ptr<Session>> sessions;
  bool working = false;
  std::atomic<bool> busy = false;  ///< `working` for other threads
};

/// One client connection: bytes in, answers out, in order.
struct IiodServer::Impl::Session : std::enable_shared_from_this<Session> {
  Session(Impl& owner, tcp::socket s, unsigned number)
      : server(owner), socket(std::move(s)), deadline(owner.io), connection(number) {
    boost::system::error_code ignored;
    socket.set_option(tcp::no_delay(true), ignored);  // without it a refill takes 44 ms
  }

  /// Hands received bytes to the responder, then answers; reads on unless a READBUF waits for samples.
  void consume() {
    auto answer = server.board().feed(connection, unread);
    status = answer.status;
    unread.erase(unread.begin(), unread.begin() + static_cast<std::ptrdiff_t>(answer.used));
    server.world->notice_commands();
    if (status == Board::Status::pending) wait_for_samples();
    server.work();  // ahead of the answer: who has it knows that the shot runs
    send(std::move(answer.bytes));
  }

  /// A READBUF is owed an answer within the client's time-out, whatever happens.
  void wait_for_samples() {
    const std::uint32_t ms = server.board().report().timeout_ms;
    if (ms == 0) return;
    deadline.expires_after(std::chrono::milliseconds(ms));
    deadline.async_wait([self = shared_from_this()](auto error) {
      if (error || self->status != Board::Status::pending || !self->socket.is_open()) return;
      auto answer = self->server.board().expire(self->connection);
      self->status = answer.status;
      self->send(std::move(answer.bytes));
    });
  }

  void samples_arrived() {
    if (status != Board::Status::pending || !socket.is_open()) return;
    auto answer = server.board().resume(connection);
    status = answer.status;
    if (status == Board::Status::ready) deadline.cancel();
    send(std::move(answer.bytes));
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
    if (status == Board::Status::closed) return close();
    if (reading || !outgoing.empty()) return;
    if (!unread.empty() && status == Board::Status::ready) {
      asio::post(server.io, [self = shared_from_this()] { self->consume(); });
      return;
    }
    reading = true;
    socket.async_read_some(asio::buffer(incoming), [self = shared_from_this()](auto error, std::size_t n) {
      self->reading = false;
      if (error) return self->close();
      self->unread.insert(self->unread.end(), self->incoming.begin(),
                          self->incoming.begin() + static_cast<std::ptrdiff_t>(n));
      if (self->status == Board::Status::ready)
        self->consume();
      else
        self->next();
    });
  }

  void close() {
    if (!socket.is_open()) return;
    boost::system::error_code ignored;
    deadline.cancel();
    socket.close(ignored);
    server.board().close(connection);
    server.drop(this);
  }

  Impl& server;
  tcp::socket socket;
  asio::steady_timer deadline;
  const unsigned connection;  ///< its number on the board
  Board::Status status = Board::Status::ready;
  std::array<std::uint8_t, 4096> incoming{};
  std::vector<std::uint8_t> unread;
  std::deque<std::vector<std::uint8_t>> outgoing;
  bool reading = false;
};

void IiodServer::Impl::accept() {
  acceptor.async_accept([this](auto error, tcp::socket socket) {
    if (error) return;
    // a board has memory for so many clients; one more is turned away
    if (const int number = free_connection(); number >= 0) {
      sessions.push_back(std::make_shared<Session>(*this, std::move(socket), static_cast<unsigned>(number)));
      sessions.back()->next();
    }
    accept();
  });
}

int IiodServer::Impl::free_connection() const {
  for (unsigned number = 0; number < firmware::Bench::max_connections; ++number)
    if (std::none_of(sessions.begin(), sessions.end(),
                     [&](const auto& s) { return s->connection == number; }))
      return static_cast<int>(number);
  return -1;
}

/// Lets virtual time pass in slices, with the sockets served in between.
void IiodServer::Impl::work() {
  if (working) return;
  working = world->busy();
  busy = working;
  if (!working) return;
  asio::post(io, [this] {
    world->host_connected(!sessions.empty());
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

bool IiodServer::busy() const {
  return impl_->busy;
}

struct LocalRig::Impl {
  std::unique_ptr<IiodServer> server;
  std::thread thread;
  mutable std::mutex lock;  ///< of `failure`
  std::string failure;
};

LocalRig::LocalRig(const SimRigConfig& config, const sim::Specimen& specimen, const BoardOptions& options)
    : impl_(std::make_unique<Impl>()) {
  std::string last_error;
  for (int host = 2; host < 255 && !impl_->server; ++host) {
    try {
      impl_->server = std::make_unique<IiodServer>(config, specimen, "127.0.0." + std::to_string(host),
                                                   iiod_port, options);
    } catch (const AddressError& e) {
      last_error = e.what();
    }
  }
  if (!impl_->server) throw RigError("no loopback address is free for a simulated rig: " + last_error);
  impl_->thread = std::thread([this] {
    try {
      impl_->server->serve();
    } catch (const RigError& e) {
      const std::lock_guard hold(impl_->lock);
      impl_->failure = e.what();
    }
  });
}

LocalRig::~LocalRig() {
  impl_->server->stop();
  impl_->thread.join();
}

std::string LocalRig::failure() const {
  const std::lock_guard hold(impl_->lock);
  return impl_->failure;
}

bool LocalRig::busy() const {
  return impl_->server->busy();
}

const std::string& LocalRig::address() const {
  return impl_->server->address();
}

}  // namespace powbench::rigs
