#pragma once

#include "firmware/port/stm32g474/registers/register.h"

/// Pins, direct memory access, serial port.

namespace powbench::firmware::stm32g474 {

enum class PinMode : std::uint32_t { input = 0, output = 1, alternate = 2, analog = 3 };
enum class Pull : std::uint32_t { none = 0, up = 1, down = 2 };

struct Gpio {
  Register moder, otyper, ospeedr, pupdr, idr, odr, bsrr, lckr, afr[2], brr;

  void mode(unsigned pin, PinMode m) {
    moder.change(3U << 2 * pin, static_cast<std::uint32_t>(m) << 2 * pin);
  }
  void pull(unsigned pin, Pull p) { pupdr.change(3U << 2 * pin, static_cast<std::uint32_t>(p) << 2 * pin); }
  void alternate(unsigned pin, std::uint32_t function) {
    afr[pin / 8].change(15U << 4 * (pin % 8), function << 4 * (pin % 8));
    mode(pin, PinMode::alternate);
  }
};
static_assert(offsetof(Gpio, bsrr) == 0x18 && offsetof(Gpio, afr) == 0x20 && offsetof(Gpio, brr) == 0x28);
inline Gpio& gpioa() {
  return at<Gpio>(0x4800'0000);
}
inline Gpio& gpiob() {
  return at<Gpio>(0x4800'0400);
}
inline Gpio& gpioc() {
  return at<Gpio>(0x4800'0800);
}

struct DmaChannel {
  Register ccr, cndtr, cpar, cmar, reserved;
  static constexpr std::uint32_t ccr_enable = bit(0), ccr_full_irq = bit(1), ccr_half_irq = bit(2),
                                 ccr_to_peripheral = bit(4), ccr_circular = bit(5), ccr_memory_step = bit(7),
                                 ccr_from_16 = 1U << 8, ccr_to_16 = 1U << 10, ccr_from_32 = 2U << 8,
                                 ccr_to_32 = 2U << 10, ccr_priority_high = 2U << 12,
                                 ccr_priority_highest = 3U << 12;
};
struct Dma {
  Register isr, ifcr;
  DmaChannel channel[8];
  /// Flags of channel 1 .. 8 in isr and ifcr.
  static constexpr std::uint32_t all(unsigned n) { return 15U << 4 * (n - 1); }
  static constexpr std::uint32_t full(unsigned n) { return 2U << 4 * (n - 1); }
  static constexpr std::uint32_t half(unsigned n) { return 4U << 4 * (n - 1); }
};
static_assert(sizeof(DmaChannel) == 0x14 && offsetof(Dma, channel) == 0x08);
inline Dma& dma1() {
  return at<Dma>(0x4002'0000);
}
inline DmaChannel& dma1_channel(unsigned n) {
  return dma1().channel[n - 1];
}

/// Request lines: DMA1 channel n is multiplexer channel n - 1.
struct Dmamux {
  Register channel[16];
};
inline Dmamux& dmamux() {
  return at<Dmamux>(0x4002'0800);
}
inline constexpr std::uint32_t request_adc[] = {5, 36, 37, 38, 39}, request_usart2_rx = 26,
                               request_usart2_tx = 27, request_tim2_ch1 = 56;

struct Usart {
  Register cr1, cr2, cr3, brr, gtpr, rtor, rqr, isr, icr, rdr, tdr, presc;
  static constexpr std::uint32_t cr1_enable = bit(0), cr1_receive = bit(2), cr1_transmit = bit(3),
                                 cr1_idle = bit(4), cr1_fifo = bit(29);
  static constexpr std::uint32_t cr3_receive_dma = bit(6), cr3_transmit_dma = bit(7);
  static constexpr std::uint32_t isr_line_errors =
      15U;  ///< parity, framing, noise, overrun; the same bits clear them
  static constexpr std::uint32_t isr_idle = bit(4), isr_room = bit(7);  ///< icr clears idle by the same bit
};
static_assert(offsetof(Usart, brr) == 0x0C && offsetof(Usart, isr) == 0x1C && offsetof(Usart, tdr) == 0x28);
inline Usart& usart2() {
  return at<Usart>(0x4000'4400);
}

}  // namespace powbench::firmware::stm32g474
