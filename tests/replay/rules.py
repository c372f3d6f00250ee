"""The vendor's rules that the replay knows, each with its source, and what it does not know.

A rule that the image meets in a run is counted: one that is never met proves nothing, and the run says so.
Sources: RM0440 = reference manual of the STM32G4 (chapter, register); HAL = the vendor's stm32g4xx-hal-driver; HDR = the
vendor's device header stm32g474xx.h; SVD = the vendor's register description STM32G474.svd; ARM = ARMv7-M architecture
manual; DS = data sheet DS12288.
"""

RULES = {
    # --- clocks and resets ---
    "clock_gate": ("a peripheral without its clock reads 0 and takes no write", "RM0440 RCC, xxxENR registers"),
    "reset_flags": ("RCC_CSR keeps every reset cause until RMVF; power-on and brown-out share BORRSTF; the pin flag is set "
                    "by every internal reset too", "RM0440 RCC, RCC_CSR"),
    "crystal_start": ("HSERDY comes when the crystal runs; without one it never comes", "RM0440 RCC, RCC_CR"),
    "pll_source": ("PLLRDY needs a running source; SW = PLL takes effect only with PLLRDY", "RM0440 RCC, RCC_PLLCFGR, RCC_CFGR"),
    "flash_latency": ("170 MHz needs four wait states and range 1 with boost", "RM0440 FLASH, table of wait states; PWR_CR5"),
    "watchdog": ("starts with 0xCCCC, never stops, resets after (RLR + 1) prescaled LSI periods", "RM0440 IWDG"),
    "watchdog_key": ("IWDG_PR and IWDG_RLR take a value only after 0x5555", "RM0440 IWDG, IWDG_KR"),
    # --- supply ---
    "pvd_output": ("PVDO is 1 while PVDE is set and VDD is below the level of PLS", "RM0440 PWR, PWR_CR2, PWR_SR2"),
    "pvd_lock": ("PVDE and PLS are write-protected from SYSCFG_CFGR2.PVDL = 1 until reset",
                 "RM0440 SYSCFG_CFGR2; HAL stm32g4xx_hal.h, __HAL_SYSCFG_BREAK_PVD_LOCK"),
    "cfgr2_set_only": ("CLL, SPL, PVDL, ECCL can be set by software and cleared by a reset only", "RM0440 SYSCFG_CFGR2"),
    "exti_pvd": ("line 16 rises with PVDO; pending bit and interrupt need RTSR and IMR", "RM0440 EXTI"),
    "exti_pin": ("line n follows the pin that SYSCFG_EXTICR selects", "RM0440 SYSCFG_EXTICR, EXTI"),
    "flash_keys": ("FLASH_CR takes writes only after both keys in FLASH_KEYR, and none while BSY is set", "RM0440 FLASH_KEYR, FLASH_CR"),
    "flash_program": ("a page is erased with PER, PNB, BKER and STRT; with PG two aligned words make a double word, which must "
                      "have been erased", "RM0440 FLASH, erase and programming sequences"),
    "flash_busy": ("BSY for 22 ms a page, 85 us a double word; with two banks the code in the other one runs on", "DS t_ERASE, t_prog; RM0440 FLASH, read while write"),
    "flash_ecc": ("reading a double word whose programming lost its supply raises NMI and, with ECCL, the break",
                  "RM0440 FLASH_ECCR, SYSCFG_CFGR2"),
    "option_bytes": ("FLASH_OPTR shows the loaded option bytes: BOR_LEV 0 .. 4, SRAM_PE = 0 switches the parity check on",
                     "RM0440 FLASH_OPTR; HAL stm32g4xx_hal_flash.h"),
    "sram_parity": ("with the check on, reading a byte of SRAM1's first 32 kB or of CCM SRAM that nothing has written since "
                    "power-on raises NMI and, with SPL, the break", "RM0440 SYSCFG, SRAM parity; HAL OB_SRAM_PARITY_*"),
    # --- timers ---
    "timer_count": ("an enabled counter advances each clock of (PSC + 1) and wraps at ARR", "RM0440 TIM, CR1, CNT"),
    "trgo_ug": ("with MMS = 000 the UG bit is the trigger output; with 010 every update event is, UG's too",
                "RM0440 TIMx_CR2; SVD TIM3.CR2.MMS"),
    "trgo_enable": ("with MMS = 001 the counter's enable is the trigger output", "RM0440 TIMx_CR2"),
    "slave_start": ("SMS = 110: a rising trigger sets CEN; TS = 0 of TIM3 is TIM1", "RM0440 TIMx_SMCR, table of internal triggers"),
    "compare_mode": ("OC3M: frozen, on at match, off at match, forced off", "RM0440 TIM1_CCMR2"),
    "moe": ("the output follows OC3REF only with MOE, CC3E and the pin's alternate function 6", "RM0440 TIM1_BDTR; DS alternate functions"),
    "moe_break": ("an active break input clears MOE without the processor, and MOE cannot be set while it lasts",
                  "RM0440 TIM1, break function"),
    "bdtr_lock": ("LOCK is written once; level 2 freezes break, idle and run settings, not MOE", "RM0440 TIM1_BDTR"),
    "af1_lock": ("TIM1_AF1 is frozen with LOCK level 1 and above", "RM0440 TIM1_AF1"),
    "break_flags": ("BIF and SBIF are cleared by writing 0 and come back while the cause lasts", "RM0440 TIM1_SR"),
    "system_break": ("clock failure always, PVD, parity and lock-up with their CFGR2 bit, reach the break input",
                     "RM0440 TIM1, break function; SYSCFG_CFGR2"),
    "compare_dma": ("a match of TIM2 channel 1 raises request 56 while CC1DE is set", "RM0440 TIM2_DIER; DMAMUX table"),
    # --- analog ---
    "adc_regulator": ("deep power-down off, regulator on for 20 us, then ADCAL", "RM0440 ADC; DS t_ADCVREG_STUP"),
    "adc_enable": ("ADEN not within four ADC clocks after ADCAL; ADRDY follows", "RM0440 ADC, calibration"),
    "adc_locked": ("CFGR, CFGR2, SQR and SMPR take no write while ADSTART is set", "RM0440 ADC_CR"),
    "adc_trigger": ("EXTSEL 4 of a regular sequence is TIM3_TRGO; a trigger during a conversion is lost", "RM0440 ADC, table of triggers"),
    "adc_burst": ("oversampling with TROVS = 0: one trigger takes all samples of all ranks", "RM0440 ADC, oversampler"),
    "adc_overrun": ("a result that nobody fetched sets OVR", "RM0440 ADC_ISR"),
    "comparator": ("COMP1 compares PB1 with DAC3 channel 1, COMP4 PB0 with DAC3 channel 2; LOCK freezes the register",
                   "RM0440 COMP, tables of inputs; COMP_CxCSR"),
    # --- data ---
    "dma_transfer": ("one request moves one item; half and full flags; circular mode reloads", "RM0440 DMA"),
    "dma_locked": ("CNDTR, CPAR, CMAR take no write while EN is set", "RM0440 DMA_CCR"),
    "dmamux": ("a channel serves the request in DMAREQ_ID: 5, 36 .. 39 the converters, 26 and 27 USART2, 56 TIM2",
               "RM0440 DMAMUX, table of requests"),
    "usart_idle": ("IDLE is set one frame after the last byte, requests interrupt 38 with IDLEIE, is cleared by ICR", "RM0440 USART"),
    "usart_frame": ("a byte takes ten bit times of BRR; FIFO of eight; a byte that finds it full sets ORE", "RM0440 USART"),
    # --- core ---
    "exception_frame": ("entry stacks 8 words, and 18 more of the floating-point unit, on an 8-byte boundary", "ARM B1.5"),
    "priority": ("a lower number interrupts a higher one; BASEPRI keeps out its own and higher numbers", "ARM B1.5, B3.4"),
    "system_reset": ("AIRCR.SYSRESETREQ with its key resets all but the debug part; RAM keeps its content", "ARM B3.2"),
}

NOT_MODELLED = (
    "cycle times: an instruction counts 1.5 clocks, none waits for flash, bus or another master",
    "interrupts come between two basic blocks of code, not between two instructions",
    "analogue behaviour: noise, settling, source impedance, offset and linearity of converters and comparators",
    "bus arbitration, DMA latency and priorities between channels",
    "the two clocks a peripheral needs after its enable bit, synchronisation delays between timers",
    "line coding of the serial port beyond framing, noise and overrun flags on request",
    "memory protection unit, sleep modes, debugger",
    "single flash errors, which are corrected; a lost write is taken to leave its last double word unreadable",
    "contents of RAM after a short supply loss: kept or arbitrary, as the case asks",
)
