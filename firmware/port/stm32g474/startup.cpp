#include <cstddef>
#include <cstdint>

#include "firmware/port/stm32g474/board.h"
#include "firmware/port/stm32g474/gate_output.h"
#include "firmware/port/stm32g474/guard.h"
#include "firmware/port/stm32g474/registers/core.h"
#include "firmware/port/stm32g474/registers/timer.h"

/// Vector table, reset and fault handlers. Nothing here relies on memory being set up before the gate is low.

using namespace powbench::firmware::stm32g474;

extern "C" {
[[noreturn]] void run_bench();
// from link.ld
extern std::uint32_t stack_bottom[], stack_top[], data_start[], data_end[], bss_start[], bss_end[];
extern const std::uint32_t data_image[];

[[noreturn]] void start_up();
[[noreturn]] void fault_reset(std::uint32_t frame);
void stop_handler();
void control_handler();
void background_handler();
void samples_handler();
void pvd_handler();
void serial_handler();

// Gate low first. Then every word of RAM that has a parity bit is written, because after power-on reading one that
// nothing has written is an error: the first 32 KiB, and the CCM RAM at the end. What outlives a reset lies between
// the two.
static_assert(parity_low_end == 0x2000'8000 && parity_high == 0x2001'8000 && ram_end == 0x2002'0000);
[[gnu::naked]] void reset_handler() {
  asm volatile(
      "bl hold_gate_low\n\t"
      "movs r0, #0\n\t"
      "movs r1, #0\n\t"
      "movt r1, #0x2000\n\t"
      "movw r2, #0x8000\n\t"
      "movt r2, #0x2000\n"
      "1:\n\t"
      "str r0, [r1], #4\n\t"
      "cmp r1, r2\n\t"
      "bne 1b\n\t"
      "movw r1, #0x8000\n\t"
      "movt r1, #0x2001\n\t"
      "movs r2, #0\n\t"
      "movt r2, #0x2002\n"
      "2:\n\t"
      "str r0, [r1], #4\n\t"
      "cmp r1, r2\n\t"
      "bne 2b\n\t"
      "b start_up");
}

[[noreturn]] void start_up() {
  scb().vtor.write(0x0800'0000);
  cpacr().set(cpacr_fpu);
  asm volatile("dsb\n\tisb");
  const std::uint32_t* from = data_image;
  for (std::uint32_t* to = data_start; to != data_end;) *to++ = *from++;
  for (std::uint32_t* to = bss_start; to != bss_end;) *to++ = 0;
  scb().shcsr.set(Scb::shcsr_usage_bus_memory);
  const bool kept = postmortem.magic == postmortem_magic;
  if (!kept) postmortem = {}, postmortem.magic = postmortem_magic;
  postmortem.kept = kept ? 1 : 0;
  ++postmortem.boots;
  run_bench();
}

/// Leaves a note and restarts. `frame`: what the processor stacked, or 0.
[[noreturn]] void fault_reset(std::uint32_t frame) {
  const auto low = static_cast<std::uint32_t>(reinterpret_cast<std::uintptr_t>(stack_bottom));
  const auto high = static_cast<std::uint32_t>(reinterpret_cast<std::uintptr_t>(stack_top));
  postmortem.exception = scb().icsr.read() & 0x1FFU;
  postmortem.fault_status = scb().cfsr.read();
  postmortem.bus_address = scb().bfar.read();
  postmortem.program_counter = postmortem.link_register = 0;
  const bool stacked = frame >= low && frame + 32 <= high && frame % 4 == 0;
  if (stacked) {
    const auto* words = reinterpret_cast<const std::uint32_t*>(static_cast<std::uintptr_t>(frame));
    postmortem.link_register = words[5];
    postmortem.program_counter = words[6];
  }
  survivor.record_crash(
      stacked ? crash_cause(postmortem.exception) : powbench::firmware::CrashCause::stack_overflow,
      postmortem.program_counter, postmortem.link_register);
  asm volatile("dsb");
  scb().aircr.write(Scb::aircr_reset);
  for (;;) {
  }
}

// Gate off first, with registers only: the stack may be what is broken. The output-enable bit is the only one of the
// register that the lock leaves writable. Then a fresh stack, and the note.
static_assert(tim1_address + offsetof(Timer, bdtr) == 0x4001'2C44);
[[gnu::naked]] void fault_handler() {
  asm volatile(
      "movw r1, #0x2C44\n\t"
      "movt r1, #0x4001\n\t"
      "movs r2, #0\n\t"
      "str r2, [r1]\n\t"
      "mov r0, sp\n\t"
      "ldr r1, =stack_top\n\t"
      "mov sp, r1\n\t"
      "b fault_reset\n\t"
      ".ltorg");
}

using Handler = void (*)();
struct VectorTable {
  const void* stack;
  Handler exceptions[15];
  Handler interrupts[irq_count];
};

constexpr VectorTable make_vectors() {
  VectorTable table{.stack = stack_top, .exceptions = {}, .interrupts = {}};
  for (auto& handler : table.exceptions) handler = fault_handler;
  for (auto& handler : table.interrupts) handler = fault_handler;
  table.exceptions[0] = reset_handler;
  table.exceptions[13] = control_handler;  // PendSV
  table.interrupts[irq_pvd] = pvd_handler;
  table.interrupts[irq_dma1_channel5] = samples_handler;
  table.interrupts[irq_usart2] = serial_handler;
  table.interrupts[irq_exti_10_to_15] = stop_handler;
  table.interrupts[irq_background] = background_handler;
  return table;
}

[[gnu::section(".vectors"), gnu::used]] extern constinit const VectorTable vectors = make_vectors();
}
static_assert(sizeof(void*) != 4 || sizeof(VectorTable) == 4 * (16 + irq_count));
