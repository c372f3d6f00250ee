#include "tests/system/browser.h"

#include <fcntl.h>
#include <sys/wait.h>
#include <unistd.h>

#include <boost/asio/connect.hpp>
#include <boost/asio/ip/tcp.hpp>
#include <boost/beast/core.hpp>
#include <boost/beast/http.hpp>
#include <boost/beast/websocket.hpp>
#include <csignal>

#include "host/gather/pdf.h"
#include "tests/waiting.h"

namespace powbench::test {
namespace {

namespace asio = boost::asio;
namespace beast = boost::beast;
namespace http = beast::http;
using asio::ip::tcp;
using nlohmann::json;

const auto loopback = asio::ip::make_address("127.0.0.1");

std::string bytes_of(const std::string& base64) {
  std::string out;
  unsigned held = 0;
  int bits = 0;
  for (const char c : base64) {
    const auto at =
        std::string_view("ABCDEFGHIJKLMNOPQRSTUVWXYZabcdefghijklmnopqrstuvwxyz0123456789+/").find(c);
    if (at == std::string_view::npos) break;
    held = held << 6 | static_cast<unsigned>(at);
    if ((bits += 6) < 8) continue;
    bits -= 8;
    out += static_cast<char>(held >> bits & 0xFF);
  }
  return out;
}

}  // namespace

struct Tab::Impl {
  asio::io_context io;
  beast::websocket::stream<tcp::socket> socket{io};
  int last_call = 0;
  std::vector<std::string> errors, requests;

  void note(const json& message) {
    const std::string method = message.value("method", "");
    if (method == "Runtime.exceptionThrown") errors.push_back(message.dump());
    if (method == "Log.entryAdded" && message["params"]["entry"]["level"] == "error")
      errors.push_back(message["params"]["entry"].dump());
    if (method == "Runtime.consoleAPICalled" && message["params"]["type"] == "error")
      errors.push_back(message.dump());
    if (method == "Network.requestWillBeSent") requests.push_back(message["params"]["request"]["url"]);
  }
};

Tab::Tab(unsigned port, const std::string& path) : impl_(std::make_unique<Impl>()) {
  impl_->socket.next_layer().connect({loopback, static_cast<std::uint16_t>(port)});
  impl_->socket.read_message_max(0);
  impl_->socket.handshake("127.0.0.1:" + std::to_string(port), path);
  for (const char* domain : {"Runtime.enable", "Log.enable", "Network.enable", "Page.enable"}) call(domain);
}
Tab::~Tab() = default;
Tab::Tab(Tab&&) noexcept = default;

json Tab::call(const std::string& method, const json& parameters) {
  const int id = ++impl_->last_call;
  impl_->socket.write(asio::buffer(json{{"id", id}, {"method", method}, {"params", parameters}}.dump()));
  for (;;) {
    beast::flat_buffer buffer;
    impl_->socket.read(buffer);
    json message = json::parse(beast::buffers_to_string(buffer.data()));
    if (message.value("id", 0) == id) {
      if (message.contains("error")) throw std::runtime_error(method + ": " + message["error"].dump());
      return message["result"];
    }
    impl_->note(message);
  }
}

json Tab::value(const std::string& expression) {
  const json result =
      call("Runtime.evaluate", {{"expression", expression}, {"awaitPromise", true}, {"returnByValue", true}});
  if (result.contains("exceptionDetails"))
    throw std::runtime_error(expression + ": " + result["exceptionDetails"].dump());
  return result["result"].value("value", json());
}

void Tab::until(const std::string& expression) {
  wait_until(expression, [&] {
    try {
      return value("(async()=>Boolean(await (" + expression + ")))()") == true;
    } catch (const std::runtime_error&) {
      return false;  // the page is being loaded
    }
  });
}

void Tab::go(const std::string& url) {
  call("Page.navigate", {{"url", url}});
  until("location.href !== 'about:blank' && document.readyState === 'complete'");
}

void Tab::key(const std::string& name) {
  call("Page.bringToFront");
  json k = {{"type", "keyDown"}, {"key", name}};
  if (name == "Escape") k["windowsVirtualKeyCode"] = 27;
  if (name == "Tab") k["windowsVirtualKeyCode"] = 9;
  if (name == "Enter") k.update({{"windowsVirtualKeyCode", 13}, {"text", "\r"}});
  if (name == "ArrowRight") k["windowsVirtualKeyCode"] = 39;
  if (name == "ArrowDown") k["windowsVirtualKeyCode"] = 40;
  if (name.size() == 1) k["text"] = name;
  call("Input.dispatchKeyEvent", k);
  k["type"] = "keyUp";
  k.erase("text");
  call("Input.dispatchKeyEvent", k);
}

void Tab::size(int width, int height) {
  call("Emulation.setDeviceMetricsOverride",
       {{"width", width}, {"height", height}, {"deviceScaleFactor", 1}, {"mobile", width < 600}});
}

void Tab::dark(bool on) {
  const json scheme = {{"name", "prefers-color-scheme"}, {"value", on ? "dark" : "light"}};
  call("Emulation.setEmulatedMedia", {{"features", {scheme}}});
}

void Tab::picture(const std::string& file) {
  call("Page.bringToFront");  // as whoever looks at it has it
  std::ofstream(file, std::ios::binary)
      << bytes_of(call("Page.captureScreenshot", {{"format", "png"}})["data"]);
}

std::vector<std::string> Tab::fonts(const std::string& selector) {
  call("DOM.enable");
  call("CSS.enable");
  const json root = call("DOM.getDocument")["root"]["nodeId"];
  const json node = call("DOM.querySelector", {{"nodeId", root}, {"selector", selector}})["nodeId"];
  const json drawn = call("CSS.getPlatformFontsForNode", {{"nodeId", node}});
  std::vector<std::string> names;
  for (const json& font : drawn["fonts"]) names.push_back(font["familyName"]);
  return names;
}

double Tab::heap() {
  call("HeapProfiler.collectGarbage");
  return call("Runtime.getHeapUsage")["usedSize"];
}

const std::vector<std::string>& Tab::errors() const {
  return impl_->errors;
}
const std::vector<std::string>& Tab::requests() const {
  return impl_->requests;
}

Browser::Browser(const Folder& folder) {
  const std::string program = host::find_browser();
  if (program.empty()) throw std::runtime_error("no browser; ./dev test --slow installs one");
  const std::string profile = folder.file("profile");
  pid_ = fork();
  if (pid_ == 0) {
    setpgid(0, 0);
    const int nowhere = ::open("/dev/null", O_RDWR);
    for (const int fd : {0, 1, 2}) dup2(nowhere, fd);
    const std::string data = "--user-data-dir=" + profile;
    const char* sandbox = geteuid() == 0 ? "--no-sandbox" : "--no-first-run";
    execl(program.c_str(), program.c_str(), "--headless", "--disable-gpu", "--remote-debugging-port=0",
          sandbox, data.c_str(), "about:blank", static_cast<char*>(nullptr));
    _exit(127);
  }
  const std::string told = profile + "/DevToolsActivePort";
  wait_until("the browser's debugging port", [&] {
    std::istringstream text(read_file(told));
    return static_cast<bool>(text >> port_) && port_ > 0;
  });
}

Browser::~Browser() {
  if (pid_ <= 0) return;
  kill(-pid_, SIGKILL);
  waitpid(pid_, nullptr, 0);
}

Tab Browser::open(const std::string& url) {
  asio::io_context io;
  tcp::socket socket(io);
  socket.connect({loopback, static_cast<std::uint16_t>(port_)});
  http::request<http::empty_body> request(http::verb::put, "/json/new?about:blank", 11);
  request.set(http::field::host, "127.0.0.1:" + std::to_string(port_));
  http::write(socket, request);
  beast::flat_buffer buffer;
  http::response<http::string_body> reply;
  http::read(socket, buffer, reply);
  const std::string address = json::parse(reply.body()).at("webSocketDebuggerUrl");
  Tab tab(port_, address.substr(address.find('/', 5 + 2)));
  tab.go(url);
  return tab;
}

}  // namespace powbench::test
