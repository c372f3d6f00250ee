"""TIM1 with the gate and its break, TIM2 with the end of the hold time, TIM3 with the sample clock."""

from system import Plain


class Timer(Plain):
    """An up-counter from an origin in time; `span` counts until it wraps."""

    def __init__(self, chip, name, width):
        super().__init__(chip, name, {0x2C: (1 << width) - 1})
        self.origin, self.base = None, 0  # tick at which it was started, count then

    def span(self):
        return self.r[0x2C] + 1

    def count(self):
        if self.origin is None:
            return self.base
        self.chip.met("timer_count")
        return (self.base + (self.chip.now - self.origin) // (self.r.get(0x28, 0) + 1)) % self.span()

    def until(self, value, after):
        """First tick later than `after` at which the count becomes `value`, or None."""
        if self.origin is None or value >= self.span():
            return None
        step = self.r.get(0x28, 0) + 1
        first = self.origin + (value - self.base) % self.span() * step
        period = self.span() * step
        return first if first > after else first + ((after - first) // period + 1) * period

    def read(self, offset):
        return self.count() if offset == 0x24 else self.r.get(offset, 0)

    def write(self, offset, value):
        if offset == 0x24:
            self.base, self.origin = value, (None if self.origin is None else self.chip.now)
        elif offset == 0x10:
            self.r[0x10] = self.r.get(0x10, 0) & value
        elif offset == 0x14:
            if value & 1:
                self.update(self.chip.now, by_software=True)
        else:
            old, self.r[offset] = self.r.get(offset, 0), value
            if offset == 0x00 and (old ^ value) & 1:
                self.start(self.chip.now) if value & 1 else self.stop()
        self.changed()

    def start(self, tick):
        self.r[0] = self.r.get(0, 0) | 1
        if self.origin is None:
            self.origin = tick
            if self.r.get(4, 0) >> 4 & 7 == 1:
                self.chip.met("trgo_enable")
                self.trigger_out(tick)

    def stop(self):
        self.base, self.origin = self.count(), None

    def update(self, tick, by_software):
        mode = self.r.get(4, 0) >> 4 & 7
        if by_software:
            self.base, self.origin = 0, (None if self.origin is None else tick)
        if mode == 2 or mode == 0 and by_software:
            self.chip.met("trgo_ug")
            self.trigger_out(tick)

    def trigger_out(self, tick):
        pass

    def changed(self):
        pass


class Tim1(Timer):
    FROZEN_2 = 0xFFFF_FFFF & ~(1 << 15)  # by lock level 2: all but MOE

    def __init__(self, chip):
        super().__init__(chip, "tim1", 16)
        self.r[0x60] = 1  # the break pin is enabled after reset
        self.reference, self.event = 0, None
        self.breaks = set()

    def write(self, offset, value):
        chip, old = self.chip, self.r.get(offset, 0)
        if offset == 0x44:
            level = old >> 8 & 3
            if level >= 2:
                chip.met("bdtr_lock")
                if (value ^ old) & ~(1 << 15) & 0x7FFF and value & 0x7FFF:
                    chip.wrong.append("locked bits of TIM1_BDTR written with another value")
                value = old & self.FROZEN_2 | value & 1 << 15
            if self.active_break(value):
                chip.met("moe_break")
                value &= ~(1 << 15)
            self.r[offset] = value
            chip.gate_moved(chip.now)
            return
        if offset == 0x60 and self.r.get(0x44, 0) >> 8 & 3:
            chip.met("af1_lock")
            chip.wrong.append("TIM1_AF1 written behind the lock")
            return
        if offset == 0x10:
            self.r[0x10] = old & value | self.flags()
            if self.flags():
                chip.met("break_flags")
            return
        super().write(offset, value)

    def flags(self):
        """Break flags whose cause lasts."""
        if not self.r.get(0x44, 0) >> 12 & 1:
            return 0
        return (1 << 7 if self.breaks & self.wired() else 0) | (1 << 13 if self.breaks & {"clock", "pvd", "parity"} else 0)

    def wired(self):
        af1 = self.r.get(0x60, 0)
        return {name for name, bit in (("comp1", 1), ("comp4", 4)) if af1 >> bit & 1}

    def active_break(self, bdtr):
        return bdtr >> 12 & 1 and bool(self.breaks & (self.wired() | {"clock", "pvd", "parity"}))

    def set_break(self, name, active):
        if not active:
            self.breaks.discard(name)
            return
        self.breaks.add(name)
        if self.active_break(self.r.get(0x44, 0)):
            self.chip.met("moe_break")
            self.r[0x44] &= ~(1 << 15)
            self.r[0x10] = self.r.get(0x10, 0) | self.flags()
            self.chip.gate_moved(self.chip.now)

    def output(self):
        return int(bool(self.r.get(0x44, 0) >> 15 & 1 and self.r.get(0x20, 0) >> 8 & 1 and self.reference))

    def changed(self):
        """A new mode or compare value: the reference, and the next match."""
        mode = self.r.get(0x1C, 0) >> 4 & 7
        if mode == 4:
            self.reference = 0
        self.chip.gate_moved(self.chip.now)
        self.chip.cancel(self.event)
        tick = self.until(self.r.get(0x3C, 0), self.chip.now) if mode in (1, 2) else None
        self.event = None if tick is None else self.chip.at(tick, self.match)

    def match(self, tick):
        self.chip.met("compare_mode")
        self.reference = int((self.r.get(0x1C, 0) >> 4 & 7) == 1)
        self.chip.gate_moved(tick)
        self.event = self.chip.at(tick + self.span(), self.match)

    def trigger_out(self, tick):
        self.chip.tim3.trigger_in(tick)


class Tim2(Timer):
    def __init__(self, chip):
        super().__init__(chip, "tim2", 32)
        self.event = None

    def changed(self):
        self.chip.cancel(self.event)
        tick = self.until(self.r.get(0x34, 0), self.chip.now) if self.origin is not None else None
        self.event = None if tick is None else self.chip.at(tick, self.match)

    def match(self, tick):
        self.r[0x10] = self.r.get(0x10, 0) | 2
        if self.r.get(0x0C, 0) >> 9 & 1:
            self.chip.met("compare_dma")
            self.chip.dma.request(56, tick)


class Tim3(Timer):
    def __init__(self, chip):
        super().__init__(chip, "tim3", 16)
        self.event = None

    def trigger_in(self, tick):
        smcr = self.r.get(8, 0)
        if smcr & 0x1_0007 == 6 and smcr >> 4 & 7 == 0:
            self.chip.met("slave_start")
            self.start(tick)
            self.changed()

    def changed(self):
        self.chip.cancel(self.event)
        tick = self.until(0, self.chip.now) if self.origin is not None else None
        self.event = None if tick is None else self.chip.at(tick, self.overflow)

    def overflow(self, tick):
        self.update(tick, by_software=False)
        self.event = self.chip.at(tick + self.span(), self.overflow)

    def trigger_out(self, tick):
        for converter in self.chip.adc:
            converter.trigger(tick)
