#include <fmt/format.h>
#include <sys/wait.h>
#include <unistd.h>

#include <algorithm>
#include <atomic>
#include <boost/asio/ip/tcp.hpp>
#include <boost/beast/core.hpp>
#include <boost/beast/http.hpp>
#include <boost/beast/websocket.hpp>
#include <chrono>
#include <cstdlib>
#include <ctime>
#include <filesystem>
#include <fstream>
#include <mutex>
#include <nlohmann/json.hpp>
#include <thread>

#include "host/serve/api.h"
#include "host/serve/bench.h"
#include "host/serve/frame.h"
#include "host/serve/http.h"

/// The live bench over loopback: from the click to the picture's data, the stop while a plan runs and while reports
/// are made, size of the page, memory after many shots.
/// Usage: bench_live_bench [--shots N] [--json PATH]

namespace {

using namespace powbench;
using namespace powbench::host;
namespace asio = boost::asio;
namespace beast = boost::beast;
namespace http = beast::http;
using SteadyClock = std::chrono::steady_clock;
using Json = nlohmann::ordered_json;

double ms_since(SteadyClock::time_point t) {
  return std::chrono::duration<double, std::milli>(SteadyClock::now() - t).count();
}

struct Spread {
  double median = 0, p95 = 0, worst = 0;
};
Spread spread(std::vector<double> v) {
  std::sort(v.begin(), v.end());
  return {v[v.size() / 2], v[v.size() * 95 / 100], v.back()};
}

double resident_mb() {
  std::ifstream in("/proc/self/status");
  for (std::string line; std::getline(in, line);)
    if (line.starts_with("VmRSS:")) return std::stod(line.substr(6)) / 1024;
  return 0;
}

/// One connection that stays.
class Client {
 public:
  Client(std::uint16_t port, std::string token)
      : token_(std::move(token)), host_(fmt::format("127.0.0.1:{}", port)) {
    socket_.connect({asio::ip::make_address("127.0.0.1"), port});
    socket_.set_option(asio::ip::tcp::no_delay(true));
  }
  std::string ask(http::verb method, const std::string& target, const std::string& body = {}) {
    http::request<http::string_body> r(method, target, 11);
    r.set(http::field::host, host_);
    r.set(http::field::authorization, "Bearer " + token_);
    r.set(http::field::content_type, "application/json");
    r.body() = body;
    r.prepare_payload();
    http::write(socket_, r);
    http::response_parser<http::string_body> reply;
    reply.body_limit(100'000'000);
    http::read(socket_, buffer_, reply);
    return reply.get().body();
  }

 private:
  std::string token_, host_;
  asio::io_context io_;
  asio::ip::tcp::socket socket_{io_};
  beast::flat_buffer buffer_;
};

void wait_for_shot(Client& client, int more_than) {
  for (;;) {
    const Json state = Json::parse(client.ask(http::verb::get, "/api/bench"));
    if (!state["newest_shot"].is_null() && state["newest_shot"] > more_than && state["job"].is_null()) return;
    std::this_thread::sleep_for(std::chrono::milliseconds(1));
  }
}

/// Processor time of this whole program, s.
double cpu_seconds() {
  timespec t{};
  clock_gettime(CLOCK_PROCESS_CPUTIME_ID, &t);
  return static_cast<double>(t.tv_sec) + 1e-9 * static_cast<double>(t.tv_nsec);
}

struct Streamed {
  double per_second = 0, core_percent = 0;
};
/// Records of 6 channels x 20 000 points, packed and sent as fast as the server lets them go for `seconds`, to a
/// client in another process, so that the processor time is the server's alone.
Streamed stream_records(double seconds) {
  Record record;
  record.sample_rate = 100e3;
  for (std::size_t c = 0; c < 6; ++c) {
    ChannelRecord channel;
    channel.channel = static_cast<Channel>(c);
    for (int i = 0; i < 20'000; ++i) channel.raw.push_back(static_cast<std::int16_t>(i * (c + 1)));
    record.channels.push_back(std::move(channel));
  }
  std::mutex mutex;
  std::shared_ptr<const std::string> newest;
  HttpServer server("127.0.0.1", 0,
                    {[](const Request&) { return Reply{}; }, [](const Request&) { return false; },
                     [](const Request&) { return Reply{}; }, [] { return std::string("{}"); },
                     [&] {
                       const std::scoped_lock lock(mutex);
                       return newest;
                     }});
  int counted[2];
  if (pipe(counted) != 0) return {};
  const pid_t child = fork();
  if (child == 0) {
    asio::io_context io;
    beast::websocket::stream<asio::ip::tcp::socket> socket(io);
    socket.next_layer().connect({asio::ip::make_address("127.0.0.1"), server.port()});
    socket.read_message_max(0);
    int frames = 0;
    try {
      socket.handshake("x", "/api/scope");
      for (;;) {
        beast::flat_buffer buffer;
        socket.read(buffer);
        if (buffer.size() > 240'000) ++frames;
      }
    } catch (const std::exception&) {
    }
    const auto written = write(counted[1], &frames, sizeof frames);
    _exit(written == sizeof frames ? 0 : 1);
  }
  std::thread thread([&] { server.serve(false); });
  const double cpu = cpu_seconds();
  const auto begun = SteadyClock::now();
  for (std::int64_t shot = 1; ms_since(begun) < 1e3 * seconds; ++shot) {
    auto frame = std::make_shared<const std::string>(record_frame(record, shot, "SIMULATED RIG"));
    {
      const std::scoped_lock lock(mutex);
      newest = std::move(frame);
    }
    server.recorded();
    std::this_thread::sleep_for(std::chrono::milliseconds(40));
  }
  const double wall = ms_since(begun) / 1e3, used = cpu_seconds() - cpu;
  server.stop();
  thread.join();
  int frames = 0;
  if (read(counted[0], &frames, sizeof frames) != sizeof frames) frames = 0;
  waitpid(child, nullptr, 0);
  return {frames / wall, 100 * used / wall};
}

}  // namespace

int main(int argc, char** argv) {
  int many = 2000;
  std::string json_file;
  for (int i = 1; i + 1 < argc; i += 2) {
    if (std::string(argv[i]) == "--json") json_file = argv[i + 1];
    if (std::string(argv[i]) == "--shots") many = std::stoi(argv[i + 1]);
  }
  const Streamed streamed = stream_records(5);  // first: it forks, and there are no other threads yet
  std::string folder = (std::filesystem::temp_directory_path() / "powbench-live-XXXXXX").string();
  if (mkdtemp(folder.data()) == nullptr) return 1;
  const Scene scene = make_scene(parse_plan("angles_deg = [0, 30, 60, 90]\nrepeats = 5\n", "plan"));
  std::atomic<HttpServer*> told = nullptr;
  auto bench = std::make_unique<Bench>("sim:", scene, folder + "/lab.db", [&] {
    if (HttpServer* s = told) s->changed();
  });
  std::unique_ptr<Api> api;
  HttpServer server("127.0.0.1", 0,
                    {[&](const Request& r) { return api->answer(r); }, Api::is_stop,
                     [&](const Request& r) { return api->listen(r); }, [&] { return bench->state(); },
                     [&] { return bench->frame(); }});
  api = std::make_unique<Api>(*bench, Access::made({fmt::format("127.0.0.1:{}", server.port())}));
  told = &server;
  std::thread thread([&] { server.serve(false); });
  const std::string token = api->access().page_token();
  Client client(server.port(), token);

  std::size_t page = 0;
  for (const char* part :
       {"/", "/base.js", "/choice.js", "/conditions.js", "/quantities.js", "/page.js", "/test.js",
        "/parameters.js", "/documents.js", "/rig.js", "/trend.js", "/page.css", "/chart.js"})
    page += client.ask(http::verb::get, part).size();

  // by a script, that fires at once, and by a person, whose page tells the angle while the person still looks at it
  std::vector<double> to_shot, to_picture, awaited;
  for (int i = 0; i < 80; ++i) {
    const bool told_before = i % 2 == 1;
    const Json before = Json::parse(client.ask(http::verb::get, "/api/bench"));
    const int last = before["newest_shot"].is_null() ? 0 : before["newest_shot"].get<int>();
    const std::string angle = fmt::format(R"({{"angle_deg": {}}})", 4.5 * i);
    if (told_before) {
      client.ask(http::verb::post, "/api/prepare", angle);
      std::this_thread::sleep_for(std::chrono::milliseconds(500));
    }
    const auto begun = SteadyClock::now();
    client.ask(http::verb::post, "/api/fire", angle);
    wait_for_shot(client, last);
    if (!told_before) to_shot.push_back(ms_since(begun));
    client.ask(http::verb::get, fmt::format("/api/shots/{}", last + 1));
    client.ask(http::verb::get, fmt::format("/api/shots/{}/closing", last + 1));
    (told_before ? awaited : to_picture).push_back(ms_since(begun));
  }

  std::vector<double> stops, loaded;
  for (int round = 0; round < 60; ++round) {
    const bool load = round % 2 == 1;
    client.ask(http::verb::post, "/api/plan/run",
               Json{{"text", "angles_deg = [0, 90]\nrepeats = 100\n"}}.dump());
    std::vector<std::thread> readers;
    if (load)
      for (int k = 0; k < 4; ++k)
        readers.emplace_back([&] {
          Client reader(server.port(), token);
          reader.ask(http::verb::get, "/api/campaigns/1/report.html");
        });
    std::this_thread::sleep_for(std::chrono::milliseconds(10 + 3 * round));
    const auto begun = SteadyClock::now();
    const Json answer = Json::parse(client.ask(http::verb::post, "/api/stop"));
    (load ? loaded : stops).push_back(ms_since(begun));
    if (answer["off"] != true) fmt::print("NOT CONFIRMED: {}\n", answer.dump());
    for (auto& r : readers) r.join();
    while (!Json::parse(client.ask(http::verb::get, "/api/bench"))["job"].is_null())
      std::this_thread::sleep_for(std::chrono::milliseconds(1));
  }

  // a plan of its size comes before the first look: what a plan takes is kept for the next
  const auto run_plan = [&] {
    client.ask(http::verb::post, "/api/plan/run",
               Json{{"text", "angles_deg = [0, 90]\nrepeats = 500\n"}}.dump());
    while (!Json::parse(client.ask(http::verb::get, "/api/bench"))["job"].is_null())
      std::this_thread::sleep_for(std::chrono::milliseconds(20));
  };
  run_plan();
  const double before = resident_mb();
  for (int plan = 0; plan < many / 1000; ++plan) run_plan();
  const double after = resident_mb();
  const auto listed_from = SteadyClock::now();
  client.ask(http::verb::get, "/api/campaigns");
  const double listed = ms_since(listed_from);
  server.stop();
  thread.join();
  bench.reset();
  std::filesystem::remove_all(folder);

  const Spread shot = spread(to_shot), picture = spread(to_picture), stop = spread(stops),
               early = spread(awaited), busy = spread(loaded);
  fmt::print("live bench over loopback, simulated rig; wall time, ms\n\n{:<58} {:>8} {:>8} {:>8}   {}\n", "",
             "median", "95 %", "worst", "goal");
  const auto row = [](const char* what, const Spread& s, const char* goal) {
    fmt::print("{:<58} {:>8.1f} {:>8.1f} {:>8.1f}   {}\n", what, s.median, s.p95, s.worst, goal);
  };
  row("fire to stored and simulated", shot, "");
  row("fire to all data of the picture", picture, "150");
  row("the same, the angle known 0.5 s before, as from the page", early, "150");
  row("stop in mid-plan, until the rig has confirmed", stop, "100");
  row("the same while four reports are made", busy, "100");
  fmt::print("\npage, all parts, uncompressed: {:.0f} kB (goal 400 compressed)\n",
             static_cast<double>(page) / 1e3);
  fmt::print("resident memory: {:.0f} MB before, {:.0f} MB after {} more shots in plans of 1000\n", before,
             after, many);
  fmt::print(
      "records of 6 x 20000 points to a page: {:.1f} a second (goal 20), {:.0f} % of one core (goal 50)\n",
      streamed.per_second, streamed.core_percent);
  fmt::print("list of all campaigns then: {:.1f} ms\n", listed);
  if (!json_file.empty()) {
    const auto j = [](const Spread& s) {
      return Json{{"median", s.median}, {"p95", s.p95}, {"worst", s.worst}};
    };
    std::ofstream(json_file) << Json{{"fire_to_shot_ms", j(shot)},
                                     {"fire_to_picture_ms", j(picture)},
                                     {"fire_to_picture_prepared_ms", j(early)},
                                     {"stop_ms", j(stop)},
                                     {"stop_loaded_ms", j(busy)},
                                     {"page_bytes", page},
                                     {"resident_before_mb", before},
                                     {"resident_after_mb", after},
                                     {"shots", many},
                                     {"records_per_s", streamed.per_second},
                                     {"records_core_percent", streamed.core_percent},
                                     {"list_ms", listed}}
                                    .dump(2)
                             << "\n";
  }
}
