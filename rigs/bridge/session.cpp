#include "rigs/bridge/session.h"

#include <algorithm>
#include <array>

#include "firmware/iiod/model.h"

namespace powbench::rigs::bridge {

namespace asio = boost::asio;
using asio::awaitable;
using firmware::iiod::same_word;
using std::chrono::milliseconds;
using Clock = std::chrono::steady_clock;
using Shape = Expected::Shape;

namespace {

constexpr std::size_t longest_line = 128;      // what a board takes
constexpr std::size_t longest_payload = 4096;  // 44 ms at 921600 baud
constexpr std::size_t piece_bytes = 4096;      // the same for samples
constexpr std::uint32_t default_timeout_ms = 2500;

// sending ahead of what a slow client takes is no use: it stops being read
constexpr std::size_t longest_backlog = 1 << 16;

/// A request as it goes out: with the one line end that every board knows.
std::string to_board(std::string line) {
  if (line.ends_with('\r')) line.pop_back();
  return line + '\n';
}

}  // namespace

const DeviceLayout* Hub::find(std::string_view id_or_name) const {
  for (const DeviceLayout& device : devices)
    if (device.id == id_or_name || device.name == id_or_name) return &device;
  return nullptr;
}

std::uint32_t Hub::timeout_ms() const {
  std::optional<std::uint32_t> shortest;
  for (const auto& session : sessions) {
    const auto ms = session->timeout_ms();
    if (!ms) continue;
    if (!shortest || (*ms != 0 && (*shortest == 0 || *ms < *shortest))) shortest = ms;
  }
  return shortest.value_or(default_timeout_ms);
}

void Hub::close_sessions() {
  const auto all = sessions;
  for (const auto& session : all) session->close();
}

Session::Session(Hub& hub, asio::ip::tcp::socket socket)
    : hub_(hub), socket_(std::move(socket)), inbox_(hub.io) {
  boost::system::error_code ignored;
  socket_.set_option(asio::ip::tcp::no_delay(true), ignored);
}

void Session::start() {
  const auto self = shared_from_this();
  asio::co_spawn(
      hub_.io, [self]() -> awaitable<void> { co_await self->receive(); }, asio::detached);
  asio::co_spawn(
      hub_.io, [self]() -> awaitable<void> { co_await self->serve(); }, asio::detached);
}

void Session::close() {
  boost::system::error_code ignored;
  socket_.shutdown(asio::ip::tcp::socket::shutdown_both, ignored);
  socket_.close(ignored);
  inbox_.close();
}

/// Reads all the time, so that a client that goes away is noticed also while it is owed samples.
awaitable<void> Session::receive() {
  std::array<char, 4096> bytes{};
  asio::steady_timer wait(hub_.io);
  while (!inbox_.closed) {
    boost::system::error_code error;
    const std::size_t n = co_await socket_.async_read_some(asio::buffer(bytes),
                                                           asio::redirect_error(asio::use_awaitable, error));
    if (error) break;
    inbox_.put(bytes.data(), n);
    while (inbox_.bytes.size() > longest_backlog && !inbox_.closed) co_await pause(wait, hub_.options.poll);
  }
  close();
}

awaitable<void> Session::serve() {
  std::string line;
  for (;;) {
    const bool more = co_await next_line(line);
    if (!more) break;
    co_await run(line);
  }
  close();
  if (reader_) co_await close_reader();
  std::erase_if(hub_.sessions, [this](const auto& s) { return s.get() == this; });
}

/// False: the client is gone, or has said so.
awaitable<bool> Session::next_line(std::string& line) {
  for (bool overflow = false;;) {
    const std::size_t end = inbox_.bytes.find('\n');
    if (inbox_.closed) co_return false;
    if (end == std::string::npos) {
      if (inbox_.bytes.size() > longest_line) {
        overflow = true;
        inbox_.bytes.clear();
      }
      co_await inbox_.change(std::chrono::hours(1));
      continue;
    }
    line = inbox_.bytes.substr(0, end);
    inbox_.bytes.erase(0, end + 1);
    if (overflow || line.size() > longest_line) {
      overflow = false;
      co_await send_number(-firmware::iiod::einval);
      continue;
    }
    const Words words(line);
    if (words.count == 0) continue;
    co_return !(same_word(words[0], "EXIT") || same_word(words[0], "QUIT"));
  }
}

/// Answers one request: from here what concerns the connection, from the board what concerns the bench.
awaitable<void> Session::run(std::string line) {
  using firmware::iiod::einval;
  const Words words(line);
  const std::string_view verb = words[0];
  if (words.too_many) {
    co_await send_number(-einval);
  } else if (same_word(verb, "PRINT")) {
    const std::string& xml = hub_.line.description();
    const std::string answer = std::to_string(xml.size()) + "\n" + xml + "\n";
    co_await send(answer);
  } else if (same_word(verb, "VERSION")) {
    const std::string answer = hub_.line.version() + "\n";
    co_await send(answer);
  } else if (same_word(verb, "TIMEOUT")) {
    const auto ms = firmware::parse_int(words[1]);
    const bool valid = ms && *ms >= 0 && *ms <= 3'600'000;
    if (valid) timeout_ms_ = static_cast<std::uint32_t>(*ms);
    co_await send_number(valid ? 0 : -einval);
  } else if (same_word(verb, "READ")) {
    co_await forward(line, Shape::text);
  } else if (same_word(verb, "GETTRIG")) {
    co_await forward(line, Shape::optional_text);
  } else if (same_word(verb, "SETTRIG") || same_word(verb, "SET")) {
    co_await forward(line, Shape::number);
  } else if (same_word(verb, "WRITE")) {
    co_await write(line, words);
  } else if (same_word(verb, "OPEN")) {
    co_await open(line, words);
  } else if (same_word(verb, "READBUF")) {
    co_await readbuf(words);
  } else if (same_word(verb, "CLOSE")) {
    // never another client's buffer
    const DeviceLayout* device = hub_.find(words[1]);
    const bool mine = reader_ && device && device->id == reader_->device;
    if (mine) co_await close_reader();
    co_await send_number(mine ? 0 : -firmware::iiod::ebadf);
  } else {
    co_await send_number(-einval);  // ZPRINT and BINARY too: their clients fall back to text
  }
}

awaitable<void> Session::forward(std::string line, Shape shape) {
  const std::string request = to_board(line);
  const Expected expected{shape, 0, 0};
  const Reply reply = co_await hub_.line.ask(request, expected);
  const bool text = shape == Shape::text && reply.status >= 0;
  const bool body = shape == Shape::optional_text && reply.status > 0;
  std::string answer = std::to_string(reply.status) + "\n";
  if (text || body) answer += reply.body + "\n";
  co_await send(answer);
}

/// The payload must be here before the line is asked for: nobody waits for a slow client.
awaitable<void> Session::write(std::string line, Words words) {
  const auto length = firmware::iiod::payload_length(words);
  if (!length) {
    co_await send_number(-firmware::iiod::einval);
    co_return;
  }
  std::string payload;
  for (auto owed = static_cast<std::size_t>(*length); owed > 0 && !inbox_.closed;) {
    if (inbox_.bytes.empty()) co_await inbox_.change(std::chrono::hours(1));
    const std::size_t n = std::min(owed, inbox_.bytes.size());
    if (payload.size() <= longest_payload) payload += inbox_.bytes.substr(0, n);
    inbox_.bytes.erase(0, n);
    owed -= n;
  }
  if (inbox_.closed) co_return;
  if (payload.size() > longest_payload) {
    co_await send_number(-firmware::iiod::e2big);
    co_return;
  }
  // whoever may not claim the bench can do nothing that energises
  if (words[2] == "lease" && !payload.starts_with(hub_.options.token_prefix)) {
    co_await send_number(-firmware::iiod::eperm);
    co_return;
  }
  const std::string request = to_board(line) + payload;
  const Expected expected{Shape::number, payload.size(), 0};
  const Reply reply = co_await hub_.line.ask(request, expected);
  co_await send_number(reply.status);
}

awaitable<void> Session::open(std::string line, Words words) {
  const DeviceLayout* device = hub_.find(words[1]);
  std::uint32_t mask = 0;
  const bool valid =
      firmware::parse_int(words[2]).value_or(0) > 0 && firmware::iiod::parse_mask(words[3], mask);
  const std::size_t step = device && valid ? device->scan_bytes(mask) : 0;
  if (!device || step == 0 || reader_) {
    co_await send_number(!device   ? -firmware::iiod::enodev
                         : reader_ ? -firmware::iiod::ebusy
                                   : -firmware::iiod::einval);
    co_return;
  }
  const std::string id = device->id;
  const auto end = Clock::now() + hub_.options.handover;
  while (hub_.owners.contains(id)) {
    if (inbox_.closed) co_return;
    if (Clock::now() >= end) {
      co_await send_number(-firmware::iiod::ebusy);
      co_return;
    }
    co_await inbox_.change(milliseconds(5));
  }
  hub_.owners[id] = this;
  const std::string request = to_board(line);
  const Expected number;
  Reply reply = co_await hub_.line.ask(request, number);
  if (reply.status == -firmware::iiod::ebusy) {
    // nobody here has it open: an earlier CLOSE was damaged on the line
    const std::string close = "CLOSE " + id + "\n";
    co_await hub_.line.ask(close, number);
    reply = co_await hub_.line.ask(request, number);
  }
  if (reply.status < 0)
    hub_.owners.erase(id);
  else
    reader_ = Reader{id, mask, step, false};
  co_await send_number(reply.status);
}

awaitable<void> Session::close_reader() {
  const std::string id = reader_->device;
  reader_.reset();
  // whatever the board says to it, the buffer is nobody's now
  const std::string request = "CLOSE " + id + "\n";
  const Expected number;
  co_await hub_.line.ask(request, number);
  hub_.owners.erase(id);
}

/// Samples as they come, in pieces; the line is free for others between two of them and while there are none.
awaitable<void> Session::readbuf(Words words) {
  const DeviceLayout* device = hub_.find(words[1]);
  if (!reader_ || reader_->lost || !device || device->id != reader_->device) {
    co_await send_number(-firmware::iiod::ebadf);
    co_return;
  }
  const std::size_t step = reader_->step;
  const auto bytes = firmware::parse_int(words[2]).value_or(0);
  std::size_t owed = bytes > 0 && bytes <= 1'000'000'000 ? static_cast<std::size_t>(bytes) / step * step : 0;
  if (owed == 0) {
    co_await send_number(-firmware::iiod::einval);
    co_return;
  }
  bool mask_sent = false;
  auto last = Clock::now();
  while (owed > 0 && !inbox_.closed) {
    const std::size_t before = owed;
    const std::int64_t status = co_await read_piece(owed, mask_sent);
    if (owed < before) last = Clock::now();
    if (status > 0) continue;
    if (status == 0 && mask_sent) {
      co_await send_number(0);  // the record ends here
      co_return;
    }
    if (status < 0 && status != -firmware::iiod::eagain) {
      co_await send_number(status);
      co_return;
    }
    const std::uint32_t limit = hub_.timeout_ms();
    if (limit != 0 && Clock::now() - last >= milliseconds(limit)) {
      co_await send_number(-firmware::iiod::etimedout);
      co_return;
    }
    co_await inbox_.change(hub_.options.poll);
  }
}

/// Asks for the next piece and forwards what there is. Returns the board's last number, or 1 when the piece
/// is whole.
awaitable<std::int64_t> Session::read_piece(std::size_t& owed, bool& mask_sent) {
  const std::size_t whole = std::max(piece_bytes / reader_->step, std::size_t{1}) * reader_->step;
  const std::size_t piece = std::min(owed, whole);
  const std::uint32_t mask = reader_->mask;
  const std::string request = "READBUF " + reader_->device + " " + std::to_string(piece) + "\n";
  const Expected expected{Shape::samples, piece, mask};
  const Reply reply = co_await hub_.line.ask(request, expected);
  if (reply.lost) reader_->lost = true;
  if (reply.status == -firmware::iiod::ebadf) hub_.line.doubt();  // has it forgotten, or is it another board?
  if (!reply.body.empty()) {
    std::string answer = std::to_string(reply.body.size()) + "\n";
    if (!mask_sent) {
      firmware::TextOf<16> text;
      text.put_hex32(mask).put('\n');
      answer += text.view();
      mask_sent = true;
    }
    owed -= reply.body.size();
    answer += reply.body;
    co_await send(answer);
  }
  co_return reply.body.size() == piece ? 1 : reply.status;
}

awaitable<void> Session::send(std::string bytes) {
  boost::system::error_code error;
  co_await asio::async_write(socket_, asio::buffer(bytes), asio::redirect_error(asio::use_awaitable, error));
  if (error) close();
}

awaitable<void> Session::send_number(std::int64_t value) {
  const std::string answer = std::to_string(value) + "\n";
  co_await send(answer);
}

}  // namespace powbench::rigs::bridge
