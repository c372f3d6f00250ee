#include "firmware/port/stm32g474/guard.h"

#include "firmware/port/stm32g474/gate_output.h"
#include "firmware/port/stm32g474/registers/core.h"
#include "firmware/port/stm32g474/registers/system.h"

namespace powbench::firmware::stm32g474 {

[[gnu::section(".noinit")]] Postmortem postmortem;
[[gnu::section(".noinit")]] Survivor survivor;

std::string_view take_reset_cause() {
  const std::uint32_t flags = rcc().csr.read();
  rcc().csr.set(Rcc::csr_rmvf);
  if (flags & Rcc::csr_iwdg) return "watchdog";
  if (flags & Rcc::csr_wwdg) return "window-watchdog";
  if (flags & Rcc::csr_software) return postmortem.exception != 0 ? "fault" : "software";
  if (flags & Rcc::csr_bor) return "power";
  if (flags & Rcc::csr_low_power) return "low-power";
  if (flags & Rcc::csr_obl) return "option-bytes";
  return "pin";  // every cause pulls the pin too, so that this one alone means the pin
}

ResetCause reset_cause(std::string_view word) {
  if (word == "watchdog" || word == "window-watchdog") return ResetCause::watchdog;
  if (word == "fault" || word == "software") return ResetCause::software;
  // one flag for power-on and brown-out: the memory tells them apart no better than the flag does
  if (word == "power") return ResetCause::power_on;
  return ResetCause::pin;
}

CrashCause crash_cause(std::uint32_t exception) {
  switch (exception) {
    case 2:
      return CrashCause::nmi;
    case 3:
      return CrashCause::hard_fault;
    case 4:
      return CrashCause::memory_fault;
    case 5:
      return CrashCause::bus_fault;
    case 6:
      return CrashCause::usage_fault;
    default:
      return CrashCause::assertion;  // an interrupt that nobody has asked for
  }
}

void start_supply_monitor() {
  pwr().cr2.change(Pwr::cr2_pls, 6U << 1);
  pwr().cr2.set(Pwr::cr2_pvde);
  exti().rtsr1.set(Exti::line_pvd);
  exti().imr1.set(Exti::line_pvd);
  nvic().enable(irq_pvd, priority_cut_off);
}

bool supply_low() {
  return pwr().sr2.any(Pwr::sr2_pvdo);
}

void start_watchdog() {
  // a debugger that halts the core stops the clocks of watchdog and timers, and the gate timer's outputs with them
  dbgmcu().apb1fzr1.set(Dbgmcu::apb1fzr1_iwdg | Dbgmcu::apb1fzr1_tim3);
  dbgmcu().apb2fz.set(Dbgmcu::apb2fz_tim1);
  iwdg().kr.write(Iwdg::key_start);
  iwdg().kr.write(Iwdg::key_unlock);
  iwdg().pr.write(2);     // 32 kHz / 16
  iwdg().rlr.write(200);  // 100 ms; the oscillator's tolerance makes it 94 .. 106 ms
  while (iwdg().sr.any(Iwdg::sr_busy)) {
  }
  feed_watchdog();
}

void feed_watchdog() {
  iwdg().kr.write(Iwdg::key_reload);
}

}  // namespace powbench::firmware::stm32g474

extern "C" void pvd_handler() {
  using namespace powbench::firmware::stm32g474;
  exti().pr1.write(Exti::line_pvd);
  gate_off();
}
