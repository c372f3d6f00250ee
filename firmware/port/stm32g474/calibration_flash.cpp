#include "firmware/port/stm32g474/calibration_flash.h"

#include "firmware/port/stm32g474/board.h"
#include "firmware/port/stm32g474/guard.h"
#include "firmware/port/stm32g474/registers/system.h"

namespace powbench::firmware::stm32g474 {

namespace {

volatile std::uint32_t* words_of(unsigned slot) {
  return reinterpret_cast<volatile std::uint32_t*>(slot_address[slot]);
}

bool finished() {
  constexpr std::uint32_t loops = 3'000'000;  // some 50 ms; a page takes 22, a double word 0.1
  std::uint32_t left = loops;
  while (flash().sr.any(Flash::sr_busy))
    if (left-- == 0) return false;
  return !flash().sr.any(Flash::sr_errors);
}

bool erase(unsigned slot) {
  const std::uint32_t page = slot_page[slot] << Flash::cr_page_shift;
  flash().cr.write(Flash::cr_page_erase | Flash::cr_bank_2 | page);
  flash().cr.set(Flash::cr_start);
  return finished();
}

bool program(unsigned slot, const SlotBytes& bytes) {
  volatile std::uint32_t* to = words_of(slot);
  const auto word = [&](std::size_t at) {
    return static_cast<std::uint32_t>(bytes[at]) | static_cast<std::uint32_t>(bytes[at + 1]) << 8 |
           static_cast<std::uint32_t>(bytes[at + 2]) << 16 | static_cast<std::uint32_t>(bytes[at + 3]) << 24;
  };
  for (std::size_t at = 0; at < bytes.size(); at += 8) {
    if (supply_low()) return false;
    flash().cr.write(Flash::cr_program);
    const std::uint32_t low = word(at), high = word(at + 4);
    *to++ = low;
    asm volatile("isb");
    *to++ = high;
    if (!finished()) return false;
  }
  return true;
}

/// The data cache still holds the values from before the write.
void forget_cached(bool on) {
  if (!on) return flash().acr.clear(Flash::acr_dcache);
  flash().acr.set(Flash::acr_dcache_reset);
  flash().acr.clear(Flash::acr_dcache_reset);
  flash().acr.set(Flash::acr_dcache);
}

}  // namespace

std::span<const std::uint8_t> CalibrationFlash::read(unsigned slot) {
  if (postmortem.reading != 0)
    postmortem.unreadable |= 1U << (postmortem.reading - 1);  // it ended the last run
  postmortem.reading = 0;
  if ((postmortem.unreadable >> slot & 1U) != 0) return {};
  postmortem.reading = slot + 1;
  asm volatile("dsb" : : : "memory");
  const volatile std::uint32_t* from = words_of(slot);
  for (std::size_t at = 0; at < copy_.size(); at += 4) {
    const std::uint32_t word = *from++;
    for (std::size_t i = 0; i < 4; ++i) copy_[at + i] = static_cast<std::uint8_t>(word >> (8 * i) & 0xFFU);
  }
  asm volatile("dsb" : : : "memory");
  postmortem.reading = 0;
  return copy_;
}

bool CalibrationFlash::write(unsigned slot, const SlotBytes& bytes) {
  if (supply_low() || flash().sr.any(Flash::sr_busy)) return false;
  flash().keyr.write(Flash::key_1);
  flash().keyr.write(Flash::key_2);
  flash().sr.write(Flash::sr_errors | Flash::sr_end);
  forget_cached(false);
  const bool erased = erase(slot);
  if (erased) postmortem.unreadable &= ~(1U << slot);
  const bool good = erased && program(slot, bytes);
  flash().cr.write(Flash::cr_lock);
  forget_cached(true);
  return good;
}

}  // namespace powbench::firmware::stm32g474
