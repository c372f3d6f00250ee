#!/usr/bin/env python3
"""Compares registers/ with the manufacturer's device header: compare_header.py HEADER. Ends with `N passed, N failed`.

HEADER is stm32g474xx.h, which is not part of powbench. Base addresses, the offset of every register that both name, bits and
codes by the table below, interrupt numbers. The compiler for the board does the comparing; the header's own includes are
replaced by nothing but the keywords it needs.
"""

import re
import subprocess
import sys
import tempfile
from pathlib import Path

HERE = Path(__file__).resolve().parent
ROOT = HERE.parents[2]

# our structure: (the header's, what stands in front of its bits)
TYPES = {"Rcc": "RCC", "Flash": "FLASH", "Pwr": "PWR", "Syscfg": "SYSCFG", "Exti": "EXTI", "Iwdg": "IWDG", "Dbgmcu": "DBGMCU",
         "Timer": "TIM", "Adc": "ADC", "AdcCommon": "ADC_Common", "Comp": "COMP", "Dac": "DAC", "Gpio": "GPIO",
         "DmaChannel": "DMA_Channel", "Dma": "DMA", "Usart": "USART"}
# our member: the header's, where the name differs or an array begins
MEMBERS = {"exticr": "EXTICR", "ccr1": "CCR1", "Timer.ccr": "CCR1", "Adc.tr": "TR1", "Adc.sqr": "SQR1", "Adc.ofr": "OFR1", "Adc.jdr": "JDR1",
           "Pwr.pull": "PUCRA", "Dac.swtrigr": "SWTRIGR", "Syscfg.scsr": "SCSR"}
BASES = {"flash": "FLASH_R_BASE", "dmamux": "DMAMUX1_BASE"}

# ours = the header's
BITS = """
Rcc::cr_hsion = RCC_CR_HSION; Rcc::cr_hsirdy = RCC_CR_HSIRDY; Rcc::cr_hseon = RCC_CR_HSEON; Rcc::cr_hserdy = RCC_CR_HSERDY
Rcc::cr_csson = RCC_CR_CSSON; Rcc::cr_pllon = RCC_CR_PLLON; Rcc::cr_pllrdy = RCC_CR_PLLRDY
Rcc::cfgr_sw = RCC_CFGR_SW; Rcc::cfgr_sw_pll = RCC_CFGR_SW_PLL; Rcc::cfgr_sws_pll = RCC_CFGR_SWS_PLL
Rcc::cfgr_hpre = RCC_CFGR_HPRE; Rcc::cfgr_hpre_2 = RCC_CFGR_HPRE_DIV2; Rcc::cfgr_ppre = (RCC_CFGR_PPRE1 | RCC_CFGR_PPRE2)
Rcc::pllcfgr_src_hsi = RCC_PLLCFGR_PLLSRC_HSI; Rcc::pllcfgr_src_hse = RCC_PLLCFGR_PLLSRC_HSE; Rcc::pllcfgr_ren = RCC_PLLCFGR_PLLREN
Rcc::ahb1enr_dma1 = RCC_AHB1ENR_DMA1EN; Rcc::ahb1enr_dmamux1 = RCC_AHB1ENR_DMAMUX1EN
Rcc::ahb2enr_gpioa = RCC_AHB2ENR_GPIOAEN; Rcc::ahb2enr_gpiob = RCC_AHB2ENR_GPIOBEN; Rcc::ahb2enr_gpioc = RCC_AHB2ENR_GPIOCEN
Rcc::ahb2enr_adc12 = RCC_AHB2ENR_ADC12EN; Rcc::ahb2enr_adc345 = RCC_AHB2ENR_ADC345EN; Rcc::ahb2enr_dac3 = RCC_AHB2ENR_DAC3EN
Rcc::apb1enr1_tim2 = RCC_APB1ENR1_TIM2EN; Rcc::apb1enr1_tim3 = RCC_APB1ENR1_TIM3EN; Rcc::apb1enr1_usart2 = RCC_APB1ENR1_USART2EN
Rcc::apb1enr1_pwr = RCC_APB1ENR1_PWREN; Rcc::apb2enr_syscfg = RCC_APB2ENR_SYSCFGEN; Rcc::apb2enr_tim1 = RCC_APB2ENR_TIM1EN
Rcc::cicr_cssc = RCC_CICR_CSSC; Rcc::csr_rmvf = RCC_CSR_RMVF; Rcc::csr_obl = RCC_CSR_OBLRSTF; Rcc::csr_pin = RCC_CSR_PINRSTF
Rcc::csr_bor = RCC_CSR_BORRSTF; Rcc::csr_software = RCC_CSR_SFTRSTF; Rcc::csr_iwdg = RCC_CSR_IWDGRSTF
Rcc::csr_wwdg = RCC_CSR_WWDGRSTF; Rcc::csr_low_power = RCC_CSR_LPWRRSTF
Flash::acr_latency = FLASH_ACR_LATENCY; Flash::acr_prefetch = FLASH_ACR_PRFTEN; Flash::acr_icache = FLASH_ACR_ICEN
Flash::acr_dcache = FLASH_ACR_DCEN; Flash::acr_dcache_reset = FLASH_ACR_DCRST; Flash::cr_program = FLASH_CR_PG
Flash::cr_page_erase = FLASH_CR_PER; Flash::cr_bank_2 = FLASH_CR_BKER; Flash::cr_start = FLASH_CR_STRT; Flash::cr_lock = FLASH_CR_LOCK
Flash::cr_page_shift = FLASH_CR_PNB_Pos; Flash::sr_end = FLASH_SR_EOP; Flash::sr_busy = FLASH_SR_BSY
Flash::sr_errors = (FLASH_SR_OPERR | FLASH_SR_PROGERR | FLASH_SR_WRPERR | FLASH_SR_PGAERR | FLASH_SR_SIZERR | FLASH_SR_PGSERR | FLASH_SR_MISERR | FLASH_SR_FASTERR | FLASH_SR_RDERR | FLASH_SR_OPTVERR)
Flash::optr_bor = FLASH_OPTR_BOR_LEV; Flash::optr_bor_level_4 = FLASH_OPTR_BOR_LEV_4; Flash::optr_dual_bank = FLASH_OPTR_DBANK
Flash::optr_no_parity = FLASH_OPTR_SRAM_PE
Pwr::cr1_vos = PWR_CR1_VOS; Pwr::cr1_vos_range_1 = PWR_CR1_VOS_0; Pwr::cr2_pvde = PWR_CR2_PVDE; Pwr::cr2_pls = PWR_CR2_PLS
Pwr::cr2_pls_2v9 = PWR_CR2_PLS_LEV6; Pwr::sr2_vosf = PWR_SR2_VOSF; Pwr::sr2_pvdo = PWR_SR2_PVDO; Pwr::cr5_r1mode = PWR_CR5_R1MODE
Syscfg::cfgr2_lockup = SYSCFG_CFGR2_CLL; Syscfg::cfgr2_parity = SYSCFG_CFGR2_SPL; Syscfg::cfgr2_pvd = SYSCFG_CFGR2_PVDL
Syscfg::cfgr2_ecc = SYSCFG_CFGR2_ECCL; Syscfg::exticr3_line_10_port_c = SYSCFG_EXTICR3_EXTI10_PC
Exti::line_stop = EXTI_IMR1_IM10; Exti::line_pvd = EXTI_IMR1_IM16; Iwdg::sr_busy = (IWDG_SR_PVU | IWDG_SR_RVU | IWDG_SR_WVU)
Dbgmcu::apb1fzr1_tim3 = DBGMCU_APB1FZR1_DBG_TIM3_STOP; Dbgmcu::apb1fzr1_iwdg = DBGMCU_APB1FZR1_DBG_IWDG_STOP
Dbgmcu::apb2fz_tim1 = DBGMCU_APB2FZ_DBG_TIM1_STOP
Timer::cr1_enable = TIM_CR1_CEN; Timer::cr1_only_overflow = TIM_CR1_URS; Timer::cr2_trgo_enable = TIM_CR2_MMS_0
Timer::cr2_trgo_update = TIM_CR2_MMS_1; Timer::smcr_start_on_itr0 = (TIM_SMCR_SMS_2 | TIM_SMCR_SMS_1); Timer::sr_break = TIM_SR_BIF
Timer::sr_break2 = TIM_SR_B2IF; Timer::sr_system_break = TIM_SR_SBIF; Timer::dier_ch1_dma = TIM_DIER_CC1DE
Timer::oc3_mode = TIM_CCMR2_OC3M; Timer::oc3_on_at_match = TIM_CCMR2_OC3M_0; Timer::oc3_off_at_match = TIM_CCMR2_OC3M_1
Timer::oc3_forced_off = TIM_CCMR2_OC3M_2; Timer::ccer_ch3 = TIM_CCER_CC3E; Timer::bdtr_lock_2 = TIM_BDTR_LOCK_1
Timer::bdtr_idle_driven = TIM_BDTR_OSSI; Timer::bdtr_run_driven = TIM_BDTR_OSSR; Timer::bdtr_break = TIM_BDTR_BKE
Timer::bdtr_break_high = TIM_BDTR_BKP; Timer::bdtr_output = TIM_BDTR_MOE; Timer::af1_comp1 = TIM1_AF1_BKCMP1E; Timer::af1_comp4 = TIM1_AF1_BKCMP4E
Adc::isr_ready = ADC_ISR_ADRDY; Adc::isr_overrun = ADC_ISR_OVR; Adc::cr_enable = ADC_CR_ADEN; Adc::cr_start = ADC_CR_ADSTART
Adc::cr_regulator = ADC_CR_ADVREGEN; Adc::cr_deep_sleep = ADC_CR_DEEPPWD; Adc::cr_calibrate = ADC_CR_ADCAL; Adc::cfgr_dma = ADC_CFGR_DMAEN
Adc::cfgr_dma_circular = ADC_CFGR_DMACFG; Adc::cfgr_rising = ADC_CFGR_EXTEN_0; Adc::cfgr_overwrite = ADC_CFGR_OVRMOD
Adc::cfgr_tim3_trgo = ADC_CFGR_EXTSEL_2; Adc::cfgr_no_queue = ADC_CFGR_JQDIS; Adc::cfgr2_oversample = ADC_CFGR2_ROVSE
Adc::cfgr2_ratio_8 = ADC_CFGR2_OVSR_1; Adc::cfgr2_ratio_16 = (ADC_CFGR2_OVSR_1 | ADC_CFGR2_OVSR_0); Adc::sample_6_5 = ADC_SMPR1_SMP0_0
AdcCommon::ccr_hclk_4 = ADC_CCR_CKMODE
Comp::csr_enable = COMP_CSR_EN; Comp::csr_minus_dac3 = COMP_CSR_INMSEL_2; Comp::csr_plus_second = COMP_CSR_INPSEL
Comp::csr_inverted = COMP_CSR_POLARITY; Comp::csr_hysteresis_20mv = COMP_CSR_HYST_1; Comp::csr_value = COMP_CSR_VALUE; Comp::csr_lock = COMP_CSR_LOCK
Dac::cr_enable_1 = DAC_CR_EN1; Dac::cr_enable_2 = DAC_CR_EN2
Dac::mcr_internal = (DAC_MCR_MODE1_0 | DAC_MCR_MODE1_1 | DAC_MCR_MODE2_0 | DAC_MCR_MODE2_1 | DAC_MCR_HFSEL_1)
DmaChannel::ccr_enable = DMA_CCR_EN; DmaChannel::ccr_full_irq = DMA_CCR_TCIE; DmaChannel::ccr_half_irq = DMA_CCR_HTIE
DmaChannel::ccr_to_peripheral = DMA_CCR_DIR; DmaChannel::ccr_circular = DMA_CCR_CIRC; DmaChannel::ccr_memory_step = DMA_CCR_MINC
DmaChannel::ccr_from_16 = DMA_CCR_PSIZE_0; DmaChannel::ccr_to_16 = DMA_CCR_MSIZE_0; DmaChannel::ccr_from_32 = DMA_CCR_PSIZE_1
DmaChannel::ccr_to_32 = DMA_CCR_MSIZE_1; DmaChannel::ccr_priority_high = DMA_CCR_PL_1; DmaChannel::ccr_priority_highest = DMA_CCR_PL
Dma::full(5) = DMA_ISR_TCIF5; Dma::half(5) = DMA_ISR_HTIF5; Dma::all(8) = (DMA_ISR_GIF8 | DMA_ISR_TCIF8 | DMA_ISR_HTIF8 | DMA_ISR_TEIF8)
Usart::cr1_enable = USART_CR1_UE; Usart::cr1_receive = USART_CR1_RE; Usart::cr1_transmit = USART_CR1_TE; Usart::cr1_idle = USART_CR1_IDLEIE
Usart::cr1_fifo = USART_CR1_FIFOEN; Usart::cr3_receive_dma = USART_CR3_DMAR; Usart::cr3_transmit_dma = USART_CR3_DMAT
Usart::isr_line_errors = (USART_ISR_PE | USART_ISR_FE | USART_ISR_NE | USART_ISR_ORE); Usart::isr_idle = USART_ISR_IDLE
Usart::isr_line_errors = (USART_ICR_PECF | USART_ICR_FECF | USART_ICR_NECF | USART_ICR_ORECF); Usart::isr_idle = USART_ICR_IDLECF
Usart::isr_room = USART_ISR_TXE
irq_pvd = PVD_PVM_IRQn; irq_dma1_channel5 = DMA1_Channel5_IRQn; irq_usart2 = USART2_IRQn; irq_exti_10_to_15 = EXTI15_10_IRQn
irq_background = RNG_IRQn
"""


def claims(header):
    """(ours, the header's) as C++ expressions, and our constants that no claim names."""
    found, named = [], set()
    for ours, theirs in re.findall(r"([\w:()]+) = ([^;\n]+)", BITS):
        found.append((ours, theirs.strip()))
        named.add(ours)
    left = []
    for file in sorted((HERE / "registers").glob("*.h")):
        text = re.sub(r"//[^\n]*", "", file.read_text())
        for name, body in re.findall(r"\nstruct (\w+) \{(.*?)\n\};", text, re.S):
            if name not in TYPES:
                continue
            theirs = re.search(r"\{([^{}]*)\}\s*" + TYPES[name] + "_TypeDef;", header)
            members = set(re.findall(r"\b([A-Z]\w*)\s*(?:\[\d+\])?\s*;", theirs[1])) if theirs else set()
            for group in re.findall(r"\bRegister ([^;]+);", body):
                for member in re.findall(r"(\w+)(?:\[\d+\])?", group):
                    vendor = MEMBERS.get(f"{name}.{member}", member.upper())
                    if vendor in members:
                        found.append((f"offsetof({name}, {member})", f"offsetof({TYPES[name]}_TypeDef, {vendor})"))
            for constant in re.findall(r"\b([a-z]\w*) = ", body):
                if f"{name}::{constant}" not in named:
                    left.append(f"{name}::{constant}")
        for _, function, address in re.findall(r"inline (\w+)& (\w+)\(\) \{\s*return at<\w+>\((\w[\w']*)\);", text):
            vendor = BASES.get(function, function.upper() + "_BASE")
            if re.search(rf"#define {vendor}\b", header):
                found.append((address, vendor))
    return found, left


def main(path):
    header = Path(path).read_text(encoding="latin-1")
    found, left = claims(header)
    with tempfile.TemporaryDirectory() as folder:
        out = Path(folder)
        (out / "core_cm4.h").write_text("#pragma once\n#include <stdint.h>\n#define __IO volatile\n#define __I volatile const\n#define __O volatile\n")
        (out / "system_stm32g4xx.h").write_text("#pragma once\n")
        (out / "vendor.h").write_text(header)
        lines = [f'#include "firmware/port/stm32g474/registers/{f.name}"' for f in sorted((HERE / "registers").glob("*.h"))]
        lines += ['#include "vendor.h"', "using namespace powbench::firmware::stm32g474;", "typedef unsigned long long Wide;"]
        lines += [f'static_assert(Wide({ours}) == Wide({theirs}), "claim {i}");' for i, (ours, theirs) in enumerate(found)]
        (out / "compare.cpp").write_text("\n".join(lines) + "\n")
        done = subprocess.run(["arm-none-eabi-g++", "-std=c++20", "-mcpu=cortex-m4", "-fsyntax-only", "-w", f"-I{ROOT}", f"-I{out}",
                               str(out / "compare.cpp")], capture_output=True, text=True)
    wrong = {int(n) for n in re.findall(r"claim (\d+)", done.stderr)}
    for i in sorted(wrong):
        print(f"FAILED  {found[i][0]} is not {found[i][1]}")
    if done.returncode and not wrong:
        print(done.stderr)
        wrong = set(range(len(found)))
    print(f"not compared: {', '.join(left) or 'none'}")
    print(f"{len(found) - len(wrong)} passed, {len(wrong)} failed")
    return int(bool(wrong))


if __name__ == "__main__":
    if len(sys.argv) != 2:
        sys.exit(__doc__)
    sys.exit(main(sys.argv[1]))
