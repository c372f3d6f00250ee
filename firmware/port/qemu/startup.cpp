#include <algorithm>
#include <cstdint>

#include "firmware/port/qemu/exit_codes.h"
#include "firmware/port/qemu/semihosting.h"

/// What runs before the firmware on the Cortex-M4F of the emulated board (Arm MPS2, image AN386): vector table, FPU,
/// static memory. Reference: Arm, "ARMv7-M Architecture Reference Manual", B1.5 (exceptions), B3.2 (system
/// control).

// places the linker script names
extern "C" {
extern std::uint32_t image_data_load[], image_data_begin[], image_data_end[];
extern std::uint32_t image_bss_begin[], image_bss_end[];
extern std::uint32_t image_stack_begin[], image_stack_end[];
extern void (*image_init_begin[])();
extern void (*image_init_end[])();

int run_bench();
void sample_block_handler();
void background_handler();

[[noreturn]] void reset_handler() {
  auto& coprocessor_access = *reinterpret_cast<volatile std::uint32_t*>(0xE000ED88);
  coprocessor_access = coprocessor_access | 0xFU << 20;  // CP10 and CP11: the FPU is off after reset
  asm volatile("dsb\n\tisb" ::: "memory");
  std::copy(image_data_load, image_data_load + (image_data_end - image_data_begin), image_data_begin);
  std::fill(image_bss_begin, image_bss_end, 0U);
  for (auto init = image_init_begin; init != image_init_end; ++init) (*init)();
  powbench::firmware::semihosting::exit(static_cast<std::uint32_t>(run_bench()));
}

[[noreturn]] void processor_fault(const std::uint32_t* frame);

/// `frame`: what the processor has stacked.
[[gnu::naked]] void fault_handler() {
  asm volatile(
      "mov r0, sp\n\t"
      "b processor_fault");
}

using Vector = void (*)();
extern const Vector vector_table[];
[[gnu::section(".vectors"), gnu::used]] const Vector vector_table[] = {
    reinterpret_cast<Vector>(image_stack_end),
    reset_handler,
    fault_handler,  // NMI
    fault_handler,  // HardFault
    fault_handler,  // MemManage
    fault_handler,  // BusFault
    fault_handler,  // UsageFault
    nullptr,
    nullptr,
    nullptr,
    nullptr,
    fault_handler,  // SVCall
    fault_handler,  // DebugMonitor
    nullptr,
    fault_handler,         // PendSV
    fault_handler,         // SysTick
    sample_block_handler,  // interrupt 0: a block of samples is there
    background_handler,    // interrupt 1: and what may take longer
};
}

/// What the library calls instead of throwing, where the optimiser has not proved that it never does. No
/// libstdc++ is linked: anything else that would throw, or allocate, is an undefined symbol.
namespace std {
[[noreturn]] void __throw_out_of_range_fmt(const char*, ...) {
  powbench::firmware::semihosting::exit(powbench::firmware::exit_processor_fault);
}
}  // namespace std
