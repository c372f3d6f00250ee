"""Clocks, supply, flash, watchdog, pins, interrupts: the rules of rules.py that concern them."""

from cpu import HARD, HERTZ, NMI, PENDSV

# BOR level 4, parity check on, the rest as the chip is delivered
OPTR_DELIVERED = 0xFFEF_F8AA
OPTR_BENCH = (OPTR_DELIVERED & ~0x0100_0700) | 0x400
PVD_LEVELS = (2.0, 2.2, 2.4, 2.5, 2.6, 2.8, 2.9)

# clock of a peripheral: offset and bit in RCC
GATES = {"tim2": (0x58, 0), "tim3": (0x58, 1), "usart2": (0x58, 17), "pwr": (0x58, 28), "syscfg": (0x60, 0),
         "tim1": (0x60, 11), "dma1": (0x48, 0), "dmamux": (0x48, 2), "gpioa": (0x4C, 0), "gpiob": (0x4C, 1),
         "gpioc": (0x4C, 2), "adc12": (0x4C, 13), "adc345": (0x4C, 14), "dac3": (0x4C, 18)}


class Plain:
    """Registers that keep what is written."""

    def __init__(self, chip, name, reset=()):
        self.chip, self.name, self.r = chip, name, dict(reset)

    def read(self, offset):
        return self.r.get(offset, 0)

    def write(self, offset, value):
        self.r[offset] = value


class Rcc(Plain):
    def __init__(self, chip, cause):
        super().__init__(chip, "rcc", {0x00: 0x0000_0500, 0x0C: 0x1000, 0x48: 0x100, 0x08: 1})
        chip.flags |= {"pin": 1 << 26, "bor": 1 << 27 | 1 << 26, "software": 1 << 28 | 1 << 26,
                       "watchdog": 1 << 29 | 1 << 26}[cause]
        self.nmi_flag = False

    def read(self, offset):
        if offset == 0x94:
            self.chip.met("reset_flags")
            return self.chip.flags
        if offset == 0x18 + 4:  # CIFR
            return int(self.nmi_flag) << 8
        return self.r.get(offset, 0)

    def write(self, offset, value):
        chip = self.chip
        if offset == 0x00:
            old = self.r[0]
            value = value & ~(1 << 17 | 1 << 25) | old & (1 << 17 | 1 << 25)
            if value >> 16 & 1 and not old >> 16 & 1 and chip.crystal:
                chip.met("crystal_start")
                chip.at(chip.now + HERTZ // 500, lambda t: self._ready(17))  # a crystal takes some 2 ms
            if value >> 24 & 1 and not old >> 24 & 1:
                source = self.r.get(0x0C, 0) & 3
                chip.met("pll_source")
                if source == 3 and not old >> 17 & 1:
                    chip.wrong.append("PLL started from a crystal that is not ready")
                chip.at(chip.now + HERTZ // 20_000, lambda t: self._ready(25))
        if offset == 0x08 and value & 3 == 3 and self.r[0] >> 25 & 1:
            value |= 3 << 2
            half = value >> 4 & 15 == 8
            chip.clock_ticks_x2 = 6 if half else 3
            latency, boost = chip.flash.r.get(0, 0) & 15, not chip.pwr.r.get(0x80, 0x100) >> 8 & 1
            chip.met("flash_latency")
            if latency < 4 or not boost:
                chip.wrong.append(f"170 MHz with {latency} wait states, boost {boost}")
        if offset == 0x94:
            if value >> 23 & 1:
                chip.flags = 0
            return
        if offset == 0x20 and value >> 8 & 1:
            self.nmi_flag = False
        self.r[offset] = value

    def _ready(self, bit):
        self.r[0] |= 1 << bit

    def crystal_stops(self):
        """The clock security system: break, NMI, and the internal oscillator takes over."""
        if self.r[0] >> 19 & 1:
            self.nmi_flag = True
            self.chip.met("system_break")
            self.chip.tim1.set_break("clock", True)
            self.chip.nmi()


class Pwr(Plain):
    def __init__(self, chip):
        super().__init__(chip, "pwr", {0x00: 0x200, 0x80: 0x100})

    def low(self):
        cr2 = self.r.get(4, 0)
        return bool(cr2 & 1) and self.chip.supply < PVD_LEVELS[min(cr2 >> 1 & 7, 6)]

    def read(self, offset):
        if offset == 0x14:
            self.chip.met("pvd_output")
            return int(self.low()) << 11
        return self.r.get(offset, 0)

    def write(self, offset, value):
        if offset == 4 and self.chip.syscfg.r.get(0x1C, 0) & 4:
            old = self.r.get(4, 0)
            self.chip.met("pvd_lock")
            if (value ^ old) & 15:
                self.chip.wrong.append("PWR_CR2 written while PVDL protects PVDE and PLS")
            value = value & ~15 | old & 15
        was = self.low()
        self.r[offset] = value
        if self.low() != was:
            self.chip.exti.line(16, self.low())

    def set_supply(self, volts):
        was = self.low()
        self.chip.supply = volts
        if self.low() == was:
            return
        self.chip.exti.line(16, self.low())
        if self.chip.syscfg.r.get(0x1C, 0) & 4:
            self.chip.met("system_break")
            self.chip.tim1.set_break("pvd", self.low())


class Syscfg(Plain):
    def __init__(self, chip):
        super().__init__(chip, "syscfg")

    def write(self, offset, value):
        if offset == 0x1C:
            old = self.r.get(offset, 0)
            self.chip.met("cfgr2_set_only")
            flag = old & 0x100 & ~value  # the parity flag is cleared by writing 1
            self.r[offset] = (old | value) & 15 | (flag if value & 0x100 == 0 else 0)
            self.chip.tim1.set_break("pvd", bool(self.r[offset] & 4) and self.chip.pwr.low())
            return
        self.r[offset] = value

    def parity_error(self):
        self.chip.met("sram_parity")
        self.r[0x1C] = self.r.get(0x1C, 0) | 0x100
        if self.r[0x1C] & 2:
            self.chip.met("system_break")
            self.chip.tim1.set_break("parity", True)
        self.chip.nmi()


class Exti(Plain):
    LINES = {16: 1, 10: 40, 11: 40}

    def __init__(self, chip):
        super().__init__(chip, "exti")
        self.levels = {}

    def line(self, n, level):
        rising, was = level and not self.levels.get(n, False), self.levels.get(n, False)
        self.levels[n] = level
        edge = rising and self.r.get(0x08, 0) >> n & 1 or was and not level and self.r.get(0x0C, 0) >> n & 1
        if edge:
            self.chip.met("exti_pvd" if n == 16 else "exti_pin")
            self.r[0x14] = self.r.get(0x14, 0) | 1 << n
            if self.r.get(0, 0) >> n & 1:
                self.chip.cpu.pend(16 + self.LINES[n])

    def pin(self, port, n, level):
        selected = self.chip.syscfg.r.get(0x08 + 4 * (n // 4), 0) >> 4 * (n % 4) & 15
        if selected == "abcdefg".index(port):
            self.line(n, level)

    def write(self, offset, value):
        if offset == 0x14:
            self.r[offset] = self.r.get(offset, 0) & ~value
        else:
            self.r[offset] = value


PAGE_ERASE, DOUBLE_WORD = 22_000, 85  # us, DS: t_ERASE and t_prog


class Flash(Plain):
    """Access control, keys, pages, double words. The content is the processor's memory."""

    def __init__(self, chip):
        super().__init__(chip, "flash")
        self.words = 0
        self.erased = 0
        self.torn = set()  # double words whose check bits do not fit: a write that lost its supply

    def reset(self):
        if getattr(self, "r", {}).get(0x10, 0) >> 16 & 1:  # in the middle of it
            self.torn.add(self.at)
        self.r, self.unlock, self.first, self.at = {0x00: 0x600, 0x14: 0xC000_0000}, 0, None, None

    def page_size(self):
        return 2048 if self.chip.option_bytes >> 22 & 1 else 4096

    def busy(self, address, microseconds):
        """BSY until then; the bank of the code stands still unless the other one is at work."""
        chip, self.at = self.chip, address
        chip.met("flash_busy")
        self.r[0x10] = self.r.get(0x10, 0) | 1 << 16
        if address < 0x0804_0000 or self.page_size() != 2048:
            chip.wrong.append(f"flash written at {address:#x}, in the bank of the code: the processor stands still")
        chip.at(chip.now + microseconds * HERTZ // 1_000_000, lambda t: self._done())

    def _done(self):
        self.r[0x10] = self.r.get(0x10, 0) & ~(1 << 16) | 1

    def read(self, offset):
        if offset == 0x20:
            self.chip.met("option_bytes")
            return self.chip.option_bytes
        return self.r.get(offset, 0)

    def write(self, offset, value):
        chip = self.chip
        if offset == 0x08:
            self.unlock = self.unlock + 1 if value == (0x4567_0123, 0xCDEF_89AB)[min(self.unlock, 1)] else 99
            if self.unlock == 2:
                chip.met("flash_keys")
                self.r[0x14] &= ~(1 << 31)
            return
        if offset == 0x10:
            self.r[0x10] = self.r.get(0x10, 0) & ~(value & 0xFFFF)
            return
        if offset == 0x14:
            if self.r[0x14] >> 31 & 1:
                chip.wrong.append("FLASH_CR written while it is locked")
                return
            if self.r.get(0x10, 0) >> 16 & 1:
                chip.wrong.append("FLASH_CR written while BSY is set")
                return
            if value >> 31 & 1:
                self.unlock = 0
            if value >> 16 & 1 and value >> 1 & 1:
                page, bank = value >> 3 & 0x7F, value >> 11 & 1
                base = 0x0800_0000 + (bank * 0x4_0000 if self.page_size() == 2048 else 0) + page * self.page_size()
                if base < 0x0800_0000 + len(chip.cpu.image):
                    chip.wrong.append(f"flash page {base:#x} erased below the code that runs")
                chip.cpu.uc.mem_write(base, b"\xff" * self.page_size())
                self.torn = {a for a in self.torn if not base <= a < base + self.page_size()}
                self.erased += 1
                value &= ~(1 << 16)
                chip.met("flash_program")
                self.busy(base, PAGE_ERASE)
            if value & 0x0402_0000:
                chip.wrong.append("the image writes option bytes")
        self.r[offset] = value

    def program(self, address, size, value):
        """Before the processor writes to flash."""
        chip = self.chip
        chip.met("flash_program")
        ok = self.r[0x14] & 1 and not self.r[0x14] >> 31 and size == 4 and not self.r.get(0x10, 0) >> 16 & 1
        if ok and address % 8 == 0:
            ok = bytes(chip.cpu.uc.mem_read(address, 8)) == b"\xff" * 8
            self.first = address
        elif ok:
            ok = self.first == address - 4
            self.words += 1
            self.busy(address - 4, DOUBLE_WORD)
        if not ok:
            self.r[0x10] = self.r.get(0x10, 0) | 1 << 7
            chip.wrong.append(f"flash written at {address:#x} against its rules")

    def look(self, address):
        """The processor reads in the second bank."""
        if address & ~7 in self.torn:
            self.chip.met("flash_ecc")
            if self.chip.syscfg.r.get(0x1C, 0) & 8:
                self.chip.tim1.set_break("ecc", True)
            self.chip.nmi()


class Iwdg(Plain):
    def __init__(self, chip):
        super().__init__(chip, "iwdg", {0x08: 0xFFF})
        self.event, self.unlocked, self.lsi = None, False, 32_000
        self.running = False

    def write(self, offset, value):
        if offset == 0 and value == 0x5555:
            self.unlocked = True
        elif offset == 0:
            self.unlocked = False
            if value == 0xCCCC:
                self.running = True
            if self.running:
                self._reload()
        elif not self.unlocked:
            self.chip.wrong.append("IWDG_PR or IWDG_RLR written without its key")
        else:
            self.chip.met("watchdog_key")
            self.r[offset] = value

    def _reload(self):
        self.chip.met("watchdog")
        self.chip.cancel(self.event)
        ticks = (self.r[0x08] + 1) * (4 << self.r.get(4, 0)) * HERTZ // self.lsi
        self.event = self.chip.at(self.chip.now + ticks, lambda t: self.chip.reset("watchdog"))


class Gpio(Plain):
    def __init__(self, chip, port):
        super().__init__(chip, f"gpio{port}", {0x00: 0xABFF_FFFF if port == "a" else 0xFFFF_FFFF})
        self.port = port

    def mode(self, pin):
        return self.r[0] >> 2 * pin & 3

    def function(self, pin):
        return self.r.get(0x20 + 4 * (pin // 8), 0) >> 4 * (pin % 8) & 15

    def read(self, offset):
        if offset == 0x10:
            inputs = 0
            for pin in range(16):
                level = self.r.get(0x14, 0) >> pin & 1 if self.mode(pin) == 1 else self.chip.pin(self.port, pin)
                inputs |= int(bool(level)) << pin
            return inputs
        return self.r.get(offset, 0)

    def write(self, offset, value):
        old = self.r.get(0x14, 0)
        if offset == 0x18:
            self.r[0x14] = old & ~(value >> 16) | value & 0xFFFF
        elif offset == 0x28:
            self.r[0x14] = old & ~value
        else:
            self.r[offset] = value
        if self.port == "c" and (self.r.get(0x14, 0) ^ old) >> 11 & 1:
            self.chip.world.pumped(self.chip.now)
        self.chip.gate_moved(self.chip.now)


class Nvic(Plain):
    def __init__(self, chip):
        super().__init__(chip, "nvic")

    def priority(self, number):
        if number < 16:
            return {NMI: -2, HARD: -1, PENDSV: self.chip.scb.r.get(0x20, 0) >> 16 & 0xF0}.get(number, -1)
        irq = number - 16
        return self.r.get(0x300 + (irq & ~3), 0) >> 8 * (irq & 3) & 0xF0

    def enabled(self, number):
        return number < 16 or bool(self.r.get(4 * ((number - 16) // 32), 0) >> (number - 16) % 32 & 1)

    def write(self, offset, value):
        if 0x100 <= offset < 0x120:
            for bit in range(32):
                if value >> bit & 1:
                    self.chip.cpu.pend(16 + (offset - 0x100) * 8 + bit)
        elif offset < 0x20:
            self.r[offset] = self.r.get(offset, 0) | value
            self.chip.cpu.attention = True
        else:
            self.r[offset] = value


class Scb(Plain):
    def __init__(self, chip):
        super().__init__(chip, "scb")

    def read(self, offset):
        if offset == 0x04:
            return self.chip.cpu.active[-1][0] if self.chip.cpu.active else 0
        return self.r.get(offset, 0)

    def write(self, offset, value):
        if offset == 0x04 and value >> 28 & 1:
            self.chip.cpu.pend(PENDSV)
        elif offset == 0x0C and value >> 16 == 0x05FA and value & 4:
            self.chip.met("system_reset")
            self.chip.reset("software")
            self.chip.cpu.attention = True
        else:
            self.r[offset] = value
