#include <cstdint>
#include <optional>
#include <string_view>

#include "firmware/bench.h"
#include "firmware/math.h"
#include "firmware/port/common/uart_link.h"
#include "firmware/port/qemu/semihosting.h"
#include "firmware/watchdog_feed.h"

/// Resets on purpose: the firmware on the emulated Cortex-M4F without a plant, energised, then killed by a fault of
/// the processor or by the watchdog, and started again. The second start says what it found. And a serial port, polled.
/// Mode: the emulator's `arg=`. Exit code 0: as it should be.
/// Reference: Arm, "Cortex-M System Design Kit Technical Reference Manual" (watchdog, UART, timer).

extern "C" {
void sample_block_handler();
void background_handler();
[[noreturn]] void processor_fault(const std::uint32_t* frame);
int run_bench();
}

namespace {

using namespace powbench;
using namespace powbench::firmware;

// ---- peripherals ----

struct Uart {
  volatile std::uint32_t data, state, control, interrupt, divider;
  static constexpr std::uint32_t full = 1, received = 2;
};
Uart& uart() {
  return *reinterpret_cast<Uart*>(0x40004000);
}

/// Interrupt at the first time-out (wired to NMI), reset at the second.
struct Watchdog {
  volatile std::uint32_t load, value, control, clear;
};
Watchdog& watchdog() {
  return *reinterpret_cast<Watchdog*>(0x40008000);
}
constexpr std::uint32_t watchdog_ticks = 25'000'000 / 20;  // 50 ms

/// Stands for the gate's output: a peripheral's register, which a reset clears without any instruction.
volatile std::uint32_t& gate_pin = *reinterpret_cast<volatile std::uint32_t*>(0x40001008);

volatile std::uint32_t& reset_request = *reinterpret_cast<volatile std::uint32_t*>(0xE000ED0C);

// ---- what no start clears ----

struct Kept {
  std::uint32_t magic, boots, watched;  ///< watched: the watchdog runs
};
constexpr std::uint32_t kept_magic = 0x504F5742;
[[gnu::section(".noinit")]] Kept kept;
[[gnu::section(".noinit")]] Survivor survivor;

[[gnu::section(".records")]] std::array<std::int16_t, 4000 * channel_count> record_storage;

enum Verdict : int {
  good,
  no_shot,
  gate_on_after_reset,
  no_fault,
  wrong_fault,
  not_latched,
  not_cleared,
  no_reset
};

ControllerConfig configuration() {
  ControllerConfig c;
  c.record_length = 3000;
  c.pretrigger = 1000;
  c.phase.nominal_amplitude = 16000.0F;
  c.interlocks.overcurrent_counts = 20'000;
  c.interlocks.no_current_counts = 100;
  c.interlocks.no_current_samples = 480;
  c.interlocks.stuck_on_samples = 2500;
  c.interlocks.mains_lost_counts = 3200;
  c.interlocks.mains_lost_samples = 1600;
  return c;
}

/// A mains of 50 Hz and a coil that conducts while the gate is on.
struct World {
  Bench& bench;
  std::int64_t next = 0;
  bool ever_on = false;
  std::array<std::int16_t, 10 * channel_count> scans{};

  void step() {
    for (std::size_t i = 0; i < 10; ++i) {
      const auto turns = static_cast<float>((next + static_cast<std::int64_t>(i)) % 2000) / 2000.0F;
      auto* scan = &scans[i * channel_count];
      scan[index(Channel::mains_voltage)] = static_cast<std::int16_t>(16000.0F * sin_turns(turns));
      scan[index(Channel::coil_current)] = gate_pin != 0 ? std::int16_t{8000} : std::int16_t{0};
    }
    const Block block{.first_sample = next, .scans = scans, .host_heard = true};
    next += 10;
    for (const GateEdge& edge : bench.step(block)) {
      gate_pin = edge.on ? 1 : 0;
      ever_on = ever_on || edge.on;
    }
  }
};

/// A connection of the bench as the responder of a line.
struct Line final : iiod::ByteSink {
  void put(std::span<const std::uint8_t> bytes) override {
    for (const std::uint8_t byte : bytes) {
      while ((uart().state & Uart::full) != 0) {
      }
      uart().data = byte;
    }
  }
};

/// Answers on the serial port until an end-of-transmission comes.
int talk(Bench& bench) {
  constexpr std::uint8_t end_of_transmission = 4;
  uart().divider = 16;
  uart().control = 3;
  Line line;
  for (;;) {
    if ((uart().state & Uart::received) == 0) continue;
    const auto byte = static_cast<std::uint8_t>(uart().data);
    if (byte == end_of_transmission) return good;
    bench.feed(0, {&byte, 1}, line);
    if (bench.status(0) == Bench::Status::pending) bench.expire(0, line, iiod::eagain);
  }
}

/// Energised; then what the mode says. It returns only if no reset comes of it.
int die(World& world, FireControl& fire, std::string_view mode) {
  fire.arm();
  while (!fire.phase().valid() && world.next < 100'000) world.step();
  fire.fire();
  while (gate_pin == 0 && world.next < 200'000) world.step();
  if (gate_pin == 0) return no_shot;
  if (mode == "undefined") asm volatile("udf #1");
  if (mode == "bus") (void)*reinterpret_cast<volatile std::uint32_t*>(0x60000000);
  if (mode == "watchdog") {
    kept.watched = 1;
    watchdog().load = watchdog_ticks;
    watchdog().control = 3;
    // everything but the main loop goes on, so that nobody feeds
    WatchdogFeed feed;
    for (int block = 0; block < 100'000; ++block) {
      world.step();
      feed.progress(WatchdogFeed::Part::control_interrupt);
      feed.progress(WatchdogFeed::Part::background);
      feed.progress(WatchdogFeed::Part::communication);
      if (feed.may_feed()) watchdog().clear = 1;
    }
  }
  return no_reset;
}

/// After the reset: off, latched with the right fault, refusing, and cleared by abort alone.
int judge(World& world, FireControl& fire, bool pin_at_start, Fault expected) {
  if (pin_at_start) return gate_on_after_reset;
  for (int i = 0; i < 100; ++i) world.step();
  if (fire.state() != State::fault) return no_fault;
  if (fire.fault() != expected) return wrong_fault;
  if (fire.arm() == Refusal::accepted || fire.fire() == Refusal::accepted || world.ever_on)
    return not_latched;
  fire.abort();
  if (fire.state() != State::idle || fire.arm() != Refusal::accepted) return not_cleared;
  return good;
}

std::optional<Bench> bench;

}  // namespace

/// Off first; then the note, and a new start.
void processor_fault(const std::uint32_t* frame) {
  gate_pin = 0;
  if (kept.watched != 0) {  // the watchdog's first time-out: the second one resets
    for (;;) {
    }
  }
  survivor.record_crash(CrashCause::hard_fault, frame[6], frame[5]);
  asm volatile("dsb");
  reset_request = 0x05FA0004;
  for (;;) {
  }
}

void sample_block_handler() {}
void background_handler() {}

int run_bench() {
  const bool pin_at_start = gate_pin != 0;
  if (kept.magic != kept_magic) {
    kept = {kept_magic, 0, 0};
    survivor.forget();
  }
  ++kept.boots;
  std::array<char, 64> memory{};
  const std::string_view mode = semihosting::arguments(memory);
  bench.emplace(configuration(), Identity{"check", "reset", "1", "0", "none"}, record_storage);
  if (mode == "uart") return talk(*bench);

  auto& fire = const_cast<FireControl&>(bench->controller().fire_control());
  const bool watched = kept.watched != 0;
  fire.boot({.cause = kept.boots == 1 ? ResetCause::power_on
                                      : (watched ? ResetCause::watchdog : ResetCause::software),
             .survivor = &survivor});
  World world{*bench};
  if (kept.boots == 1) return die(world, fire, mode);
  const Text found = [&] {
    Text text;
    text.put("start ").put_unsigned(kept.boots).put(": fault ").put(info(fire.fault()).name).put(" pc ");
    return text.put_hex32(survivor.program_counter).put("\n");
  }();
  std::array<char, 128> line{};
  found.view().copy(line.data(), line.size() - 1);
  semihosting::say(line.data());
  return judge(world, fire, pin_at_start, watched ? Fault::watchdog_reset : Fault::crash_reset);
}
