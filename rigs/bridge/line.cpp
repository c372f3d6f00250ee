#include "rigs/bridge/line.h"

#include <sys/file.h>
#include <sys/ioctl.h>
#include <termios.h>

#include <array>

#include "rigs/rig.h"

namespace powbench::rigs::bridge {

namespace asio = boost::asio;
using asio::awaitable;
using std::chrono::milliseconds;
using Shape = Expected::Shape;

namespace {

constexpr int probes = 3;
constexpr milliseconds drain_limit{1000};  // a board that never falls silent is no IIO board
constexpr milliseconds write_limit{2000};  // the longest request has 4 kB
constexpr std::int64_t timed_out = -110;

auto into(boost::system::error_code& error) {
  return asio::redirect_error(asio::use_awaitable, error);
}

std::string advice(const boost::system::error_code& error) {
  if (error == boost::system::errc::permission_denied)
    return "; the user must be in the group that owns it (dialout on Debian)";
  if (error == boost::system::errc::no_such_file_or_directory)
    return "; is the cable in and the board powered?";
  return "";
}

}  // namespace

Line::Line(asio::io_context& io, const BridgeOptions& options)
    : io_(io), options_(options), port_(io), write_limit_(io), watch_timer_(io), inbox_(io) {
  using asio::serial_port_base;
  boost::system::error_code error;
  port_.open(options_.port, error);
  if (error)
    throw RigError("cannot open serial port " + options_.port + ": " + error.message() + advice(error));
  // two programs on one line would read each other's answers
  if (flock(port_.native_handle(), LOCK_EX | LOCK_NB) != 0)
    throw RigError("serial port " + options_.port + " is used by another program; stop that one first");
  const auto set = [&](const auto& option) {
    if (!error) port_.set_option(option, error);
  };
  set(serial_port_base::character_size(8));
  set(serial_port_base::parity(serial_port_base::parity::none));
  set(serial_port_base::stop_bits(serial_port_base::stop_bits::one));
  set(serial_port_base::flow_control(serial_port_base::flow_control::none));
  set(serial_port_base::baud_rate(options_.baud));
  if (error)
    throw RigError("serial port " + options_.port + " does not take " + std::to_string(options_.baud) +
                   " baud: " + error.message());
  ::tcflush(port_.native_handle(), TCIOFLUSH);  // what was said before concerns nobody
}

awaitable<void> Line::start() {
  asio::co_spawn(io_, receive(), asio::detached);
  busy_ = true;
  co_await recover(probes);
  end_turn();
  if (!answering_)
    throw RigError("no IIO board answers on " + options_.port + " at " + std::to_string(options_.baud) +
                   " baud; check cable, power and baud rate");
  asio::co_spawn(io_, watch(), asio::detached);
}

void Line::close() {
  closed_ = true;
  answering_ = false;
  boost::system::error_code ignored;
  port_.close(ignored);
  inbox_.close();
  watch_timer_.cancel();
  write_limit_.cancel();
  refuse_waiting();
}

// ---- turns ----

awaitable<bool> Line::take_turn() {
  if (!busy_) {
    busy_ = true;
    co_return true;
  }
  Waiter waiter(io_);
  waiting_.push_back(&waiter);
  co_await pause(waiter.timer, std::chrono::hours(1));
  std::erase(waiting_, &waiter);
  co_return waiter.granted;
}

void Line::end_turn() {
  if (waiting_.empty()) {
    busy_ = false;
    return;
  }
  Waiter* next = waiting_.front();
  waiting_.pop_front();
  next->granted = true;
  next->timer.cancel();
}

void Line::refuse_waiting() {
  for (Waiter* waiter : waiting_) waiter->timer.cancel();
  waiting_.clear();
}

// ---- transactions ----

awaitable<Reply> Line::ask(std::string request, Expected expected) {
  Reply nothing;
  nothing.status = timed_out;
  nothing.lost = true;
  if (dead_ || closed_) co_return nothing;
  const bool mine = co_await take_turn();
  if (!mine) co_return nothing;
  if (!answering_) {
    end_turn();
    co_return nothing;
  }
  std::optional<Reply> reply = co_await transfer(request, expected, options_.silence);
  if (!reply) {
    // the client hears of it now; the turn is kept until the line is in order again
    ++failures_;
    asio::co_spawn(io_, recover_and_end_turn(), asio::detached);
    co_return nothing;
  }
  end_turn();
  co_return std::move(*reply);
}

awaitable<void> Line::recover_and_end_turn() {
  co_await recover(probes);
  end_turn();
}

awaitable<bool> Line::send(const std::string& bytes) {
  // a port that takes no bytes must not hold everybody up
  const int mine = ++writes_;
  write_limit_.expires_after(write_limit);
  write_limit_.async_wait([this, mine](boost::system::error_code error) {
    if (!error && mine == writes_ && !closed_) port_.cancel();
  });
  boost::system::error_code error;
  co_await asio::async_write(port_, asio::buffer(bytes), into(error));
  ++writes_;
  write_limit_.cancel();
  if (error && error != asio::error::operation_aborted) port_is_gone(error);
  co_return !error;
}

awaitable<std::optional<Reply>> Line::transfer(std::string request, Expected expected, milliseconds silence) {
  inbox_.bytes.clear();
  const bool sent = co_await send(request);
  if (!sent) co_return std::nullopt;
  ReplyReader reader(expected);
  while (!reader.done()) {
    if (inbox_.bytes.empty()) co_await inbox_.change(silence);
    if (inbox_.bytes.empty()) co_return std::nullopt;
    const std::size_t used = reader.feed(inbox_.bytes);
    inbox_.bytes.erase(0, used);
    if (reader.bad()) co_return std::nullopt;
  }
  if (!inbox_.bytes.empty()) co_return std::nullopt;  // more than one answer: out of step
  last_answer_ = Clock::now();
  co_return std::move(reader.reply());
}

// ---- trouble ----

awaitable<bool> Line::probe() {
  // the first line end finishes whatever the board has half received
  const std::string request = "\nVERSION\n";
  const Expected version{Shape::line, 0, 0};
  const auto reply = co_await transfer(request, version, options_.probe);
  if (!reply) co_return false;
  const std::string& text = reply->body;
  const std::size_t dot = text.find('.');
  if (dot == std::string::npos || dot == 0 || text.find('.', dot + 1) == std::string::npos) co_return false;
  version_ = text;
  co_return true;
}

/// Brings line and board into step again. The caller holds the turn; who waits for it waits for the outcome.
awaitable<void> Line::recover(int tries) {
  answering_ = false;
  for (int attempt = 0; attempt < tries && !closed_ && !answering_; ++attempt) {
    const auto end = Clock::now() + drain_limit;
    do {
      inbox_.bytes.clear();
      co_await inbox_.change(options_.quiet);
    } while (!inbox_.bytes.empty() && !closed_ && Clock::now() < end);
    const bool found = co_await probe();
    if (!found) continue;
    answering_ = co_await check_board();
  }
  dead_ = !answering_;
  if (dead_) refuse_waiting();
}

/// Reads the description; a board that was reset or exchanged has another one (its `boot_id` at least).
awaitable<bool> Line::check_board() {
  doubted_ = false;
  const std::string request = "PRINT\n";
  const Expected text{Shape::text, 0, 0};
  auto reply = co_await transfer(request, text, options_.silence);
  if (!reply || reply->status <= 0) co_return false;
  if (reply->body != description_) {
    // the line has no checksum: what is new has to come twice alike
    const auto again = co_await transfer(request, text, options_.silence);
    if (!again || again->body != reply->body) co_return false;
    const bool another = !description_.empty();
    description_ = std::move(reply->body);
    if (another) on_new_board();
  }
  co_return true;
}

awaitable<void> Line::receive() {
  std::array<char, 4096> bytes{};
  while (!closed_) {
    boost::system::error_code error;
    const std::size_t n = co_await port_.async_read_some(asio::buffer(bytes), into(error));
    if (closed_) break;
    if (error == asio::error::operation_aborted) continue;  // a write took too long
    if (error) {
      port_is_gone(error);
      break;
    }
    inbox_.put(bytes.data(), n);
  }
}

/// Whichever notices first, a read or a write: the reason is known before any client is answered.
void Line::port_is_gone(const boost::system::error_code& why) {
  if (closed_) return;
  close();
  on_lost("serial port " + options_.port + " is gone (" + why.message() +
          "); was the board unplugged? plug it in and start again");
}

/// Looks after a line that nobody uses at the moment, and after one that does not answer.
awaitable<void> Line::watch() {
  while (!closed_) {
    co_await pause(watch_timer_, options_.check / 4);
    if (closed_) break;
    const bool idle = Clock::now() - last_answer_ >= options_.check && in_use();
    if (answering_ && !idle && !doubted_) continue;
    const bool mine = co_await take_turn();
    if (!mine) continue;
    bool same = answering_;
    if (same) same = co_await check_board();
    if (!same && !closed_) {
      if (answering_) ++failures_;
      co_await recover(dead_ ? 1 : probes);
    }
    end_turn();
  }
}

}  // namespace powbench::rigs::bridge
