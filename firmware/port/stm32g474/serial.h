#pragma once

#include <cstdint>
#include <span>

#include "firmware/iiod/responder.h"
#include "firmware/port/common/progress.h"
#include "firmware/port/common/uart_link.h"

namespace powbench::firmware::stm32g474 {

/// USART2 on the board's virtual serial port, 2 Mbaud 8N1. Bytes come in through a circular buffer; answers leave
/// through the hardware's FIFO, a record straight from the recorder's memory by DMA. The main loop waits meanwhile:
/// it has nothing else to do, everything urgent interrupts it, and what is being sent cannot change under the DMA.
class Serial final : public iiod::ByteSink {
 public:
  explicit Serial(port::Progress& progress) : progress_(progress) {}

  void set_up();
  /// Bytes received since the last call, in one piece; empty: none.
  std::span<const std::uint8_t> received();
  /// The same for a second reader, who interrupts the first and takes nothing from it.
  std::span<const std::uint8_t> overheard();
  /// Ends the interrupt that comes when the line has been idle for one byte.
  static void note_idle();
  /// The line reported an error since the last call; what was received before it is gone.
  bool line_error();
  void put(std::span<const std::uint8_t> bytes) override;

 private:
  static constexpr unsigned dma_channel = 6;
  static constexpr unsigned transmit_channel = 7;
  static constexpr std::size_t transmit_by_dma = 64;  ///< bytes: fewer go through the FIFO
  std::size_t written() const;
  void transmit(std::span<const std::uint8_t> bytes);

  port::Progress& progress_;
  std::array<std::uint8_t, 512> ring_{};
  port::RingReader reader_, listener_;
};

}  // namespace powbench::firmware::stm32g474
