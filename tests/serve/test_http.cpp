#include <sys/resource.h>

#include <atomic>
#include <boost/asio/connect.hpp>
#include <boost/asio/ip/tcp.hpp>
#include <boost/beast/core.hpp>
#include <boost/beast/http.hpp>
#include <boost/beast/websocket.hpp>
#include <catch2/catch.hpp>
#include <optional>
#include <thread>

#include "core/random.h"
#include "host/serve/http.h"
#include "tests/waiting.h"

/// The server alone, with handlers of words.

namespace asio = boost::asio;
namespace beast = boost::beast;
namespace http = beast::http;
using powbench::host::HttpServer;
using powbench::host::Reply;
using powbench::host::Request;
using powbench::test::wait_until;
using tcp = asio::ip::tcp;

namespace {

/// Answers with what it got; "/slow" waits until it is let go.
struct Server {
  Server()
      : server("127.0.0.1", 0,
               {[this](const Request& r) { return answer(r); },
                [](const Request& r) { return r.path == "/api/stop"; },
                [](const Request& r) {
                  Reply reply;
                  reply.status = r.link_token == "good" ? 200 : 401;
                  return reply;
                },
                [this] { return "state " + std::to_string(number.load()); },
                [this] {
                  const int n = records;
                  return n == 0 ? nullptr
                                : std::make_shared<const std::string>("record " + std::to_string(n));
                }}),
        thread([this] { server.serve(false); }) {}
  ~Server() {
    released = true;
    server.stop();
    thread.join();
  }

  Reply answer(const Request& r) {
    if (r.path == "/slow") {
      ++slow;
      wait_until("the release of the slow ones", [this] { return released.load(); });
    }
    Reply reply;
    reply.type = "text/plain";
    reply.body = r.method + " " + r.path + " " + std::to_string(r.body.size()) + " " + r.link_token;
    return reply;
  }

  tcp::socket connect() {
    tcp::socket socket(io);
    socket.connect({asio::ip::make_address("127.0.0.1"), server.port()});
    return socket;
  }
  http::response<http::string_body> ask(const std::string& method, const std::string& target,
                                        const std::string& body = {}) {
    beast::tcp_stream stream(connect());
    http::request<http::string_body> r(http::string_to_verb(method), target, 11);
    r.set(http::field::host, "x");
    r.body() = body;
    r.prepare_payload();
    beast::error_code e;
    http::write(stream, r, e);
    beast::flat_buffer buffer;
    http::response<http::string_body> reply;
    http::read(stream, buffer, reply);
    return reply;
  }

  std::atomic<bool> released = false;
  std::atomic<int> slow = 0, number = 0, records = 0;
  asio::io_context io;
  HttpServer server;
  std::thread thread;
};

/// Files that this process may have open while the object lives; Server looks at it when it begins.
class FileLimit {
 public:
  explicit FileLimit(rlim_t n) {
    REQUIRE(getrlimit(RLIMIT_NOFILE, &before_) == 0);
    rlimit limit = before_;
    limit.rlim_cur = n;
    REQUIRE(setrlimit(RLIMIT_NOFILE, &limit) == 0);
  }
  ~FileLimit() { setrlimit(RLIMIT_NOFILE, &before_); }
  FileLimit(const FileLimit&) = delete;
  FileLimit& operator=(const FileLimit&) = delete;

 private:
  rlimit before_{};
};

}  // namespace

TEST_CASE("HTTP: requests, tokens and the header fields of a reply", "[serve]") {
  Server s;
  const auto reply = s.ask("POST", "/a?token=t1", "12345");
  CHECK(reply.result_int() == 200);
  CHECK(reply.body() == "POST /a 5 t1");
  CHECK(reply["X-Content-Type-Options"] == "nosniff");
  CHECK(reply["Content-Security-Policy"].find("script-src 'self'") != beast::string_view::npos);
  CHECK(reply["Content-Security-Policy"].find("unsafe-eval") == beast::string_view::npos);
}

TEST_CASE("HTTP: HEAD is GET without its body, and the connection goes on", "[serve]") {
  Server s;
  const std::string body = s.ask("GET", "/a?token=t1").body();
  CHECK(body == "GET /a 0 t1");
  beast::tcp_stream stream(s.connect());
  for (int k = 0; k < 2; ++k) {
    http::request<http::empty_body> r(http::verb::head, "/a?token=t1", 11);
    r.set(http::field::host, "x");
    http::write(stream, r);
    beast::flat_buffer buffer;
    http::response_parser<http::string_body> reply;
    reply.skip(true);
    http::read(stream, buffer, reply);
    CHECK(reply.get().result_int() == 200);
    CHECK(reply.get()["Content-Length"] == std::to_string(body.size()));
    CHECK(buffer.size() == 0);
  }
}

TEST_CASE("HTTP: a body that is too large is refused, in one piece and in many", "[serve]") {
  Server s;
  CHECK(s.ask("POST", "/a", std::string(HttpServer::largest_body, 'x')).result_int() == 200);
  CHECK(s.ask("POST", "/a", std::string(HttpServer::largest_body + 1, 'x')).result_int() == 413);
  // announced only, and sent without an end
  for (const std::string& head :
       {std::string("POST /a HTTP/1.1\r\nHost: x\r\nContent-Length: 99999999999\r\n\r\n"),
        "POST /a HTTP/1.1\r\nHost: x\r\nX: " + std::string(100'000, 'h')}) {
    tcp::socket socket = s.connect();
    beast::error_code e;
    asio::write(socket, asio::buffer(head), e);
    std::string answer(4096, '\0');
    const std::size_t n = socket.read_some(asio::buffer(answer), e);
    CHECK(answer.substr(0, n).find("413") != std::string::npos);
  }
}

TEST_CASE("HTTP: a request in pieces of one byte, two in one piece, and what is none", "[serve]") {
  Server s;
  {
    tcp::socket socket = s.connect();
    socket.set_option(tcp::no_delay(true));
    for (const char c : std::string("POST /b HTTP/1.1\r\nHost: x\r\nContent-Length: 3\r\n\r\nabc"))
      asio::write(socket, asio::buffer(&c, 1));
    beast::flat_buffer buffer;
    http::response<http::string_body> reply;
    http::read(socket, buffer, reply);
    CHECK(reply.body() == "POST /b 3 ");
    const std::string two = "GET /c HTTP/1.1\r\nHost: x\r\n\r\nGET /d HTTP/1.1\r\nHost: x\r\n\r\n";
    asio::write(socket, asio::buffer(two));
    for (const char* expected : {"GET /c 0 ", "GET /d 0 "}) {
      http::response<http::string_body> next;
      http::read(socket, buffer, next);
      CHECK(next.body() == expected);
    }
  }
  powbench::Random random(3);
  for (int i = 0; i < 200; ++i) {
    tcp::socket socket = s.connect();
    std::string noise;
    const auto bytes = static_cast<std::size_t>(1 + random.uniform() * 400);
    for (std::size_t k = 0; k < bytes; ++k) noise += static_cast<char>(random.uniform() * 256);
    beast::error_code e;
    asio::write(socket, asio::buffer(noise), e);
  }
  CHECK(s.ask("GET", "/after").body() == "GET /after 0 ");
}

TEST_CASE("HTTP: a stop waits behind nothing: slow requests, a thousand idle connections", "[serve]") {
  rlimit limit{};
  REQUIRE(getrlimit(RLIMIT_NOFILE, &limit) == 0);
  limit.rlim_cur = std::min<rlim_t>(limit.rlim_max, 4096);
  setrlimit(RLIMIT_NOFILE, &limit);
  const int idle = limit.rlim_cur >= 2200 ? 1000 : static_cast<int>(limit.rlim_cur) / 4;
  Server s;
  std::vector<tcp::socket> sockets;
  for (int i = 0; i < idle; ++i) sockets.push_back(s.connect());
  for (int i = 0; i < 8; ++i) {
    sockets.push_back(s.connect());
    asio::write(sockets.back(), asio::buffer(std::string("GET /slow HTTP/1.1\r\nHost: x\r\n\r\n")));
  }
  wait_until("both workers to be busy", [&] { return s.slow == 2; });
  CHECK(s.ask("POST", "/api/stop").body() == "POST /api/stop 0 ");
}

TEST_CASE("HTTP: a stop has a place when all connections are taken, and nothing else has", "[serve]") {
  std::optional<FileLimit> few(292);  // leaves a hundred connections
  Server s;
  few.reset();  // this process has both ends of each
  std::vector<tcp::socket> sockets;
  for (int i = 0; i < 110; ++i) sockets.push_back(s.connect());
  CHECK(s.ask("POST", "/api/stop").body() == "POST /api/stop 0 ");
  const auto reply = s.ask("GET", "/a");
  CHECK(reply.result_int() == 503);
  CHECK(reply.body().find("all connections are taken") != std::string::npos);
  sockets.clear();
  wait_until("a place to fall free", [&] { return s.ask("GET", "/a").result_int() == 200; });
}

TEST_CASE("HTTP: a stop has a place behind any number of connections that say nothing", "[serve]") {
  std::optional<FileLimit> few(292);  // leaves a hundred connections, and 64 that may only stop
  Server s;
  few.reset();
  std::vector<tcp::socket> sockets;
  for (int i = 0; i < 220; ++i) sockets.push_back(s.connect());
  for (int i = 0; i < 3; ++i) {
    CHECK(s.ask("POST", "/api/stop").body() == "POST /api/stop 0 ");
    for (int k = 0; k < 70; ++k) sockets.push_back(s.connect());
  }
}

TEST_CASE("WebSocket: the newest state, and only to those who may", "[serve]") {
  Server s;
  namespace websocket = beast::websocket;
  {
    websocket::stream<tcp::socket> socket(s.connect());
    beast::error_code e;
    socket.handshake("x", "/api/live", e);
    CHECK(e);
  }
  websocket::stream<tcp::socket> socket(s.connect());
  socket.handshake("x", "/api/live?token=good");
  const auto next = [&] {
    beast::flat_buffer buffer;
    socket.read(buffer);
    return beast::buffers_to_string(buffer.data());
  };
  CHECK(next() == "state 0");
  // many changes become few messages; the last one arrives
  for (int i = 1; i <= 1000; ++i) {
    s.number = i;
    s.server.changed();
  }
  int messages = 1;
  while (next() != "state 1000") ++messages;
  CHECK(messages < 500);
  // what a client says is thrown away; too much of it ends the connection
  socket.write(asio::buffer(std::string("hello")));
  s.number = 1001;
  s.server.changed();
  CHECK(next() == "state 1001");
  beast::error_code e;
  socket.write(asio::buffer(std::string(100'000, 'x')), e);
  wait_until("the end of the connection", [&] {
    beast::flat_buffer buffer;
    socket.read(buffer, e);
    return static_cast<bool>(e);
  });
}

TEST_CASE("WebSocket: the newest record, in binary, and states go elsewhere", "[serve]") {
  Server s;
  namespace websocket = beast::websocket;
  {
    websocket::stream<tcp::socket> socket(s.connect());
    beast::error_code e;
    socket.handshake("x", "/api/scope", e);
    CHECK(e);
  }
  websocket::stream<tcp::socket> scope(s.connect()), state(s.connect());
  scope.handshake("x", "/api/scope?token=good");  // no record yet: nothing comes
  state.handshake("x", "/api/live?token=good");
  const auto next = [](websocket::stream<tcp::socket>& socket) {
    beast::flat_buffer buffer;
    socket.read(buffer);
    return beast::buffers_to_string(buffer.data());
  };
  CHECK(next(state) == "state 0");
  s.number = 7;
  s.server.changed();
  CHECK(next(state) == "state 7");
  for (int i = 1; i <= 500; ++i) {
    s.records = i;
    s.server.recorded();
  }
  int messages = 1;
  while (next(scope) != "record 500") ++messages;
  CHECK(scope.got_binary());
  CHECK(messages < 250);
  // with each record a state that names it, no more often than records; no record came in between
  s.number = 8;
  s.server.changed();
  int states = 0;
  for (std::string one = next(state); one != "state 8"; one = next(state)) {
    REQUIRE(one == "state 7");
    REQUIRE(++states < 250);
  }
  // who comes later gets the newest one at once
  websocket::stream<tcp::socket> late(s.connect());
  late.handshake("x", "/api/scope?token=good");
  CHECK(next(late) == "record 500");
}
