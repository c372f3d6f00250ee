#include "firmware/port/stm32g474/converters.h"

#include "firmware/port/stm32g474/registers/analog.h"
#include "firmware/port/stm32g474/registers/core.h"
#include "firmware/port/stm32g474/registers/io.h"
#include "firmware/port/stm32g474/registers/system.h"
#include "firmware/port/stm32g474/registers/timer.h"

namespace powbench::firmware::stm32g474 {

namespace {

void set_up_pins() {
  rcc().ahb2enr.set(Rcc::ahb2enr_gpioa | Rcc::ahb2enr_gpiob | Rcc::ahb2enr_gpioc);
  // analog is the state after reset; said again so that a reset of the core alone gives the same
  for (const unsigned pin : {8U, 9U}) gpioa().mode(pin, PinMode::analog);
  for (const unsigned pin : {0U, 1U, 13U, 14U, 15U}) gpiob().mode(pin, PinMode::analog);
  for (const unsigned pin : {0U, 1U}) gpioc().mode(pin, PinMode::analog);
}

void set_up_converter(unsigned number) {
  Adc& a = adc(number);
  const Sequence& sequence = sequences[number - 1];
  a.cr.write(Adc::cr_regulator);  // also ends the deep sleep
  spin(core_hertz / 50'000);      // at least 20 us for the regulator
  a.cr.write(Adc::cr_regulator | Adc::cr_calibrate);
  while (a.cr.any(Adc::cr_calibrate)) {
  }
  spin(100);  // four converter cycles between the end of the calibration and the enable bit

  for (unsigned r = 0; r < sequence.ranks; ++r) {
    const unsigned input = sequence.inputs[r];
    Register& times = input < 10 ? a.smpr1 : a.smpr2;
    times.set(Adc::sample_6_5 << 3 * (input % 10));
  }
  a.sqr[0].write((sequence.ranks - 1U) | static_cast<std::uint32_t>(sequence.inputs[0]) << 6 |
                 static_cast<std::uint32_t>(sequence.inputs[1]) << 12);
  a.cfgr.write(Adc::cfgr_dma | Adc::cfgr_dma_circular | Adc::cfgr_rising | Adc::cfgr_tim3_trgo |
               Adc::cfgr_overwrite | Adc::cfgr_no_queue);
  // one trigger gives all samples of the sum; nothing is shifted away
  a.cfgr2.write(Adc::cfgr2_oversample | (sequence.ranks == 1 ? Adc::cfgr2_ratio_16 : Adc::cfgr2_ratio_8));
  a.isr.write(Adc::isr_ready);
  a.cr.write(Adc::cr_regulator | Adc::cr_enable);
  while (!a.isr.any(Adc::isr_ready)) {
  }
}

void set_up_buffer(unsigned number, volatile std::uint16_t* buffer) {
  DmaChannel& channel = dma1_channel(number);
  dmamux().channel[number - 1].write(request_adc[number - 1]);
  channel.ccr.write(0);
  channel.cpar.write(static_cast<std::uint32_t>(reinterpret_cast<std::uintptr_t>(&adc(number).dr)));
  channel.cmar.write(static_cast<std::uint32_t>(reinterpret_cast<std::uintptr_t>(buffer)));
  channel.cndtr.write(2 * block_samples * sequences[number - 1].ranks);
  // the last channel is served last and speaks for all
  const std::uint32_t interrupts =
      number == converters ? DmaChannel::ccr_half_irq | DmaChannel::ccr_full_irq : 0;
  channel.ccr.write(DmaChannel::ccr_circular | DmaChannel::ccr_memory_step | DmaChannel::ccr_from_16 |
                    DmaChannel::ccr_to_16 | DmaChannel::ccr_priority_highest | interrupts |
                    DmaChannel::ccr_enable);
}

}  // namespace

void Converters::set_up() {
  set_up_pins();
  rcc().ahb1enr.set(Rcc::ahb1enr_dma1 | Rcc::ahb1enr_dmamux1);
  rcc().ahb2enr.set(Rcc::ahb2enr_adc12 | Rcc::ahb2enr_adc345);
  (void)rcc().ahb2enr.read();
  adc12_common().ccr.write(AdcCommon::ccr_hclk_4);
  adc345_common().ccr.write(AdcCommon::ccr_hclk_4);
  for (unsigned number = 1; number <= converters; ++number) {
    set_up_converter(number);
    set_up_buffer(number, buffers_[number - 1].data());
    adc(number).cr.set(Adc::cr_start);  // waits for the trigger
  }
  nvic().enable(irq_dma1_channel5, priority_samples);
}

bool Converters::all_there(std::uint32_t flag_of_first) const {
  // All conversions are triggered at once and take equally long, but five transfers share one bus: give the others a
  // microsecond.
  std::uint32_t wanted = 0;
  for (unsigned n = 0; n < converters; ++n) wanted |= flag_of_first << 4 * n;
  for (int i = 0; i < 40; ++i)
    if ((dma1().isr.read() & wanted) == wanted) return true;
  return false;
}

bool Converters::collect(Queue& queue, const port::Alarms& alarms) {
  const std::uint32_t flags = dma1().isr.read();
  const auto due = order_.next((flags & Dma::half(converters)) != 0, (flags & Dma::full(converters)) != 0);
  using Due = port::HalfOrder::Due;
  if (due == Due::nothing) return true;
  bool whole = due != Due::lost && all_there(due == Due::first ? Dma::half(1) : Dma::full(1));
  std::uint32_t clear = 0;
  for (unsigned n = 1; n <= converters; ++n) {
    clear |= Dma::all(n);
    if (!adc(n).isr.any(Adc::isr_overrun)) continue;
    adc(n).isr.write(Adc::isr_overrun);
    whole = false;
  }
  dma1().ifcr.write(clear);

  const std::int64_t first = samples_;
  samples_ += due == Due::lost ? port::HalfOrder::halves_lost * block_samples : block_samples;
  if (due == Due::lost) return false;  // the next block tells it by its index
  auto* slot = queue.free_slot();
  if (slot == nullptr) return false;
  std::array<port::ConverterHalf, converters> halves;
  for (std::size_t c = 0; c < converters; ++c) {
    const std::size_t ranks = sequences[c].ranks;
    const std::size_t offset = due == Due::first ? 0 : block_samples * ranks;
    halves[c] = {buffers_[c].data() + offset, sequences[c].ranks};
  }
  slot->first_sample = first;
  slot->alarms = alarms;
  // it goes on all the same: a converter that fails for good must not keep the control step from learning of it
  slot->overrun = !whole;
  port::assemble(halves, channel_sources, slot->scans);
  queue.commit();
  return whole;
}

void start_sampling() {
  rcc().apb1enr1.set(Rcc::apb1enr1_tim3);
  (void)rcc().apb1enr1.read();
  Timer& t = tim3();
  t.psc.write(0);
  t.arr.write(time_base.ticks_per_sample - 1);
  // no update event by software: it would be a trigger, and the converters wait for the first one
  t.cr1.write(Timer::cr1_only_overflow);
  t.cr2.write(Timer::cr2_trgo_update);
  t.smcr.write(Timer::smcr_start_on_itr0);  // starts with TIM1
  tim1().cnt.write(0);
  tim1().cr2.write(Timer::cr2_trgo_enable);
  tim1().cr1.set(Timer::cr1_enable);
}

}  // namespace powbench::firmware::stm32g474
