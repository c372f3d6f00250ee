#include "firmware/port/stm32g474/guard.h"

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
  // one flag for both: what the memory kept tells them apart. A supply that was off for so short a time that it kept
  // all counts as a brown-out, which is the safe side.
  if (flags & Rcc::csr_bor) return postmortem.kept != 0 ? "brown-out" : "power";
  if (flags & Rcc::csr_low_power) return "low-power";
  if (flags & Rcc::csr_obl) return "option-bytes";
  return "pin";  // every cause pulls the pin too, so that this one alone means the pin
}

ResetCause reset_cause(std::string_view word) {
  if (word == "watchdog" || word == "window-watchdog") return ResetCause::watchdog;
  if (word == "fault" || word == "software") return ResetCause::software;
  if (word == "power") return ResetCause::power_on;
  if (word == "brown-out") return ResetCause::brown_out;
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
  pwr().cr2.change(Pwr::cr2_pls, Pwr::cr2_pls_2v9);
  pwr().cr2.set(Pwr::cr2_pvde);
}

std::string_view option_byte_error() {
  const std::uint32_t options = flash().optr.read();
  if ((options & Flash::optr_bor) != Flash::optr_bor_level_4)
    return "option bytes: the brown-out level is not 4 (2.8 V): set it as docs/how-to/board.md says, then "
           "restart";
  if ((options & Flash::optr_no_parity) != 0)
    return "option bytes: the RAM parity check is off: set it as docs/how-to/board.md says, then restart";
  if ((options & Flash::optr_dual_bank) == 0)
    return "option bytes: the flash is one bank: set them as docs/how-to/board.md says, then restart";
  return {};
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
