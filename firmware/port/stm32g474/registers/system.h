#pragma once

#include "firmware/port/stm32g474/registers/register.h"

/// Clocks, power, flash, resets, watchdog, debug. Bit names follow the reference manual.

namespace powbench::firmware::stm32g474 {

struct Rcc {
  Register cr, icscr, cfgr, pllcfgr, reserved_10[2], cier, cifr, cicr, reserved_24;
  Register ahb1rstr, ahb2rstr, ahb3rstr, reserved_34, apb1rstr1, apb1rstr2, apb2rstr, reserved_44;
  Register ahb1enr, ahb2enr, ahb3enr, reserved_54, apb1enr1, apb1enr2, apb2enr, reserved_64;
  Register ahb1smenr, ahb2smenr, ahb3smenr, reserved_74, apb1smenr1, apb1smenr2, apb2smenr, reserved_84;
  Register ccipr, reserved_8c, bdcr, csr, crrcr, ccipr2;

  static constexpr std::uint32_t cr_hsion = bit(8), cr_hsirdy = bit(10), cr_hseon = bit(16),
                                 cr_hserdy = bit(17), cr_csson = bit(19), cr_pllon = bit(24),
                                 cr_pllrdy = bit(25);
  static constexpr std::uint32_t cfgr_sw = 3U, cfgr_sw_pll = 3U, cfgr_sws_pll = 3U << 2, cfgr_hpre = 15U << 4,
                                 cfgr_hpre_2 = 8U << 4, cfgr_ppre = 63U << 8;
  static constexpr std::uint32_t pllcfgr_src_hsi = 2U, pllcfgr_src_hse = 3U, pllcfgr_ren = bit(24);
  static constexpr std::uint32_t ahb1enr_dma1 = bit(0), ahb1enr_dmamux1 = bit(2);
  static constexpr std::uint32_t ahb2enr_gpioa = bit(0), ahb2enr_gpiob = bit(1), ahb2enr_gpioc = bit(2),
                                 ahb2enr_adc12 = bit(13), ahb2enr_adc345 = bit(14), ahb2enr_dac3 = bit(18);
  static constexpr std::uint32_t apb1enr1_tim2 = bit(0), apb1enr1_tim3 = bit(1), apb1enr1_usart2 = bit(17),
                                 apb1enr1_pwr = bit(28);
  static constexpr std::uint32_t apb2enr_syscfg = bit(0), apb2enr_tim1 = bit(11);
  static constexpr std::uint32_t cicr_cssc = bit(8);
  static constexpr std::uint32_t csr_rmvf = bit(23), csr_obl = bit(25), csr_pin = bit(26), csr_bor = bit(27),
                                 csr_software = bit(28), csr_iwdg = bit(29), csr_wwdg = bit(30),
                                 csr_low_power = bit(31);
};
static_assert(offsetof(Rcc, pllcfgr) == 0x0C && offsetof(Rcc, cicr) == 0x20 &&
              offsetof(Rcc, ahb1rstr) == 0x28);
static_assert(offsetof(Rcc, ahb1enr) == 0x48 && offsetof(Rcc, ahb2enr) == 0x4C &&
              offsetof(Rcc, apb1enr1) == 0x58);
static_assert(offsetof(Rcc, apb2enr) == 0x60 && offsetof(Rcc, ahb1smenr) == 0x68 &&
              offsetof(Rcc, ccipr) == 0x88);
static_assert(offsetof(Rcc, csr) == 0x94 && sizeof(Rcc) == 0xA0);
inline Rcc& rcc() {
  return at<Rcc>(0x4002'1000);
}

struct Flash {
  Register acr, pdkeyr, keyr, optkeyr, sr, cr, eccr, reserved_1c, optr;
  static constexpr std::uint32_t acr_latency = 15U, acr_prefetch = bit(8), acr_icache = bit(9),
                                 acr_dcache = bit(10), acr_dcache_reset = bit(12);
  static constexpr std::uint32_t key_1 = 0x4567'0123U, key_2 = 0xCDEF'89ABU;
  static constexpr std::uint32_t cr_program = bit(0), cr_page_erase = bit(1), cr_bank_2 = bit(11),
                                 cr_start = bit(16), cr_lock = bit(31);
  static constexpr unsigned cr_page_shift = 3;
  static constexpr std::uint32_t sr_end = bit(0), sr_errors = bit(1) | 31U << 3 | 3U << 8 | 3U << 14,
                                 sr_busy = bit(16);
  /// Option bytes as loaded: brown-out level 0 .. 4 in three bits; two banks; RAM parity check, 0 = on.
  static constexpr std::uint32_t optr_bor = 7U << 8, optr_bor_level_4 = 4U << 8, optr_dual_bank = bit(22),
                                 optr_no_parity = bit(24);
};
static_assert(offsetof(Flash, keyr) == 0x08 && offsetof(Flash, cr) == 0x14 && offsetof(Flash, optr) == 0x20);
inline Flash& flash() {
  return at<Flash>(0x4002'2000);
}

struct Pwr {
  Register cr1, cr2, cr3, cr4, sr1, sr2, scr, reserved_1c, pull[14], reserved_58[10], cr5;
  static constexpr std::uint32_t cr1_vos = 3U << 9, cr1_vos_range_1 = 1U << 9;
  static constexpr std::uint32_t cr2_pvde = bit(0), cr2_pls = 7U << 1, cr2_pls_2v9 = 6U << 1;
  static constexpr std::uint32_t sr2_vosf = bit(10), sr2_pvdo = bit(11);
  static constexpr std::uint32_t cr5_r1mode = bit(8);  ///< 0 = boost, needed above 150 MHz
};
static_assert(offsetof(Pwr, sr2) == 0x14 && offsetof(Pwr, pull) == 0x20 && offsetof(Pwr, cr5) == 0x80);
inline Pwr& pwr() {
  return at<Pwr>(0x4000'7000);
}

struct Syscfg {
  Register memrmp, cfgr1, exticr[4], scsr, cfgr2, swpr, skr;
  /// What else trips the break input of the advanced timers: core lock-up, RAM parity, voltage detector, flash ECC.
  static constexpr std::uint32_t cfgr2_lockup = bit(0), cfgr2_parity = bit(1), cfgr2_pvd = bit(2),
                                 cfgr2_ecc = bit(3);
  /// Line 10 follows port C.
  static constexpr std::uint32_t exticr3_line_10 = 15U << 8, exticr3_line_10_port_c = 2U << 8;
};
static_assert(offsetof(Syscfg, exticr) == 0x08 && offsetof(Syscfg, cfgr2) == 0x1C && sizeof(Syscfg) == 0x28);
inline Syscfg& syscfg() {
  return at<Syscfg>(0x4001'0000);
}

struct Exti {
  Register imr1, emr1, rtsr1, ftsr1, swier1, pr1;
  static constexpr std::uint32_t line_stop = bit(10), line_pvd = bit(16);
};
static_assert(offsetof(Exti, rtsr1) == 0x08 && offsetof(Exti, pr1) == 0x14);
inline Exti& exti() {
  return at<Exti>(0x4001'0400);
}

struct Iwdg {
  Register kr, pr, rlr, sr, winr;
  static constexpr std::uint32_t key_start = 0xCCCC, key_unlock = 0x5555, key_reload = 0xAAAA;
  static constexpr std::uint32_t sr_busy = 7U;
};
static_assert(offsetof(Iwdg, winr) == 0x10);
inline Iwdg& iwdg() {
  return at<Iwdg>(0x4000'3000);
}

struct Dbgmcu {
  Register idcode, cr, apb1fzr1, apb1fzr2, apb2fz;
  static constexpr std::uint32_t apb1fzr1_tim3 = bit(1), apb1fzr1_iwdg = bit(12), apb2fz_tim1 = bit(11);
};
static_assert(offsetof(Dbgmcu, apb2fz) == 0x10);
inline Dbgmcu& dbgmcu() {
  return at<Dbgmcu>(0xE004'2000);
}

}  // namespace powbench::firmware::stm32g474
