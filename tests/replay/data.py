"""Converters, comparators, direct memory access, serial port."""

from cpu import HERTZ, US
from system import Plain

ADC_CLOCK = 4  # ticks of 170 MHz: HCLK / 4
REQUESTS = (5, 36, 37, 38, 39)


class Adc(Plain):
    """One converter: a regular sequence of one or two inputs, oversampled, fetched by DMA."""

    def __init__(self, chip, index):
        super().__init__(chip, f"adc{index + 1}", {0x08: 0x2000_0000, 0x0C: 0x8000_0000})
        self.index, self.busy = index, False
        self.regulator = self.calibrated = None
        self.triggers = []  # the first ticks at which a burst began
        self.lost = 0
        self.stalled = False  # a fault on request: results are not fetched

    def write(self, offset, value):
        chip, cr = self.chip, self.r[0x08]
        if offset in (0x0C, 0x10, 0x14, 0x18, 0x30, 0x34, 0x38, 0x3C) and cr & 4:
            chip.met("adc_locked")
            chip.wrong.append(f"{self.name} configured while it converts")
            return
        if offset == 0x00:
            self.r[0] = self.r.get(0, 0) & ~value
            return
        if offset != 0x08:
            self.r[offset] = value
            return
        keep = cr & 0x8000_000F  # command bits: set by writing 1, cleared by hardware
        new = value & 0x7000_0000 | keep | value & 0x8000_0015
        if value >> 28 & 1 and not cr >> 28 & 1:
            self.regulator = chip.now
        if value >> 31 & 1 and not cr >> 31 & 1:
            chip.met("adc_regulator")
            if new >> 29 & 1 or self.regulator is None or chip.now - self.regulator < 20 * US or cr & 1:
                chip.wrong.append(f"{self.name} calibrated before its regulator stands")
            chip.at(chip.now + 116 * ADC_CLOCK, self._calibrated)
        if value & 1 and not cr & 1:
            chip.met("adc_enable")
            if self.calibrated is None or chip.now - self.calibrated < 4 * ADC_CLOCK:
                chip.wrong.append(f"{self.name} enabled too early after its calibration")
            chip.at(chip.now + 20 * ADC_CLOCK, lambda t: self._set(1))
        if value & 4 and not self.r.get(0, 0) & 1 and not cr & 4:
            chip.wrong.append(f"{self.name} started before it was ready")
        self.r[0x08] = new

    def read(self, offset):
        if offset == 0x40:
            self.r[0] = self.r.get(0, 0) & ~4
        return self.r.get(offset, 0)

    def _set(self, bit):
        self.r[0] = self.r.get(0, 0) | bit

    def _calibrated(self, tick):
        self.r[0x08] &= ~(1 << 31)
        self.calibrated = tick

    def trigger(self, tick):
        cfgr = self.r[0x0C]
        if not self.r[0x08] & 4 or cfgr >> 5 & 31 != 4 or cfgr >> 10 & 3 != 1:
            return
        self.chip.met("adc_trigger")
        if self.busy:
            self.lost += 1
            return
        if len(self.triggers) < 8:
            self.triggers.append(tick)
        self.busy = True
        ranks = (self.r.get(0x30, 0) & 15) + 1
        cfgr2 = self.r.get(0x10, 0)
        ratio = 2 << (cfgr2 >> 2 & 7) if cfgr2 & 1 else 1
        cycles = 12.5 + self._sampling(self.r.get(0x30, 0) >> 6 & 31)
        self.chip.met("adc_burst")
        self.chip.at(tick + round(ranks * ratio * cycles * ADC_CLOCK),
                     lambda t: self._done(tick, ranks, ratio, cycles))

    def _sampling(self, channel):
        code = self.r.get(0x14 if channel < 10 else 0x18, 0) >> 3 * (channel % 10) & 7
        return (2.5, 6.5, 12.5, 24.5, 47.5, 92.5, 247.5, 640.5)[code]

    def _done(self, start, ranks, ratio, cycles):
        self.busy = False
        for rank in range(ranks):
            channel = self.r.get(0x30, 0) >> 6 * (rank + 1) & 31
            centre = start + ((rank * ratio + (ratio - 1) / 2) * cycles + cycles - 12.5) * ADC_CLOCK
            volts = self.chip.world.volts(self.index, channel, centre)
            code = min(max(volts / 3.3 * 4096, 0.0), 4095.0)
            if self.r.get(0, 0) & 4:  # the last result is still there
                self.chip.met("adc_overrun")
                self.r[0] |= 1 << 4
            self.r[0x40] = int(code * ratio + 0.5)
            self._set(4)
            if self.r[0x0C] & 1 and not self.stalled:
                self.chip.dma.request(REQUESTS[self.index], self.chip.now)


class Comparators(Plain):
    def __init__(self, chip):
        super().__init__(chip, "comp")

    def write(self, offset, value):
        if self.r.get(offset, 0) >> 31 & 1:
            self.chip.wrong.append("comparator written behind its lock")
            return
        self.r[offset] = value
        self.look()

    def look(self):
        """To be called whenever a pin or a level has changed."""
        levels = self.chip.dac3.r
        for name, offset, channel, positive in (("comp1", 0x00, 0x08, {0: None, 1: ("b", 1)}),
                                                ("comp4", 0x0C, 0x14, {0: ("b", 0), 1: None})):
            csr = self.r.get(offset, 0)
            pin = positive[csr >> 8 & 1]
            if not csr & 1 or csr >> 4 & 7 != 4 or pin is None:
                continue
            self.chip.met("comparator")
            high = self.chip.world.pin_volts(*pin) > levels.get(channel, 0) / 4096 * 3.3
            self.chip.tim1.set_break(name, high != bool(csr >> 15 & 1))


class Dma(Plain):
    def __init__(self, chip):
        super().__init__(chip, "dma1")
        self.at, self.left = [0] * 8, [0] * 8
        self.dead = set()  # channels that a fault on request keeps from their transfers

    def read(self, offset):
        if offset >= 8 and (offset - 8) % 0x14 == 4:
            n = (offset - 8) // 0x14
            if n == 5:
                self.chip.usart.looked(self.left[n])
            elif n == 6 and self.left[n]:
                self.chip.cpu.idle = True
            return self.left[n]
        return self.r.get(offset, 0)

    def write(self, offset, value):
        if offset == 0x04:
            self.r[0] = self.r.get(0, 0) & ~value
            return
        n, register = divmod(offset - 8, 0x14)
        if register and self.r.get(8 + 0x14 * n, 0) & 1:
            self.chip.met("dma_locked")
            self.chip.wrong.append(f"DMA channel {n + 1} set up while it is enabled")
            return
        old, self.r[offset] = self.r.get(offset, 0), value
        if register == 4:
            self.left[n] = value
        if register == 0 and value & 1 and not old & 1:
            self.at[n] = 0
            self.chip.usart.feed_dma()

    def request(self, line, tick):
        mux = self.chip.dmamux
        for n in range(8):
            if mux.r.get(4 * n, 0) & 0x7F == line:
                return self.transfer(n)
        return False

    def transfer(self, n):
        """One item; False when the channel does not serve."""
        base = 8 + 0x14 * n
        ccr = self.r.get(base, 0)
        if not ccr & 1 or not self.left[n] or n in self.dead:
            return False
        chip, size = self.chip, 1 << (ccr >> 8 & 3)
        chip.met("dma_transfer")
        chip.met("dmamux")
        total = self.r[base + 4]
        memory = self.r[base + 12] + (self.at[n] << (ccr >> 10 & 3) if ccr >> 7 & 1 else 0)
        width = 1 << (ccr >> 10 & 3)
        if ccr >> 4 & 1:
            value = int.from_bytes(chip.cpu.uc.mem_read(memory, width), "little")
            chip.write(self.r[base + 8], 4, value)
        else:
            chip.cpu.poke(memory, chip.read(self.r[base + 8], size), width)
        self.at[n] += 1
        self.left[n] -= 1
        flags = 4 if self.left[n] == total // 2 else 2 if self.left[n] == 0 else 0
        if flags:
            self.r[0] = self.r.get(0, 0) | (flags | 1) << 4 * n
            if flags & (ccr & 6):  # TCIE is bit 1, HTIE bit 2, as the flags
                chip.cpu.pend(16 + 11 + n)
        if not self.left[n] and ccr >> 5 & 1:
            self.left[n], self.at[n] = total, 0
        return True


class Usart(Plain):
    """Bytes in and out, ten bit times each; DMA or FIFO on either side."""

    def __init__(self, chip):
        super().__init__(chip, "usart2")
        self.fifo_in, self.fifo_out, self.sending = [], [], False
        self.unseen = False  # a byte has come that the image has not looked for

    def byte_ticks(self):
        return 10 * max(self.r.get(0x0C, 0), 16)

    def status(self):
        room = len(self.fifo_out) < 8
        return (self.r.get(0x1C, 0) & 31) | (1 << 5 if self.fifo_in else 0) | (1 << 7 if room else 0) | \
            (0 if self.sending or self.fifo_out else 1 << 6)

    def read(self, offset):
        if offset == 0x1C:
            if len(self.fifo_out) >= 8 or not self.unseen and not self.chip.cpu.active:
                self.chip.cpu.idle = True
            return self.status()
        if offset == 0x24:
            return self.fifo_in.pop(0) if self.fifo_in else 0
        return self.r.get(offset, 0)

    def write(self, offset, value):
        if offset == 0x20:
            self.r[0x1C] = self.r.get(0x1C, 0) & ~value
        elif offset == 0x28:
            if len(self.fifo_out) >= 8:
                self.chip.wrong.append("byte written to a full transmit FIFO")
                return
            self.fifo_out.append(value & 0xFF)
            self._send()
        else:
            self.r[offset] = value
            self.feed_dma()

    def looked(self, left):
        if not self.chip.cpu.active:
            self.unseen = False

    def _idle(self, last):
        """No byte for the time of one."""
        if last == self.last:
            self.r[0x1C] = self.r.get(0x1C, 0) | 1 << 4
            if self.r.get(0, 0) >> 4 & 1:
                self.chip.met("usart_idle")
                self.chip.cpu.pend(16 + 38)

    def _send(self):
        if not self.sending and self.fifo_out and self.r.get(0, 0) & 9 == 9:
            self.sending = True
            self.chip.met("usart_frame")
            byte = self.fifo_out.pop(0)
            self.chip.at(self.chip.now + self.byte_ticks(), lambda t: self._sent(byte))

    def _sent(self, byte):
        self.sending = False
        self.chip.world.heard(byte, self.chip.now)
        self.feed_dma()
        self._send()

    def feed_dma(self):
        while self.r.get(0x08, 0) >> 7 & 1 and len(self.fifo_out) < 8:
            if not self.chip.dma.request(27, self.chip.now):
                break

    def receive(self, byte, flags=0):
        """A byte from the line; `flags`: framing 2, noise 4."""
        if self.r.get(0, 0) & 5 != 5:
            return
        self.unseen, self.last = True, self.chip.now
        self.chip.at(self.chip.now + self.byte_ticks(), lambda t, last=self.last: self._idle(last))
        self.r[0x1C] = self.r.get(0x1C, 0) | flags
        if len(self.fifo_in) >= 8:
            self.r[0x1C] |= 8
            return
        self.fifo_in.append(byte)
        while self.r.get(0x08, 0) >> 6 & 1 and self.fifo_in:
            if not self.chip.dma.request(26, self.chip.now):
                break
