#include <algorithm>
#include <string_view>

#include "firmware/port/qemu/exit_codes.h"
#include "firmware/port/qemu/lockstep_board.h"
#include "firmware/port/qemu/semihosting.h"

/// The bench firmware on an emulated Cortex-M4F (`qemu-system-arm -M mps2-an386`), in lock-step with a plant
/// on the host. The line to the plant is a pair of pipes that the emulator inherits as descriptors 3 and 4.
/// Blocks of samples run in the interrupt a converter's DMA would raise, the phase estimate and the checksums in one
/// below it, the protocol in the main loop.

extern "C" {
extern std::uint32_t image_stack_begin[], image_stack_end[];
void sample_block_handler();
void background_handler();
[[noreturn]] void processor_fault(const std::uint32_t* frame);
int run_bench();
}

namespace {

using namespace powbench::firmware;

constexpr std::string_view line_in = "/dev/fd/3", line_out = "/dev/fd/4";

[[gnu::section(".records")]] std::array<std::int16_t, lockstep::longest_record * powbench::channel_count>
    record_storage;

// ---- the timer that counts instructions under -icount: CMSDK timer 0 counts down at 25 MHz ----

struct Timer {
  volatile std::uint32_t control, value, reload, interrupt;
};
Timer& timer() {
  return *reinterpret_cast<Timer*>(0x40000000);
}

// ---- interrupts 0 (samples) and 1 (background) of the NVIC, pended by software ----

volatile std::uint32_t& nvic_enable = *reinterpret_cast<volatile std::uint32_t*>(0xE000E100);
volatile std::uint32_t& nvic_pend = *reinterpret_cast<volatile std::uint32_t*>(0xE000E200);
auto* const nvic_priority = reinterpret_cast<volatile std::uint8_t*>(0xE000E400);

/// What the main loop hands to the interrupt, and what comes back.
struct Handover {
  Bench* bench = nullptr;
  const Block* block = nullptr;
  std::span<const GateEdge> edges{};
  bool measure = false;
  std::uint32_t control_ticks = 0, background_ticks = 0;
  volatile bool done = false;
} handover;

constexpr std::uint32_t stack_paint = 0xC5C5C5C5;

/// The part of the stack that is certainly unused now.
std::span<std::uint32_t> lower_stack() {
  const auto* here = static_cast<std::uint32_t*>(__builtin_frame_address(0));
  return {image_stack_begin, static_cast<std::size_t>(here - image_stack_begin) - 64};
}

class EmulatedBoard final : public lockstep::Platform {
 public:
  bool open() {
    in_ = semihosting::open(line_in.data(), line_in.size(), semihosting::Open::read);
    out_ = semihosting::open(line_out.data(), line_out.size(), semihosting::Open::write);
    return in_ >= 0 && out_ >= 0;
  }
  std::size_t receive(std::span<std::uint8_t> to) { return semihosting::read(in_, to); }
  void send(std::span<const std::uint8_t> frame) override {
    if (!semihosting::write(out_, frame)) semihosting::exit(exit_end_of_plant);  // nobody listens any more
  }

  std::span<const GateEdge> run_block(Bench& bench, const Block& block, bool measure) override {
    const std::int64_t estimate = bench.controller().fire_control().phase().sample;
    handover.bench = &bench;
    handover.block = &block;
    handover.measure = measure;
    handover.done = false;
    asm volatile("" ::: "memory");  // the handler must see all of it
    nvic_pend = 1;
    asm volatile("dsb\n\tisb" ::: "memory");
    while (!handover.done) {
    }
    asm volatile("" ::: "memory");
    if (measure) count(block, bench.controller().fire_control().phase().sample != estimate);
    return handover.edges;
  }

  lockstep::Cost cost() const override {
    lockstep::Cost c = cost_;
    const auto* first_used = std::find_if(image_stack_begin, image_stack_end,
                                          [](std::uint32_t word) { return word != stack_paint; });
    c.stack_bytes = static_cast<std::uint32_t>(image_stack_end - first_used) * 4;
    const std::uint32_t before = timer().value;
    c.empty_ticks = before - timer().value;
    return c;
  }

 private:
  void count(const Block& block, bool updated) {
    const Handover& h = handover;
    cost_.control_ticks += h.control_ticks;
    (updated ? cost_.update_ticks : cost_.background_ticks) += h.background_ticks;
    ++cost_.blocks;
    if (updated) ++cost_.update_blocks;
    cost_.samples += static_cast<std::uint32_t>(block.samples());
    cost_.worst_control_ticks = std::max(cost_.worst_control_ticks, h.control_ticks);
    cost_.worst_background_ticks = std::max(cost_.worst_background_ticks, h.background_ticks);
  }

  std::int32_t in_ = -1, out_ = -1;
  lockstep::Cost cost_{};
};

/// Reads until a whole frame is there. Empty: the plant has closed the line.
std::span<const std::uint8_t> receive_frame(EmulatedBoard& board, std::span<std::uint8_t> memory,
                                            bool& damaged) {
  std::size_t have = 0;
  for (;;) {
    const std::size_t length = lockstep::frame_length(memory.first(have), damaged);
    if (damaged || (length > 0 && have >= length)) return memory.first(damaged ? have : length);
    const std::size_t n = board.receive(memory.subspan(have));
    if (n == 0) return {};
    have += n;
  }
}

EmulatedBoard board;
[[gnu::section(".frames")]] std::array<std::uint8_t, lockstep::largest_frame> incoming, outgoing;
lockstep::LockstepBoard bench(board, record_storage, outgoing);

}  // namespace

/// Without its plant the emulated board has nothing to be safe for: the emulator ends and says why.
[[noreturn]] void processor_fault(const std::uint32_t*) {
  semihosting::exit(exit_processor_fault);
}

void sample_block_handler() {
  Handover& h = handover;
  const std::uint32_t start = h.measure ? timer().value : 0;
  h.edges = h.bench->control(*h.block);
  if (h.measure) h.control_ticks = start - timer().value;  // it counts down
  nvic_pend = 2;
}

void background_handler() {
  Handover& h = handover;
  const std::uint32_t start = h.measure ? timer().value : 0;
  h.bench->background();
  if (h.measure) h.background_ticks = start - timer().value;
  h.done = true;
}

int run_bench() {
  const auto stack = lower_stack();
  std::fill(stack.begin(), stack.end(), stack_paint);
  timer().reload = 0xFFFFFFFF;
  timer().value = 0xFFFFFFFF;
  timer().control = 1;
  nvic_priority[0] = 0x40;
  nvic_priority[1] = 0xC0;
  nvic_enable = 3;
  if (!board.open()) return exit_no_line;
  for (;;) {
    bool damaged = false;
    const auto frame = receive_frame(board, incoming, damaged);
    if (damaged) return bench.refuse(lockstep::Refused::damaged), exit_refused;
    if (frame.empty()) return exit_end_of_plant;
    if (!bench.handle(frame)) return exit_refused;
  }
}
