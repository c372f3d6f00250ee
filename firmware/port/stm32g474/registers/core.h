#pragma once

#include "firmware/port/stm32g474/registers/register.h"

/// The processor's own registers (ARMv7-M) and the interrupt numbers in use.

namespace powbench::firmware::stm32g474 {

struct Scb {
  Register cpuid, icsr, vtor, aircr, scr, ccr, shpr[3], shcsr, cfsr, hfsr, dfsr, mmfar, bfar, afsr;
  static constexpr std::uint32_t icsr_pendsv_set = bit(28);
  static constexpr std::uint32_t aircr_reset = 0x05FA'0000U | bit(2);
  static constexpr std::uint32_t shcsr_usage_bus_memory = bit(18) | bit(17) | bit(16);
};
static_assert(offsetof(Scb, vtor) == 0x08 && offsetof(Scb, shpr) == 0x18 && offsetof(Scb, cfsr) == 0x28);
static_assert(offsetof(Scb, mmfar) == 0x34 && offsetof(Scb, bfar) == 0x38);
inline Scb& scb() {
  return at<Scb>(0xE000'ED00);
}

/// Coprocessor access: the floating-point unit is off after reset.
inline Register& cpacr() {
  return at<Register>(0xE000'ED88);
}
inline constexpr std::uint32_t cpacr_fpu = 15U << 20;

struct Nvic {
  Register iser[8], reserved_20[24], icer[8], reserved_a0[24], ispr[8], reserved_120[24], icpr[8],
      reserved_1a0[24], iabr[8], reserved_220[56];
  volatile std::uint8_t ipr[240];

  void enable(unsigned irq, std::uint8_t priority) {
    ipr[irq] = priority;
    iser[irq / 32].write(bit(irq % 32));
  }
  void pend(unsigned irq) { ispr[irq / 32].write(bit(irq % 32)); }
};
static_assert(offsetof(Nvic, icer) == 0x80 && offsetof(Nvic, ispr) == 0x100 && offsetof(Nvic, ipr) == 0x300);
inline Nvic& nvic() {
  return at<Nvic>(0xE000'E100);
}

/// Positions in the interrupt part of the vector table.
/// `irq_background` is the random generator's, which is off: software alone pends it.
enum Irq : unsigned {
  irq_pvd = 1,
  irq_dma1_channel5 = 15,
  irq_usart2 = 38,
  irq_exti_10_to_15 = 40,
  irq_background = 90,
  irq_count = 102
};

/// The upper four bits of a priority count; a small number goes first. Control step
/// and background have the lowest: everything that must not wait interrupts them, and `controller_lock` keeps out
/// nothing but them.
inline constexpr std::uint8_t priority_cut_off = 0x00, priority_samples = 0x40, priority_control = 0xC0,
                              priority_background = 0xE0;

/// Keeps control step and background out while the main loop touches the controller.
inline void hold_off_controller(bool held) {
  const std::uint32_t level = held ? priority_control : 0U;
  asm volatile("msr basepri, %0\n\tisb" : : "r"(level) : "memory");
}

/// Keeps every interrupt out while it lives: for a few instructions only.
class NoInterrupts {
 public:
  NoInterrupts() { asm volatile("cpsid i" : : : "memory"); }
  ~NoInterrupts() { asm volatile("cpsie i" : : : "memory"); }
  NoInterrupts(const NoInterrupts&) = delete;
  NoInterrupts& operator=(const NoInterrupts&) = delete;
};

}  // namespace powbench::firmware::stm32g474
