#include "rigs/bridge/bridge.h"

#include <csignal>
#include <exception>
#include <mutex>
#include <thread>

#include "rigs/bridge/served_port.h"
#include "rigs/bridge/session.h"
#include "rigs/rig.h"

namespace powbench::rigs {

namespace asio = boost::asio;
using asio::awaitable;
using asio::ip::tcp;

struct Bridge::Impl {
  explicit Impl(const BridgeOptions& options)
      : hub(io, options), acceptor(io), signals(io), address(options.address) {
    bind(options);
    run_until_found();
    constexpr std::uint16_t port_of_libiio = 30431;
    if (options.tcp_port == port_of_libiio) place.emplace(options.port, address);
  }

  void bind(const BridgeOptions& options);
  void run_until_found();
  void learn_board();
  awaitable<void> find_board();
  awaitable<void> accept();
  void shut_down();

  asio::io_context io{1};
  bridge::Hub hub;
  tcp::acceptor acceptor;
  asio::signal_set signals;
  std::string address;
  std::optional<ServedPort> place;  ///< where others find the address
  std::string why_lost() const {
    const std::lock_guard lock(mutex);
    return lost;
  }

  mutable std::mutex mutex;
  std::string lost;  ///< why the port is gone; shared, under the mutex
};

/// Takes the address before the board is asked anything; with none given, the first that is free.
void Bridge::Impl::bind(const BridgeOptions& options) {
  boost::system::error_code error;
  const bool any = options.address.empty();
  for (int host = 2; host < 255; ++host) {
    if (any) address = "127.0.0." + std::to_string(host);
    const auto ip = asio::ip::make_address(address, error);
    if (!error) {
      const tcp::endpoint endpoint(ip, options.tcp_port);
      acceptor.open(endpoint.protocol());
      acceptor.set_option(tcp::acceptor::reuse_address(true));
      acceptor.bind(endpoint, error);
      // two sockets may be bound to one address before either listens
      if (!error) acceptor.listen(asio::socket_base::max_listen_connections, error);
      if (!error) return;
      acceptor.close();
    }
    if (!any) break;
  }
  throw RigError("cannot serve on " + address + " port " + std::to_string(options.tcp_port) + ": " +
                 error.message() + "; choose another loopback address, such as 127.0.0.8");
}

void Bridge::Impl::run_until_found() {
  hub.line.on_lost = [this](std::string why) {
    {
      const std::lock_guard lock(mutex);
      lost = std::move(why);
    }
    shut_down();
  };
  std::exception_ptr trouble;
  bool found = false;
  asio::co_spawn(io, find_board(), [&](std::exception_ptr e) {
    trouble = e;
    found = true;
  });
  while (!found) io.run_one();
  if (trouble) {
    shut_down();
    io.restart();
    io.run();  // lets every coroutine end before what it refers to
    std::rethrow_exception(trouble);
  }
  hub.line.on_new_board = [this] {
    // libiio cannot take devices out of a context, and what a client set before a reset is gone
    learn_board();
    hub.close_sessions();
  };
  hub.line.in_use = [this] { return !hub.sessions.empty(); };
}

void Bridge::Impl::learn_board() {
  hub.devices = bridge::read_devices(hub.line.description());
}

awaitable<void> Bridge::Impl::find_board() {
  co_await hub.line.start();
  learn_board();
  // a bridge before this one may have left a buffer open; its client is gone
  const bridge::Expected number;
  for (const bridge::DeviceLayout& device : hub.devices) {
    const std::string request = "CLOSE " + device.id + "\n";
    if (device.buffered()) co_await hub.line.ask(request, number);
  }
}

awaitable<void> Bridge::Impl::accept() {
  for (;;) {
    boost::system::error_code error;
    tcp::socket socket(io);
    co_await acceptor.async_accept(socket, asio::redirect_error(asio::use_awaitable, error));
    if (!acceptor.is_open()) break;
    if (error) continue;
    hub.sessions.push_back(std::make_shared<bridge::Session>(hub, std::move(socket)));
    hub.sessions.back()->start();
  }
}

void Bridge::Impl::shut_down() {
  boost::system::error_code ignored;
  acceptor.close(ignored);
  signals.cancel(ignored);
  hub.close_sessions();
  hub.line.close();
}

Bridge::Bridge(const BridgeOptions& options) : impl_(std::make_unique<Impl>(options)) {}

Bridge::~Bridge() {
  impl_->shut_down();
  impl_->io.restart();
  impl_->io.run();
}

const std::string& Bridge::address() const {
  return impl_->address;
}

std::string Bridge::board() const {
  const std::string& xml = impl_->hub.line.description();
  const std::string model = bridge::context_attribute(xml, "hw_model");
  const std::string serial = bridge::context_attribute(xml, "hw_serial");
  return (model.empty() ? "IIO board" : model) + (serial.empty() ? "" : ", " + serial);
}

void Bridge::serve(bool until_interrupted) {
  if (until_interrupted) {
    impl_->signals.add(SIGINT);
    impl_->signals.add(SIGTERM);
    impl_->signals.async_wait([this](auto error, int) {
      if (!error) impl_->shut_down();
    });
  }
  if (impl_->why_lost().empty()) asio::co_spawn(impl_->io, impl_->accept(), asio::detached);
  impl_->io.restart();
  impl_->io.run();
  if (const std::string why = impl_->why_lost(); !why.empty()) throw RigError(why);
}

std::string Bridge::lost() const {
  return impl_->why_lost();
}

void Bridge::stop() {
  asio::post(impl_->io, [this] { impl_->shut_down(); });
}

struct LocalBridge::Impl {
  explicit Impl(const BridgeOptions& options) : bridge(options) {}

  Bridge bridge;
  std::thread thread;
};

LocalBridge::LocalBridge(const BridgeOptions& options) : impl_(std::make_unique<Impl>(options)) {
  impl_->thread = std::thread([this] {
    try {
      impl_->bridge.serve();
    } catch (const RigError&) {  // failure() says why
    }
  });
}

LocalBridge::~LocalBridge() {
  impl_->bridge.stop();
  impl_->thread.join();
}

const std::string& LocalBridge::address() const {
  return impl_->bridge.address();
}

std::optional<std::string> LocalBridge::failure() const {
  const std::string why = impl_->bridge.lost();
  return why.empty() ? std::nullopt : std::optional(why);
}

}  // namespace powbench::rigs
