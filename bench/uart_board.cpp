#include "bench/uart_board.h"

#include <fcntl.h>
#include <poll.h>
#include <pty.h>
#include <termios.h>
#include <unistd.h>

#include <algorithm>
#include <array>
#include <atomic>
#include <chrono>
#include <mutex>
#include <stdexcept>
#include <thread>
#include <vector>

#include "firmware/iiod/responder.h"
#include "rigs/sim_world.h"

namespace powbench::bench {
namespace {

using firmware::iiod::Connection;

constexpr double slice = 0.010;        // s of virtual time between two looks at the line
constexpr double patience = 0.200;     // s of silence after which a half-received request is dropped
constexpr double pause_busy = 150e-6;  // s between two looks while bytes are on the way
constexpr double pause_idle = 2e-3;
constexpr double short_hold = 0.020, long_hold = 0.700;  // s a delay and a stall last

double wall() {
  return std::chrono::duration<double>(std::chrono::steady_clock::now().time_since_epoch()).count();
}

/// Bytes on a wire: each takes its time, one after the other.
struct Wire {
  void put(std::string_view bytes, double now) {
    if (data.empty()) clock = std::max(clock, now);
    data += bytes;
  }
  std::string take(double now) {
    const double due = (now - clock) / byte_time;
    const std::size_t n = due <= 0 ? 0 : std::min(data.size(), static_cast<std::size_t>(due));
    const std::string out = data.substr(0, n);
    data.erase(0, n);
    clock += static_cast<double>(n) * byte_time;
    return out;
  }
  double byte_time = 0;
  double clock = 0;
  std::string data;
};

/// What a reset throws away.
struct Firmware {
  Firmware(const rigs::SimRigConfig& config, const sim::Specimen& specimen, int boot)
      : boot_id("boot-" + std::to_string(boot)), world(config, specimen, {.boot_id = boot_id}) {}
  firmware::Bench& bench() { return *world.board().native(); }

  std::string boot_id;
  rigs::SimWorld world;
};

struct Answer final : firmware::iiod::ByteSink {
  void put(std::span<const std::uint8_t> bytes) override { text.append(bytes.begin(), bytes.end()); }
  std::string text;
};

constexpr unsigned line = 0;  // a UART has one connection

struct Corruption {
  std::string text;
  std::size_t offset = 0;
};

}  // namespace

struct UartBoard::Impl {
  Impl(const rigs::SimRigConfig& c, const sim::Specimen& s, double baud) : config(c), specimen(s) {
    char name[128];
    termios raw{};
    cfmakeraw(&raw);
    raw.c_cflag |= CREAD | CLOCAL;
    if (openpty(&master, &slave, name, &raw, nullptr) != 0) throw std::runtime_error("no pseudo-terminal");
    fcntl(master, F_SETFL, O_NONBLOCK);
    // a program started beside us must not keep the line alive
    for (const int fd : {master, slave}) fcntl(fd, F_SETFD, FD_CLOEXEC);
    path = name;
    to_board.byte_time = to_host.byte_time = 10.0 / baud;
    thread = std::thread([this] { run(); });
  }
  ~Impl() {
    stop = true;
    thread.join();
    if (master >= 0) close(master);
    close(slave);
  }

  void run();
  void receive(double now);
  void answer(double now);
  void transmit(double now);
  void serve(Firmware& board, std::string& input, double now);
  void strike(bool to_rig, std::string& bytes, double now);

  rigs::SimRigConfig config;
  sim::Specimen specimen;
  int master = -1, slave = -1;
  std::string path;
  Wire to_board, to_host;
  double last_byte = 0;
  double rested = wall();  ///< accounted for up to here
  std::unique_ptr<Firmware> firmware;
  int boots = 0;

  mutable std::mutex mutex;  // what follows is shared
  std::string heard;
  LineFault fault;
  bool struck = false;
  std::array<std::uint64_t, 2> passed{};  ///< bytes to the host, to the rig
  std::array<double, 2> held_until{};
  int operations = 0;
  bool holds_a_record = false;
  Corruption bad_answer, bad_request;
  bool reset = true, unplug = false;
  std::atomic<bool> mute = false, stop = false;
  std::thread thread;
};

void UartBoard::Impl::run() {
  while (!stop) {
    {
      const std::lock_guard lock(mutex);
      if (reset) {
        firmware = std::make_unique<Firmware>(config, specimen, ++boots);
        to_host.data.clear();
        to_board.data.clear();
        reset = false;
      }
      if (unplug && master >= 0) {
        close(master);
        master = -1;
      }
    }
    if (master < 0) {
      std::this_thread::sleep_for(std::chrono::milliseconds(5));
      continue;
    }
    const bool busy = !to_board.data.empty() || !to_host.data.empty() || firmware->world.busy();
    const double wait = busy ? pause_busy : pause_idle;
    const timespec limit{0, static_cast<long>(wait * 1e9)};
    pollfd p{master, POLLIN, 0};
    // bytes that wait their turn on the wire must not wake us again and again
    if (!to_board.data.empty())
      std::this_thread::sleep_for(std::chrono::duration<double>(wait));
    else
      ppoll(&p, 1, &limit, nullptr);
    const double now = wall();
    receive(now);
    answer(now);
    transmit(now);
    if (firmware->world.busy()) firmware->world.run(slice);
    {
      const auto& controller = firmware->bench().controller();
      const std::lock_guard lock(mutex);
      operations = static_cast<int>(controller.fire_control().operations());
      holds_a_record = controller.recorder().complete();
    }
    // the lease ends by the clock on the wall
    if (const auto ms = static_cast<std::int64_t>((now - rested) * 1e3); ms > 0) {
      firmware->world.board().rest(ms);
      rested += 1e-3 * static_cast<double>(ms);
    }
  }
}

/// `bytes` come off the wire; does to them what the fault says, if it is their turn.
void UartBoard::Impl::strike(bool to_rig, std::string& bytes, double now) {
  const std::lock_guard lock(mutex);
  std::uint64_t& count = passed[to_rig ? 1 : 0];
  const std::uint64_t first = count;
  count += bytes.size();
  if (struck || fault.kind == LineFault::Kind::none || fault.to_rig != to_rig || fault.byte < first ||
      fault.byte >= count)
    return;
  struck = true;
  const auto offset = static_cast<std::size_t>(fault.byte - first);
  if (fault.kind == LineFault::Kind::flip)
    bytes[offset] = static_cast<char>(bytes[offset] ^ (1 << fault.bit));
  if (fault.kind == LineFault::Kind::drop) bytes.erase(offset, 1);
  if (fault.kind == LineFault::Kind::delay) held_until[to_rig ? 1 : 0] = now + short_hold;
  if (fault.kind == LineFault::Kind::stall) held_until[to_rig ? 1 : 0] = now + long_hold;
}

void UartBoard::Impl::receive(double now) {
  char bytes[4096];
  const ssize_t n = read(master, bytes, sizeof bytes);
  if (n > 0) to_board.put({bytes, static_cast<std::size_t>(n)}, now);
}

void UartBoard::Impl::answer(double now) {
  std::string input = now < held_until[1] ? std::string() : to_board.take(now);
  strike(true, input, now);
  if (input.empty()) {
    if (now - last_byte > patience) firmware->bench().forget_input(line);
    return;
  }
  last_byte = now;
  {
    const std::lock_guard lock(mutex);
    const std::size_t before = heard.size();
    heard += input;
    const std::size_t at = bad_request.text.empty() ? std::string::npos : heard.rfind(bad_request.text);
    const std::size_t hit = at + bad_request.text.size() + bad_request.offset;
    if (at != std::string::npos && hit >= before && hit < heard.size()) {
      input[hit - before] = static_cast<char>(input[hit - before] ^ 1);
      bad_request = {};
    }
  }
  serve(*firmware, input, now);
}

/// Feeds the firmware as a UART port does: nothing ever waits inside it.
void UartBoard::Impl::serve(Firmware& board, std::string& input, double now) {
  for (std::size_t used = 0; used < input.size();) {
    const auto* bytes = reinterpret_cast<const std::uint8_t*>(input.data());
    // line by line, so that each answer is one piece
    const std::size_t end = std::min(input.find('\n', used), input.size() - 1) + 1;
    const auto fed = board.world.board().feed(line, {bytes + used, end - used});
    used += fed.used;
    std::string text(fed.bytes.begin(), fed.bytes.end());
    board.world.notice_commands();
    if (fed.status == rigs::Board::Status::closed) return;
    // nothing waits on a UART: the client is told to come again
    Answer refusal;
    board.bench().expire(line, refusal, firmware::iiod::eagain);
    text += refusal.text;
    if (text.empty() || mute) continue;
    const std::lock_guard lock(mutex);
    if (!bad_answer.text.empty() && text.starts_with(bad_answer.text)) {
      text.at(bad_answer.offset) = static_cast<char>(text.at(bad_answer.offset) ^ 1);
      bad_answer = {};
    }
    to_host.put(text, now);
  }
}

void UartBoard::Impl::transmit(double now) {
  std::string bytes = now < held_until[0] ? std::string() : to_host.take(now);
  strike(false, bytes, now);
  for (std::size_t done = 0; done < bytes.size() && !stop;) {
    const ssize_t n = write(master, bytes.data() + done, bytes.size() - done);
    if (n > 0) {
      done += static_cast<std::size_t>(n);
      continue;
    }
    // the host does not read: a wire loses the byte; a pseudo-terminal waits
    std::this_thread::sleep_for(std::chrono::microseconds(200));
    const std::lock_guard lock(mutex);
    if (reset || unplug) return;
  }
}

UartBoard::UartBoard(const rigs::SimRigConfig& config, const sim::Specimen& specimen, double baud)
    : impl_(std::make_unique<Impl>(config, specimen, baud)) {}
UartBoard::~UartBoard() = default;

const std::string& UartBoard::port() const {
  return impl_->path;
}
std::string UartBoard::heard() const {
  const std::lock_guard lock(impl_->mutex);
  return impl_->heard;
}
void UartBoard::reset() {
  const std::lock_guard lock(impl_->mutex);
  impl_->reset = true;
}
void UartBoard::corrupt_answer(std::string prefix, std::size_t offset) {
  const std::lock_guard lock(impl_->mutex);
  impl_->bad_answer = {std::move(prefix), offset};
}
void UartBoard::corrupt_request(std::string text, std::size_t offset) {
  const std::lock_guard lock(impl_->mutex);
  impl_->bad_request = {std::move(text), offset};
}
void UartBoard::set(const LineFault& fault) {
  const std::lock_guard lock(impl_->mutex);
  impl_->fault = fault;
  impl_->struck = false;
  impl_->passed = {};
}
bool UartBoard::struck() const {
  const std::lock_guard lock(impl_->mutex);
  return impl_->struck;
}
std::uint64_t UartBoard::passed(bool to_rig) const {
  const std::lock_guard lock(impl_->mutex);
  return impl_->passed[to_rig ? 1 : 0];
}
int UartBoard::operations() const {
  const std::lock_guard lock(impl_->mutex);
  return impl_->operations;
}
bool UartBoard::holds_a_record() const {
  const std::lock_guard lock(impl_->mutex);
  return impl_->holds_a_record;
}
void UartBoard::mute(bool silent) {
  impl_->mute = silent;
}
void UartBoard::unplug() {
  const std::lock_guard lock(impl_->mutex);
  impl_->unplug = true;
}

}  // namespace powbench::bench
