#include <cstdint>
#include <optional>
#include <string_view>

#include "firmware/bench.h"
#include "firmware/math.h"
#include "firmware/port/common/uart_link.h"
#include "firmware/port/qemu/semihosting.h"
#include "firmware/watchdog_feed.h"

/// Two things that the lock-step does not show.
/// Preemption: control step by a timer, background below it, so that it is interrupted anywhere.
/// Resets on purpose: the firmware on the emulated Cortex-M4F without a plant, energised, then killed by a fault of
/// the processor or by the watchdog, and started again. The second start says what it found. And a serial port, polled.
/// Mode: the emulator's `arg=`. Exit code 0: as it should be.
/// Reference: Arm, "Cortex-M System Design Kit Technical Reference Manual" (watchdog, UART, timer).

extern "C" {
extern std::uint32_t image_stack_begin[], image_stack_end[];
void sample_block_handler();
void background_handler();
void tick_handler();
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

struct SysTick {
  volatile std::uint32_t control, reload, value;
};
SysTick& tick() {
  return *reinterpret_cast<SysTick*>(0xE000E010);
}
volatile std::uint32_t& nvic_enable = *reinterpret_cast<volatile std::uint32_t*>(0xE000E100);
volatile std::uint32_t& nvic_pend = *reinterpret_cast<volatile std::uint32_t*>(0xE000E200);
auto* const nvic_priority = reinterpret_cast<volatile std::uint8_t*>(0xE000E400);
auto* const tick_priority = reinterpret_cast<volatile std::uint8_t*>(0xE000ED23);

enum Verdict : int {
  good,
  no_shot,
  gate_on_after_reset,
  no_fault,
  wrong_fault,
  not_latched,
  not_cleared,
  no_reset,
  not_captured,
  wrong_angle,
  wrong_checksum,
  never_interrupted
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
  Tick on{};
  std::array<std::int16_t, 10 * channel_count> scans{};

  void step(bool with_background = true) {
    for (std::size_t i = 0; i < 10; ++i) {
      const auto turns = static_cast<float>((next + static_cast<std::int64_t>(i)) % 2000) / 2000.0F;
      auto* scan = &scans[i * channel_count];
      scan[index(Channel::mains_voltage)] = static_cast<std::int16_t>(16000.0F * sin_turns(turns));
      scan[index(Channel::coil_current)] = gate_pin != 0 ? std::int16_t{8000} : std::int16_t{0};
    }
    const Block block{.first_sample = next, .scans = scans, .owner_present = true};
    next += 10;
    for (const GateEdge& edge : with_background ? bench.step(block) : bench.control(block)) {
      if (edge.on) on = edge.at;
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
    if (bench.connection(0).status() == Bench::Status::pending) bench.expire(0, line, iiod::eagain);
  }
}

/// Deeper than any stack.
[[gnu::noinline]] std::uint32_t descend(std::uint32_t depth) {
  volatile std::uint32_t frame[64] = {depth};
  return depth == 0 ? frame[0] : descend(depth - 1) + frame[0];
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
  if (mode == "overflow") gate_pin = gate_pin + (descend(1'000'000) & 1U);
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

void say(const Text& text) {
  std::array<char, 128> line{};
  text.view().copy(line.data(), line.size() - 1);
  semihosting::say(line.data());
}

// ---- preemption ----

/// What the two interrupts share with the main loop.
struct Levels {
  World* world = nullptr;
  std::uint32_t random = 1, interrupted = 0;
  volatile bool in_background = false;
} levels;

/// The main loop touches the controller with both levels kept out.
template <class Act>
auto held(Act act) {
  asm volatile("cpsid i" ::: "memory");
  const auto result = act();
  asm volatile("cpsie i" ::: "memory");
  return result;
}

/// Twenty shots. Blocks come after 4000 to 8000 instructions, a background with an estimate takes some 14 000.
int interrupt_everywhere(World& world, FireControl& fire, const Recorder& recorder) {
  levels.world = &world;
  nvic_priority[1] = 0xC0;
  *tick_priority = 0x40;
  nvic_enable = 2;
  tick().reload = 10'000;
  tick().value = 0;
  tick().control = 7;
  held([&] { return fire.set_hold_time_ms(10); });
  for (int shot = 0; shot < 20; ++shot) {
    const int angle = 1700 * shot;
    held([&] { return fire.set_closing_angle(angle), fire.arm(); });
    while (held([&] { return fire.state() == State::armed && !fire.phase().valid(); })) {
    }
    held([&] { return fire.fire(); });
    while (held([&] { return fire.state() == State::firing; })) {
    }
    if (fire.state() != State::captured) return not_captured;
    const float turns = static_cast<float>(world.on.sample % 2000) / 2000.0F +
                        static_cast<float>(world.on.fraction) / (65536.0F * 2000.0F);
    const float error = 360.0F * wrap_half(turns - static_cast<float>(angle) / 36000.0F);
    if (error > 0.1F || error < -0.1F) return wrong_angle;
    std::uint32_t crc = 0;
    for (std::uint64_t i = 0; i < static_cast<std::uint64_t>(recorder.length()); ++i) {
      std::array<std::uint8_t, 2 * channel_count> scan{};
      recorder.copy(i, 1, (1U << channel_count) - 1, scan.data());
      crc = crc32(scan, crc);
    }
    if (recorder.crc() != crc || recorder.overruns() != 0) return wrong_checksum;
    held([&] { return fire.abort(), 0; });
  }
  TextOf<> told;
  told.put("background interrupted ").put_unsigned(levels.interrupted).put(" times\n");
  say(told);
  return levels.interrupted > 1000 ? good : never_interrupted;
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
  const bool stacked = frame >= image_stack_begin && frame + 8 <= image_stack_end;
  if (stacked)
    survivor.record_crash(CrashCause::hard_fault, frame[6], frame[5]);
  else
    survivor.record_crash(CrashCause::stack_overflow, 0, 0);
  asm volatile("dsb");
  reset_request = 0x05FA0004;
  for (;;) {
  }
}

void sample_block_handler() {}

void tick_handler() {
  Levels& l = levels;
  if (l.in_background) ++l.interrupted;
  l.random = l.random * 1664525U + 1013904223U;
  tick().reload = 6400 + (l.random >> 16) % 6400;  // 25 MHz, 1.6 an instruction
  l.world->step(false);
  nvic_pend = 2;
}

void background_handler() {
  levels.in_background = true;
  bench->background();
  levels.in_background = false;
}

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
  if (mode == "preempt") return interrupt_everywhere(world, fire, bench->controller().recorder());
  if (kept.boots == 1) return die(world, fire, mode);
  TextOf<> found;
  found.put("start ").put_unsigned(kept.boots).put(": fault ").put(info(fire.fault()).name);
  found.put(" cause ").put_unsigned(survivor.cause).put(" pc ").put_hex32(survivor.program_counter).put("\n");
  say(found);
  return judge(world, fire, pin_at_start, watched ? Fault::watchdog_reset : Fault::crash_reset);
}
