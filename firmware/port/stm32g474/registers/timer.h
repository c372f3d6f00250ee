#pragma once

#include "firmware/port/stm32g474/registers/register.h"

namespace powbench::firmware::stm32g474 {

struct Timer {
  Register cr1, cr2, smcr, dier, sr, egr, ccmr1, ccmr2, ccer, cnt, psc, arr, rcr, ccr[4], bdtr, ccr5, ccr6,
      ccmr3, dtr2, ecr, tisel, af1, af2;
  static constexpr std::uint32_t cr1_enable = bit(0), cr1_only_overflow = bit(2);
  static constexpr std::uint32_t cr2_trgo_enable = 1U << 4, cr2_trgo_update = 2U << 4;
  static constexpr std::uint32_t smcr_start_on_itr0 = 6U;
  static constexpr std::uint32_t sr_break = bit(7), sr_break2 = bit(8), sr_system_break = bit(13);
  static constexpr std::uint32_t dier_ch1_dma = bit(9);
  /// Mode of compare channel 3, in ccmr2.
  static constexpr std::uint32_t oc3_mode = 7U << 4 | bit(16), oc3_frozen = 0, oc3_on_at_match = 1U << 4,
                                 oc3_off_at_match = 2U << 4, oc3_forced_off = 4U << 4;
  static constexpr std::uint32_t ccer_ch3 = bit(8);
  static constexpr std::uint32_t bdtr_lock_2 = 2U << 8, bdtr_idle_driven = bit(10), bdtr_run_driven = bit(11),
                                 bdtr_break = bit(12), bdtr_break_high = bit(13), bdtr_output = bit(15);
  static constexpr std::uint32_t af1_comp1 = bit(1), af1_comp4 = bit(4);
};
static_assert(offsetof(Timer, egr) == 0x14 && offsetof(Timer, ccmr2) == 0x1C && offsetof(Timer, cnt) == 0x24);
static_assert(offsetof(Timer, arr) == 0x2C && offsetof(Timer, ccr) == 0x34 && offsetof(Timer, bdtr) == 0x44);
static_assert(offsetof(Timer, ccmr3) == 0x50 && offsetof(Timer, af1) == 0x60);

inline constexpr std::uint32_t tim1_address = 0x4001'2C00;
inline Timer& tim1() {
  return at<Timer>(tim1_address);
}
/// The one with 32 bits.
inline Timer& tim2() {
  return at<Timer>(0x4000'0000);
}
inline Timer& tim3() {
  return at<Timer>(0x4000'0400);
}

}  // namespace powbench::firmware::stm32g474
