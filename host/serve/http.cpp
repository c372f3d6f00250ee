#include "host/serve/http.h"

#include <sys/resource.h>

#include <algorithm>
#include <boost/asio/io_context.hpp>
#include <boost/asio/ip/tcp.hpp>
#include <boost/asio/post.hpp>
#include <boost/asio/signal_set.hpp>
#include <boost/asio/steady_timer.hpp>
#include <boost/asio/thread_pool.hpp>
#include <boost/beast/core.hpp>
#include <boost/beast/http.hpp>
#include <boost/beast/websocket.hpp>
#include <optional>
#include <set>
#include <vector>

#include "host/serve/page.h"

namespace powbench::host {
namespace {

namespace asio = boost::asio;
namespace beast = boost::beast;
namespace http = beast::http;
namespace websocket = beast::websocket;
using tcp = asio::ip::tcp;
using beast::error_code;
using HttpRequest = http::request<http::string_body>;
using HttpReply = http::response<http::string_body>;

constexpr auto idle_time = std::chrono::seconds(60);
constexpr auto visit_time = std::chrono::seconds(2);  ///< of a connection that may only stop
constexpr std::size_t most_visitors = 64;
constexpr rlim_t files_of_others = 128;  ///< descriptors of the rig's lines, the database, answers
constexpr auto least_pause = std::chrono::milliseconds(40);  ///< between two states: 25 a second

std::string text(beast::string_view v) {
  return {v.data(), v.size()};
}

Request request_of(const HttpRequest& in) {
  Request r;
  r.method = text(in.method_string());
  if (in.method() == http::verb::head) r.method = "GET";  // the same answer without its body
  const std::string target = text(in.target());
  const auto mark = target.find('?');
  r.path = target.substr(0, mark);
  if (mark != std::string::npos) r.query = target.substr(mark + 1);
  r.body = in.body();
  r.host = text(in[http::field::host]);
  r.origin = text(in[http::field::origin]);
  r.content_type = text(in[http::field::content_type]);
  const std::string authorization = text(in[http::field::authorization]);
  if (authorization.starts_with("Bearer ")) r.token = authorization.substr(7);
  // a browser's WebSocket and a link to a report carry no header of ours
  r.link_token = of_query(r.query, "token");
  return r;
}

/// `why`: without quotes.
Reply refusal(int status, const std::string& why) {
  Reply r;
  r.status = status;
  r.body = "{\"error\":\"" + why + "\"}";
  return r;
}

HttpReply reply_of(const Reply& from, const HttpRequest& to) {
  HttpReply out(static_cast<http::status>(from.status), to.version());
  out.set(http::field::content_type, from.type);
  out.set("Content-Security-Policy", from.policy.empty() ? page_policy : from.policy);
  out.set("X-Content-Type-Options", "nosniff");
  out.set("Referrer-Policy", "no-referrer");
  out.set("Cross-Origin-Resource-Policy", "same-origin");
  out.set(http::field::cache_control, "no-store");
  if (!from.file.empty())
    out.set(http::field::content_disposition, "attachment; filename=\"" + from.file + "\"");
  out.keep_alive(to.keep_alive());
  out.body() = from.body;
  out.prepare_payload();
  if (to.method() == http::verb::head) out.body().clear();  // its length stays told
  return out;
}

/// Connections that leave descriptors for a stop.
std::size_t places() {
  rlimit limit{};
  getrlimit(RLIMIT_NOFILE, &limit);
  const rlim_t kept = files_of_others + most_visitors;
  return std::min<std::size_t>(HttpServer::most_clients, limit.rlim_cur > kept ? limit.rlim_cur - kept : 1);
}

}  // namespace

std::string of_query(const std::string& query, const std::string& name) {
  for (std::size_t at = 0; at < query.size();) {
    const auto end = std::min(query.find('&', at), query.size());
    const std::string part = query.substr(at, end - at);
    if (part.starts_with(name + "=")) return part.substr(name.size() + 1);
    at = end + 1;
  }
  return {};
}

struct HttpServer::Impl {
  class Client;
  class Listener;

  Impl(const std::string& address, std::uint16_t port, Handlers h)
      : handlers(std::move(h)), acceptor(io), pause(io) {
    error_code e;
    const auto ip = asio::ip::make_address(address, e);
    if (e) throw std::runtime_error("--listen " + address + ": is no address; such as 127.0.0.1:8080");
    const tcp::endpoint endpoint(ip, port);
    acceptor.open(endpoint.protocol(), e);
    if (!e) acceptor.set_option(asio::socket_base::reuse_address(true), e);
    if (!e) acceptor.bind(endpoint, e);
    if (!e) acceptor.listen(asio::socket_base::max_listen_connections, e);
    if (e)
      throw std::runtime_error("cannot listen on " + address + ":" + std::to_string(port) + ": " +
                               e.message());
  }

  void accept();
  void drop_silent_visitor();
  void send_news();
  void close_all();

  const Handlers handlers;
  asio::io_context io{1};
  tcp::acceptor acceptor;
  asio::steady_timer pause;  ///< runs: a state was sent less than `least_pause` ago
  std::chrono::steady_clock::time_point last_record{};  ///< when one was sent
  bool pausing = false, state_stale = false, record_stale = false;
  const std::size_t most = places();
  std::set<std::shared_ptr<Client>> clients;
  std::vector<std::shared_ptr<Client>> visitors;  ///< oldest first
  std::set<std::shared_ptr<Listener>> listeners;
  asio::thread_pool workers{2}, stopper{1};
};

/// A WebSocket that gets states, or records; one at a time, the newest that there is. What it says is thrown away.
class HttpServer::Impl::Listener : public std::enable_shared_from_this<Listener> {
 public:
  Listener(Impl& server, tcp::socket socket, bool records)
      : server_(server), socket_(std::move(socket)), records_(records) {
    socket_.read_message_max(1024);
    socket_.set_option(websocket::stream_base::timeout::suggested(beast::role_type::server));
  }

  void begin(const HttpRequest& request) {
    socket_.async_accept(request, [self = shared_from_this()](error_code e) {
      if (e) return;
      self->open_ = true;
      self->server_.listeners.insert(self);
      self->read();
      self->send();
    });
  }

  void send() {
    waiting_ = true;
    if (writing_ || !open_) return;
    waiting_ = false;
    message_ =
        records_ ? server_.handlers.record() : std::make_shared<const std::string>(server_.handlers.state());
    if (!message_) return;  // no record yet
    writing_ = true;
    socket_.binary(records_);
    socket_.async_write(asio::buffer(*message_), [self = shared_from_this()](error_code e, std::size_t) {
      self->writing_ = false;
      if (e) return self->drop();
      if (self->waiting_) self->send();
    });
  }

  void close() { beast::get_lowest_layer(socket_).close(); }
  bool of_records() const { return records_; }

 private:
  void read() {
    socket_.async_read(buffer_, [self = shared_from_this()](error_code e, std::size_t) {
      if (e) return self->drop();
      self->buffer_.consume(self->buffer_.size());
      self->read();
    });
  }
  void drop() {
    open_ = false;
    server_.listeners.erase(shared_from_this());
  }

  Impl& server_;
  websocket::stream<beast::tcp_stream> socket_;
  beast::flat_buffer buffer_;
  const bool records_;
  std::shared_ptr<const std::string> message_;
  bool open_ = false, writing_ = false, waiting_ = false;
};

/// One connection: request, reply, request, ... A visitor comes when all places are taken: it may only stop.
class HttpServer::Impl::Client : public std::enable_shared_from_this<Client> {
 public:
  Client(Impl& server, tcp::socket socket, bool visitor)
      : server_(server), stream_(std::move(socket)), visitor_(visitor) {}

  void begin() {
    if (visitor_)
      server_.visitors.push_back(shared_from_this());
    else
      server_.clients.insert(shared_from_this());
    read();
  }
  void close() { stream_.close(); }
  bool silent() const { return !heard_; }

 private:
  void read() {
    parser_.emplace();
    parser_->body_limit(largest_body);
    stream_.expires_after(visitor_ ? visit_time : idle_time);
    http::async_read(stream_, buffer_, *parser_, [self = shared_from_this()](error_code e, std::size_t) {
      if (e == http::error::body_limit || e == http::error::header_limit)
        return self->write(refusal(413, "the request is too large"), true);
      if (e && e.category() == http::make_error_code(http::error::bad_method).category() &&
          e != http::error::end_of_stream && e != http::error::partial_message)
        return self->write(refusal(400, "this is no HTTP request"), true);
      if (e) return self->drop();
      self->heard_ = true;
      self->act();
    });
  }

  void act() {
    const Request request = request_of(parser_->get());
    const bool stop = server_.handlers.is_stop(request);
    if (visitor_ && !stop)
      return write(refusal(503, "all connections are taken; close other pages, then try again"), true);
    if (websocket::is_upgrade(parser_->get())) {
      const bool records = request.path == record_stream;
      const Reply may =
          records || request.path == state_stream
              ? server_.handlers.listen(request)
              : refusal(404, std::string("states are at ") + state_stream + ", records at " + record_stream);
      if (may.status != 200) return write(may, true);
      stream_.expires_never();
      const auto listener = std::make_shared<Listener>(server_, stream_.release_socket(), records);
      server_.clients.erase(shared_from_this());
      return listener->begin(parser_->get());
    }
    stream_.expires_never();  // a report may take its time
    auto& pool = stop ? server_.stopper : server_.workers;
    asio::post(pool, [self = shared_from_this(), request] {
      Reply reply = self->server_.handlers.answer(request);
      asio::post(self->server_.io, [self, r = std::move(reply)] { self->write(r, self->visitor_); });
    });
  }

  void write(const Reply& reply, bool last) {
    reply_.emplace(reply_of(reply, parser_->get()));
    if (last) reply_->keep_alive(false);
    stream_.expires_after(idle_time);
    http::async_write(stream_, *reply_, [self = shared_from_this()](error_code e, std::size_t) {
      if (e || !self->reply_->keep_alive()) return self->drop();
      self->read();
    });
  }

  void drop() {
    error_code ignored;
    stream_.socket().shutdown(tcp::socket::shutdown_send, ignored);
    if (visitor_)
      std::erase(server_.visitors, shared_from_this());
    else
      server_.clients.erase(shared_from_this());
  }

  Impl& server_;
  beast::tcp_stream stream_;
  const bool visitor_;
  bool heard_ = false;  ///< a whole request came
  beast::flat_buffer buffer_{65'536};
  std::optional<http::request_parser<http::string_body>> parser_;
  std::optional<HttpReply> reply_;
};

void HttpServer::Impl::accept() {
  acceptor.async_accept([this](error_code e, tcp::socket socket) {
    if (e == asio::error::operation_aborted) return;
    const bool full = clients.size() + listeners.size() >= most;
    if (!e && full && visitors.size() >= most_visitors) drop_silent_visitor();
    if (!e && !(full && visitors.size() >= most_visitors)) {
      error_code ignored;
      socket.set_option(tcp::no_delay(true), ignored);
      std::make_shared<Client>(*this, std::move(socket), full)->begin();
    }
    accept();
  });
}

/// The oldest visitor of whom no request has come makes room: a stop says what it wants at once.
void HttpServer::Impl::drop_silent_visitor() {
  const auto oldest = std::ranges::find_if(visitors, [](const auto& v) { return v->silent(); });
  if (oldest == visitors.end()) return;
  (*oldest)->close();
  visitors.erase(oldest);
}

/// What has changed, to those who want it; then a pause.
void HttpServer::Impl::send_news() {
  if (pausing || !(state_stale || record_stale)) return;
  const auto all = listeners;  // a listener may leave meanwhile
  for (const auto& l : all)
    if (l->of_records() ? record_stale : state_stale) l->send();
  if (record_stale) last_record = std::chrono::steady_clock::now();
  state_stale = record_stale = false;
  pausing = true;
  pause.expires_after(least_pause);
  pause.async_wait([this](error_code e) {
    if (e) return;
    pausing = false;
    send_news();
  });
}

void HttpServer::Impl::close_all() {
  error_code ignored;
  acceptor.close(ignored);
  for (const auto& one : std::set(clients)) one->close();
  for (const auto& one : std::vector(visitors)) one->close();
  const auto l = listeners;
  for (const auto& one : l) one->close();
  io.stop();
}

HttpServer::HttpServer(const std::string& address, std::uint16_t port, Handlers handlers)
    : impl_(std::make_unique<Impl>(address, port, std::move(handlers))) {}

HttpServer::~HttpServer() = default;

std::uint16_t HttpServer::port() const {
  return impl_->acceptor.local_endpoint().port();
}

void HttpServer::changed() {
  asio::post(impl_->io, [this] {
    impl_->state_stale = true;
    impl_->send_news();
  });
}
void HttpServer::recorded() {
  asio::post(impl_->io, [this] {
    impl_->record_stale = impl_->state_stale = true;
    // a shot does not wait behind what was sent while it was fired; shots themselves keep the pause
    if (std::chrono::steady_clock::now() - impl_->last_record >= least_pause) impl_->pausing = false;
    impl_->send_news();
  });
}

void HttpServer::serve(bool until_interrupted) {
  asio::signal_set signals(impl_->io);
  if (until_interrupted) {
    signals.add(SIGINT);
    signals.add(SIGTERM);
    signals.async_wait([this](error_code e, int) {
      if (!e) impl_->close_all();
    });
  }
  impl_->accept();
  impl_->io.run();
  impl_->workers.join();
  impl_->stopper.join();
}

void HttpServer::stop() {
  asio::post(impl_->io, [this] { impl_->close_all(); });
}

}  // namespace powbench::host
