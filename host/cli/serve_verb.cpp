#include <fmt/format.h>
#include <sys/resource.h>

#include <atomic>
#include <charconv>

#include "host/cli/verbs.h"
#include "host/serve/api.h"
#include "host/serve/bench.h"
#include "host/serve/http.h"

namespace powbench::host {

namespace {

struct Address {
  std::string ip;
  std::uint16_t port = 0;
};

Address parse_address(const std::string& text) {
  const auto colon = text.rfind(':');
  Address a{text.substr(0, colon), 0};
  unsigned port = 70'000;
  if (colon != std::string::npos) {
    const char* end = text.data() + text.size();
    const auto [stop, error] = std::from_chars(text.data() + colon + 1, end, port);
    if (error != std::errc{} || stop != end) port = 70'000;
  }
  if (a.ip.starts_with('[') && a.ip.ends_with(']')) a.ip = a.ip.substr(1, a.ip.size() - 2);
  if (a.ip.empty() || port > 65'535)
    throw BadInput(
        {"--listen " + text + ": is ADDRESS:PORT, such as 127.0.0.1:8080; port 0 is any free one"});
  a.port = static_cast<std::uint16_t>(port);
  return a;
}

/// Until somebody writes another one.
constexpr const char* first_plan =
    "name = \"six angles\"\nangles_deg = [0, 30, 60, 90, 120, 150]\nrepeats = 3\n";

/// Each page takes a descriptor or two, and the common limit is 1024.
void allow_many_files() {
  rlimit limit{};
  if (getrlimit(RLIMIT_NOFILE, &limit) != 0) return;
  limit.rlim_cur = limit.rlim_max;
  setrlimit(RLIMIT_NOFILE, &limit);
}

bool loopback(const std::string& ip) {
  return ip.starts_with("127.") || ip == "::1";
}

}  // namespace

Exit serve_bench(const LiveArgs& args) {
  if (args.rig.empty())
    throw BadInput({"serve: no rig is named; --rig sim: is a simulated one, powbench rigs lists the others"});
  const Address address = parse_address(args.listen);
  if (!loopback(address.ip) && args.token_file.empty())
    throw BadInput(
        {fmt::format("--listen {}: others can reach this address; name a --token-file with lines 'fire "
                     "TOKEN' and 'read TOKEN', "
                     "or listen on 127.0.0.1",
                     args.listen)});
  const Scene scene = args.plan.empty() ? make_scene(parse_plan(first_plan, "plan")) : load_scene(args.plan);

  std::atomic<HttpServer*> told = nullptr;
  auto bench = std::make_unique<Bench>(
      args.rig, scene, args.database,
      [&] {
        if (HttpServer* server = told) server->changed();
      },
      [&] {
        if (HttpServer* server = told) server->recorded();
      });
  std::unique_ptr<Api> api;
  allow_many_files();
  HttpServer server(address.ip, address.port,
                    {[&](const Request& r) { return api->answer(r); }, Api::is_stop,
                     [&](const Request& r) { return api->listen(r); }, [&] { return bench->state(); },
                     [&] { return bench->frame(); }});
  const std::string ip = address.ip.find(':') == std::string::npos ? address.ip : "[" + address.ip + "]";
  const std::string place = fmt::format("{}:{}", ip, server.port());
  std::vector<std::string> hosts{place};
  if (loopback(address.ip)) hosts.push_back(fmt::format("localhost:{}", server.port()));
  api = std::make_unique<Api>(
      *bench, args.token_file.empty() ? Access::made(hosts) : Access::from_file(args.token_file, hosts),
      args.plan);
  told = &server;
  fmt::print(stderr, "live bench on http://{}/, store {}; stop with Ctrl-C\n", place, args.database);
  if (!api->access().page_token().empty())
    fmt::print(stderr, "scripts that fire send Authorization: Bearer {}\n", api->access().page_token());
  server.serve(true);
  bench->stop();
  bench.reset();  // before the server that it tells of its changes
  fmt::print(stderr, "stopped\n");
  return Exit::pass;
}

}  // namespace powbench::host
