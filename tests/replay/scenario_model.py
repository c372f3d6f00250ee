"""The referee itself: what the vendor forbids has to be noticed, or a clean run proves nothing."""

from bench import Bench, booted
from cpu import HERTZ

RCC, FLASH, PWR, SYSCFG, TIM1, DMA1, ADC1, COMP, USART2 = (
    0x4002_1000, 0x4002_2000, 0x4000_7000, 0x4001_0000, 0x4001_2C00, 0x4002_0000, 0x5000_0000, 0x4001_0200, 0x4000_4400)


def run(image, report):
    b = booted(image)
    chip = b.chip

    def forbidden(name, *writes):
        before = len(chip.wrong)
        for address, value in writes:
            chip.write(address, 4, value)
        report.verdict(f"model: {name} is noticed", chip.wrong[before:][-1:] or "nothing", len(chip.wrong) > before)

    chip.rcc.r[0x58] &= ~(1 << 17)
    forbidden("a peripheral without its clock", (USART2, 0))
    report.verdict("model: and reads 0", chip.read(USART2, 4), chip.read(USART2, 4) == 0)
    chip.rcc.r[0x58] |= 1 << 17
    forbidden("the supply monitor behind its lock", (PWR + 4, 0))
    report.verdict("model: and it stays on", chip.pwr.r[4], chip.pwr.r[4] & 1)
    forbidden("the break's selection behind its lock", (TIM1 + 0x60, 0))
    forbidden("another break setting behind its lock", (TIM1 + 0x44, 1 << 12))
    report.verdict("model: and the break stays", hex(chip.tim1.r[0x44]), chip.tim1.r[0x44] >> 12 & 1)
    forbidden("a converter configured while it converts", (ADC1 + 0x0C, 0))
    forbidden("a DMA channel set up while it is enabled", (DMA1 + 8 + 4, 100))
    forbidden("a comparator behind its lock", (COMP, 0))
    forbidden("the flash's control register while it is locked", (FLASH + 0x14, 1))
    chip.write(SYSCFG + 0x1C, 4, 0)
    report.verdict("model: break inputs cannot be unlocked", hex(chip.syscfg.r[0x1C]), chip.syscfg.r[0x1C] & 15 == 15)
    # a trigger by software reaches the converters
    bursts = chip.rules["adc_trigger"]
    chip.tim3.r[4] = 0
    chip.write(0x4000_0414, 4, 1)
    report.verdict("model: UG with MMS = 000 triggers", chip.rules["adc_trigger"] - bursts,
                   chip.rules["adc_trigger"] - bursts == 5)
    # a processor that reads what nothing has written, with the parity check on
    b = Bench(image)
    b.cpu.track_parity()
    b.cpu.parity_read(0x2000_0100, 4)
    report.verdict("model: reading unwritten RAM is a parity error", hex(b.chip.syscfg.r.get(0x1C, 0)),
                   b.chip.syscfg.r.get(0x1C, 0) >> 8 & 1)
    report.rules.update(b.chip.rules + chip.rules)


def parity(image, report):
    """Start after power-on with the parity check: nothing is read that has not been written."""
    b = Bench(image)
    b.cpu.track_parity()
    b.world.wait(25)
    report.verdict("boot: no parity error after power-on", b.cpu.unwritten or "none", not b.cpu.unwritten)
    report.verdict("boot: parity check watched", f"{b.cpu.parity_reads} reads", b.cpu.parity_reads > 10_000)
    report.verdict("boot: starts once", b.chip.resets, not b.chip.resets)
