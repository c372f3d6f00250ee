#pragma once

#include "firmware/calibration_store.h"

/// The calibration's two slots: the last two pages of the flash's second bank, so that the program, which lies in the
/// first, runs on while a page is erased.

namespace powbench::firmware::stm32g474 {

class CalibrationFlash final : public CalibrationMemory {
 public:
  /// A slot whose reading ended the last run (a write that lost its supply leaves words that the memory's own check
  /// refuses, which is an NMI) is not read again until it has been written.
  std::span<const std::uint8_t> read(unsigned slot) override;
  /// 22 ms for the page, 85 us for each double word. Gives up when the supply falls.
  bool write(unsigned slot, const SlotBytes&) override;

 private:
  SlotBytes copy_{};
};

}  // namespace powbench::firmware::stm32g474
