#include "firmware/port/stm32g474/gate_output.h"

#include <atomic>

#include "firmware/port/stm32g474/board.h"
#include "firmware/port/stm32g474/front_end.h"
#include "firmware/port/stm32g474/registers/analog.h"
#include "firmware/port/stm32g474/registers/core.h"
#include "firmware/port/stm32g474/registers/io.h"
#include "firmware/port/stm32g474/registers/system.h"
#include "firmware/port/stm32g474/registers/timer.h"

namespace powbench::firmware::stm32g474 {

namespace {

/// Everything in this register but the output enable is locked until the next reset.
constexpr std::uint32_t cut_off_settings = Timer::bdtr_lock_2 | Timer::bdtr_idle_driven |
                                           Timer::bdtr_run_driven | Timer::bdtr_break |
                                           Timer::bdtr_break_high;
constexpr std::uint32_t trip_flags = Timer::sr_break | Timer::sr_break2 | Timer::sr_system_break;

std::atomic<std::uint8_t> cuts{0};  ///< Cut, one bit each

constexpr unsigned end_channel = 8;  ///< of DMA1
/// What the end of the hold time writes into the output enable's register, without an instruction.
constexpr std::uint32_t end_word = cut_off_settings;

/// Second compare: when its 32-bit count is reached, a DMA transfer takes the output enable away.
void arm_end(std::int64_t ticks) {
  DmaChannel& channel = dma1_channel(end_channel);
  channel.ccr.write(0);
  dma1().ifcr.write(Dma::all(end_channel));
  channel.cndtr.write(1);
  channel.ccr.write(DmaChannel::ccr_to_peripheral | DmaChannel::ccr_from_32 | DmaChannel::ccr_to_32 |
                    DmaChannel::ccr_priority_highest | DmaChannel::ccr_enable);
  tim2().ccr[0].write(tim2().cnt.read() + static_cast<std::uint32_t>(ticks));
  tim2().sr.write(0);
  tim2().dier.write(Timer::dier_ch1_dma);
}

void disarm_end() {
  tim2().dier.write(0);
  dma1_channel(end_channel).ccr.write(0);
}

void set_up_end() {
  rcc().ahb1enr.set(Rcc::ahb1enr_dma1 | Rcc::ahb1enr_dmamux1);
  rcc().apb1enr1.set(Rcc::apb1enr1_tim2);
  (void)rcc().apb1enr1.read();
  dmamux().channel[end_channel - 1].write(request_tim2_ch1);
  DmaChannel& channel = dma1_channel(end_channel);
  channel.cpar.write(static_cast<std::uint32_t>(reinterpret_cast<std::uintptr_t>(&tim1().bdtr)));
  channel.cmar.write(static_cast<std::uint32_t>(reinterpret_cast<std::uintptr_t>(&end_word)));
  Timer& t = tim2();
  t.psc.write(0);
  t.arr.write(0xFFFF'FFFF);
  t.cr1.write(Timer::cr1_only_overflow);
  t.cr1.set(Timer::cr1_enable);
}

void set_mode(std::uint32_t mode) {
  tim1().ccmr2.change(Timer::oc3_mode, mode);
}

/// Coil current on PB0 and PB1 against two levels: above the upper one or below the lower one is a trip.
void set_up_comparators() {
  rcc().ahb2enr.set(Rcc::ahb2enr_dac3);
  (void)rcc().ahb2enr.read();
  dac3().mcr.write(Dac::mcr_internal);
  dac3().dhr12r1.write(comparator_level(cut_off_ampere));
  dac3().dhr12r2.write(comparator_level(-cut_off_ampere));
  dac3().cr.write(Dac::cr_enable_1 | Dac::cr_enable_2);
  spin(1000);  // the levels settle before anything looks at them
  constexpr std::uint32_t common =
      Comp::csr_enable | Comp::csr_minus_dac3 | Comp::csr_hysteresis_20mv | Comp::csr_lock;
  comp1().csr.write(common | Comp::csr_plus_second);  // PB1 above channel 1
  comp4().csr.write(common | Comp::csr_inverted);     // PB0 below channel 2
}

}  // namespace

extern "C" void hold_gate_low() {
  rcc().ahb2enr.set(Rcc::ahb2enr_gpioa);
  (void)rcc().ahb2enr.read();
  gpioa().brr.write(bit(pin_gate));
  gpioa().mode(pin_gate, PinMode::output);
}

void set_up_gate() {
  rcc().apb2enr.set(Rcc::apb2enr_syscfg | Rcc::apb2enr_tim1);
  rcc().ahb2enr.set(Rcc::ahb2enr_gpioa | Rcc::ahb2enr_gpioc);
  (void)rcc().ahb2enr.read();
  set_up_comparators();
  set_up_end();
  syscfg().cfgr2.write(Syscfg::cfgr2_lockup | Syscfg::cfgr2_parity | Syscfg::cfgr2_pvd | Syscfg::cfgr2_ecc);

  Timer& t = tim1();
  t.psc.write(0);
  t.arr.write(0xFFFF);
  t.cr1.write(Timer::cr1_only_overflow);
  set_mode(Timer::oc3_forced_off);
  t.ccer.write(Timer::ccer_ch3);
  t.af1.write(Timer::af1_comp1 | Timer::af1_comp4);
  t.bdtr.write(cut_off_settings);
  t.sr.write(~trip_flags);
  gpioa().alternate(pin_gate, function_tim1);

  gpioa().mode(pin_lamp, PinMode::output);
  gpioc().pull(pin_stop, Pull::up);
  gpioc().mode(pin_stop, PinMode::input);
  gpioc().pull(pin_relay, Pull::up);
  gpioc().mode(pin_relay, PinMode::input);
  gpioc().mode(pin_charge_pump, PinMode::output);
}

void enable_cuts() {
  syscfg().exticr[2].change(Syscfg::exticr3_line_10, Syscfg::exticr3_line_10_port_c);
  exti().rtsr1.set(Exti::line_pvd | Exti::line_stop);
  exti().pr1.write(Exti::line_pvd | Exti::line_stop);
  exti().imr1.set(Exti::line_pvd | Exti::line_stop);
  nvic().enable(irq_pvd, priority_cut_off);
  nvic().enable(irq_exti_10_to_15, priority_cut_off);
}

void cut_gate(Cut cause) {
  cuts.fetch_or(static_cast<std::uint8_t>(cause), std::memory_order_relaxed);
  gate_off();
}

bool cut_by(Cut cause) {
  return (cuts.load(std::memory_order_relaxed) & static_cast<std::uint8_t>(cause)) != 0;
}

void forget_cut() {
  cuts.store(0, std::memory_order_relaxed);
}

bool gate_open() {
  return tim1().bdtr.any(Timer::bdtr_output);
}

void gate_off() {
  const NoInterrupts whole;
  tim1().bdtr.write(cut_off_settings);
  set_mode(Timer::oc3_forced_off);
  disarm_end();
  gpioa().brr.write(bit(pin_lamp));
}

bool write_gate(const port::GateTimer::Action& action) {
  using Write = port::GateTimer::Write;
  Timer& t = tim1();
  switch (action.write) {
    case Write::on_at: {
      if (cut_off_tripped()) return false;
      const NoInterrupts whole;  // a cut comes before all of this or after it
      if (cuts.load(std::memory_order_relaxed) != 0) return false;
      set_mode(Timer::oc3_forced_off);  // the reference is low whatever was before
      t.ccr[2].write(action.compare);
      set_mode(Timer::oc3_on_at_match);
      arm_end(action.off_in);
      t.bdtr.write(cut_off_settings | Timer::bdtr_output);  // the one line that opens the gate's door
      gpioa().bsrr.write(bit(pin_lamp));
      return true;
    }
    case Write::off_at: {
      const NoInterrupts whole;
      set_mode(Timer::oc3_frozen);  // the level stays while the compare changes
      t.ccr[2].write(action.compare);
      set_mode(Timer::oc3_off_at_match);
      return true;
    }
    case Write::off_now:
    case Write::finished:
      gate_off();
      return true;
    case Write::nothing:
      return true;
  }
  return true;
}

bool cut_off_tripped() {
  if (!tim1().sr.any(trip_flags)) return false;
  tim1().sr.write(~trip_flags);  // comes back at once while the cause stands
  return true;
}

std::uint16_t gate_counter() {
  return static_cast<std::uint16_t>(tim1().cnt.read());
}

bool stop_open() {
  return gpioc().idr.any(bit(pin_stop));
}

bool relay_in() {
  return gpioc().idr.any(bit(pin_relay));
}

void pump_safety_relay() {
  gpioc().odr.write(gpioc().odr.read() ^ bit(pin_charge_pump));
}

}  // namespace powbench::firmware::stm32g474

extern "C" void stop_handler() {
  using namespace powbench::firmware::stm32g474;
  exti().pr1.write(Exti::line_stop);
  cut_gate(Cut::stop);
}

extern "C" void pvd_handler() {
  using namespace powbench::firmware::stm32g474;
  exti().pr1.write(Exti::line_pvd);
  cut_gate(Cut::supply);
}
