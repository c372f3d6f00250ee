#include "firmware/port/stm32g474/clock.h"

#include "firmware/port/stm32g474/registers/system.h"

namespace powbench::firmware::stm32g474 {

namespace {

/// 24 MHz / 6 or 16 MHz / 4, times 85, halved: 170 MHz either way.
void start_pll(bool crystal) {
  const std::uint32_t divider = crystal ? 6 : 4;
  rcc().pllcfgr.write((crystal ? Rcc::pllcfgr_src_hse : Rcc::pllcfgr_src_hsi) | (divider - 1) << 4 |
                      85U << 8 | Rcc::pllcfgr_ren);
  rcc().cr.set(Rcc::cr_pllon);
  while (!rcc().cr.any(Rcc::cr_pllrdy)) {
  }
}

}  // namespace

bool start_clock() {
  rcc().apb1enr1.set(Rcc::apb1enr1_pwr);
  (void)rcc().apb1enr1.read();  // the bus needs a moment after the clock comes on
  pwr().cr1.change(Pwr::cr1_vos, Pwr::cr1_vos_range_1);
  while (pwr().sr2.any(Pwr::sr2_vosf)) {
  }
  pwr().cr5.clear(Pwr::cr5_r1mode);

  // four wait states before the clock needs them
  flash().acr.change(Flash::acr_latency, 4U | Flash::acr_prefetch | Flash::acr_icache | Flash::acr_dcache);
  while ((flash().acr.read() & Flash::acr_latency) != 4U) {
  }

  rcc().cr.set(Rcc::cr_hseon);
  const bool crystal =
      wait_for(rcc().cr, Rcc::cr_hserdy, 100'000);  // some 40 ms; a crystal takes 2, the watchdog 100
  start_pll(crystal);

  // over half the speed for a microsecond, so that the core's supply does not see the whole step
  rcc().cfgr.change(Rcc::cfgr_hpre | Rcc::cfgr_ppre, Rcc::cfgr_hpre_2);
  rcc().cfgr.change(Rcc::cfgr_sw, Rcc::cfgr_sw_pll);
  while ((rcc().cfgr.read() & Rcc::cfgr_sws_pll) != Rcc::cfgr_sws_pll) {
  }
  spin(100);
  rcc().cfgr.clear(Rcc::cfgr_hpre);

  if (crystal) rcc().cr.set(Rcc::cr_csson);  // a crystal that stops breaks the gate and raises an NMI
  return crystal;
}

}  // namespace powbench::firmware::stm32g474
