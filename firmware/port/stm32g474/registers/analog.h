#pragma once

#include "firmware/port/stm32g474/registers/register.h"

/// Converters, comparators and the digital-to-analog converter that sets their levels.

namespace powbench::firmware::stm32g474 {

struct Adc {
  Register isr, ier, cr, cfgr, cfgr2, smpr1, smpr2, reserved_1c, tr[3], reserved_2c, sqr[4], dr,
      reserved_44[2], jsqr, reserved_50[4], ofr[4], reserved_70[4], jdr[4], reserved_90[4], awd2cr, awd3cr,
      reserved_a8[2], difsel, calfact;
  static constexpr std::uint32_t isr_ready = bit(0), isr_overrun = bit(4);
  static constexpr std::uint32_t cr_enable = bit(0), cr_start = bit(2), cr_regulator = bit(28),
                                 cr_deep_sleep = bit(29), cr_calibrate = bit(31);
  static constexpr std::uint32_t cfgr_dma = bit(0), cfgr_dma_circular = bit(1), cfgr_rising = 1U << 10,
                                 cfgr_overwrite = bit(12), cfgr_tim3_trgo = 4U << 5, cfgr_no_queue = bit(31);
  static constexpr std::uint32_t cfgr2_oversample = bit(0), cfgr2_ratio_8 = 2U << 2, cfgr2_ratio_16 = 3U << 2;
  static constexpr std::uint32_t sample_6_5 = 1U;  ///< code of 6.5 ADC cycles, three bits a channel
};
static_assert(offsetof(Adc, smpr1) == 0x14 && offsetof(Adc, tr) == 0x20 && offsetof(Adc, sqr) == 0x30);
static_assert(offsetof(Adc, dr) == 0x40 && offsetof(Adc, jsqr) == 0x4C && offsetof(Adc, ofr) == 0x60);
static_assert(offsetof(Adc, jdr) == 0x80 && offsetof(Adc, awd2cr) == 0xA0 && offsetof(Adc, calfact) == 0xB4);
/// Converter 1 .. 5.
inline Adc& adc(unsigned number) {
  constexpr std::uint32_t base[] = {0x5000'0000, 0x5000'0100, 0x5000'0400, 0x5000'0500, 0x5000'0600};
  return at<Adc>(base[number - 1]);
}

struct AdcCommon {
  Register csr, reserved_4, ccr, cdr;
  static constexpr std::uint32_t ccr_hclk_4 = 3U << 16;
};
static_assert(offsetof(AdcCommon, ccr) == 0x08);
inline AdcCommon& adc12_common() {
  return at<AdcCommon>(0x5000'0300);
}
inline AdcCommon& adc345_common() {
  return at<AdcCommon>(0x5000'0700);
}

struct Comp {
  Register csr;
  static constexpr std::uint32_t csr_enable = bit(0), csr_minus_dac3 = 4U << 4, csr_plus_second = bit(8),
                                 csr_inverted = bit(15), csr_hysteresis_20mv = 2U << 16, csr_value = bit(30),
                                 csr_lock = bit(31);
};
inline Comp& comp1() {
  return at<Comp>(0x4001'0200);
}
inline Comp& comp4() {
  return at<Comp>(0x4001'020C);
}

struct Dac {
  Register cr, swtrigr, dhr12r1, dhr12l1, dhr8r1, dhr12r2, dhr12l2, dhr8r2, dhr12rd, dhr12ld, dhr8rd, dor1,
      dor2, sr, ccr, mcr;
  static constexpr std::uint32_t cr_enable_1 = bit(0), cr_enable_2 = bit(16);
  /// Both channels unbuffered and inside the chip only; interface timing for a bus above 160 MHz.
  static constexpr std::uint32_t mcr_internal = 3U | 3U << 16 | 2U << 14;
};
static_assert(offsetof(Dac, dhr12r2) == 0x14 && offsetof(Dac, dor1) == 0x2C && offsetof(Dac, mcr) == 0x3C);
inline Dac& dac3() {
  return at<Dac>(0x5000'1000);
}

}  // namespace powbench::firmware::stm32g474
