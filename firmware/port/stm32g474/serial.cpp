#include "firmware/port/stm32g474/serial.h"

#include "firmware/port/stm32g474/board.h"
#include "firmware/port/stm32g474/registers/io.h"
#include "firmware/port/stm32g474/registers/system.h"

namespace powbench::firmware::stm32g474 {

void Serial::set_up() {
  rcc().ahb1enr.set(Rcc::ahb1enr_dma1 | Rcc::ahb1enr_dmamux1);
  rcc().ahb2enr.set(Rcc::ahb2enr_gpioa);
  rcc().apb1enr1.set(Rcc::apb1enr1_usart2);
  (void)rcc().apb1enr1.read();
  gpioa().pull(pin_serial_rx, Pull::up);
  gpioa().alternate(pin_serial_tx, function_usart2);
  gpioa().alternate(pin_serial_rx, function_usart2);

  dmamux().channel[dma_channel - 1].write(request_usart2_rx);
  DmaChannel& channel = dma1_channel(dma_channel);
  channel.cpar.write(static_cast<std::uint32_t>(reinterpret_cast<std::uintptr_t>(&usart2().rdr)));
  channel.cmar.write(static_cast<std::uint32_t>(reinterpret_cast<std::uintptr_t>(ring_.data())));
  channel.cndtr.write(ring_.size());
  channel.ccr.write(DmaChannel::ccr_circular | DmaChannel::ccr_memory_step | DmaChannel::ccr_priority_high |
                    DmaChannel::ccr_enable);

  dmamux().channel[transmit_channel - 1].write(request_usart2_tx);
  dma1_channel(transmit_channel)
      .cpar.write(static_cast<std::uint32_t>(reinterpret_cast<std::uintptr_t>(&usart2().tdr)));

  usart2().brr.write(core_hertz / baud);
  usart2().cr3.write(Usart::cr3_receive_dma);
  usart2().cr1.write(Usart::cr1_fifo | Usart::cr1_idle | Usart::cr1_transmit | Usart::cr1_receive |
                     Usart::cr1_enable);
}

std::size_t Serial::written() const {
  const std::size_t left = dma1_channel(dma_channel).cndtr.read();
  return left == 0 || left > ring_.size() ? 0 : ring_.size() - left;
}

std::span<const std::uint8_t> Serial::received() {
  return reader_.fresh(ring_, written());
}

std::span<const std::uint8_t> Serial::overheard() {
  return listener_.fresh(ring_, written());
}

void Serial::note_idle() {
  usart2().icr.write(Usart::isr_idle);
}

bool Serial::line_error() {
  if (!usart2().isr.any(Usart::isr_line_errors)) return false;
  usart2().icr.write(Usart::isr_line_errors);
  reader_.skip_to(written());
  return true;
}

/// Sends the bytes from where they are.
void Serial::transmit(std::span<const std::uint8_t> bytes) {
  constexpr std::size_t most = 0xFFFF;  // the channel counts in 16 bits
  DmaChannel& channel = dma1_channel(transmit_channel);
  usart2().cr3.set(Usart::cr3_transmit_dma);
  while (!bytes.empty()) {
    const std::size_t n = bytes.size() < most ? bytes.size() : most;
    channel.cmar.write(static_cast<std::uint32_t>(reinterpret_cast<std::uintptr_t>(bytes.data())));
    channel.cndtr.write(static_cast<std::uint32_t>(n));
    channel.ccr.write(DmaChannel::ccr_to_peripheral | DmaChannel::ccr_memory_step | DmaChannel::ccr_enable);
    for (std::uint32_t left = channel.cndtr.read(), before = left; left > 0; left = channel.cndtr.read()) {
      // only bytes that leave are progress: a line that stands still has to end in the watchdog
      if (left != before) progress_.moved(port::Progress::main_loop);
      before = left;
    }
    channel.ccr.write(0);
    bytes = bytes.subspan(n);
  }
  usart2().cr3.clear(Usart::cr3_transmit_dma);
}

void Serial::put(std::span<const std::uint8_t> bytes) {
  if (bytes.size() >= transmit_by_dma) return transmit(bytes);
  for (const std::uint8_t byte : bytes) {
    while (!usart2().isr.any(Usart::isr_room)) {
    }
    usart2().tdr.write(byte);
    progress_.moved(port::Progress::main_loop);  // 5 us a byte: a long answer is progress too
  }
}

}  // namespace powbench::firmware::stm32g474
