"""The chip: bus, clock gates, events in time, reset. The blocks themselves are in system.py, timers.py and data.py."""

import heapq
from collections import Counter

import data
import system
import timers
from cpu import FLASH, HERTZ, NMI, RAM, Cpu

PIN, BOR, SOFTWARE, WATCHDOG = "pin", "bor", "software", "watchdog"


class Chip:
    """`option_bytes`: FLASH_OPTR as loaded; the default is what a bench needs. `world`: what the pins see."""

    def __init__(self, image, world, option_bytes=system.OPTR_BENCH, crystal=True):
        self.world, self.crystal, self.option_bytes = world, crystal, option_bytes
        self.rules = Counter()  # how often each rule of rules.py has been met
        self.wrong = []  # what the image did that the vendor forbids
        self.gate_edges = []  # (tick, level)
        self.flags, self.supply = 0, 3.3
        self.resets = []
        self.heap, self.order = [], 0
        self.flash = system.Flash(self)
        self.build(BOR)
        self.cpu = Cpu(image, self)
        world.attach(self)

    def met(self, rule):
        self.rules[rule] += 1

    def build(self, cause):
        """Every block in its reset state."""
        self.reset_wanted, self.clock_ticks_x2 = None, 3 * HERTZ // 16_000_000
        self.heap = [e for e in self.heap if e[3]]  # what the world has planned goes on
        heapq.heapify(self.heap)
        self.rcc = system.Rcc(self, cause)
        self.pwr, self.syscfg, self.exti = system.Pwr(self), system.Syscfg(self), system.Exti(self)
        self.flash.reset()
        self.iwdg, self.nvic, self.scb = system.Iwdg(self), system.Nvic(self), system.Scb(self)
        self.gpio = {p: system.Gpio(self, p) for p in "abc"}
        self.tim1, self.tim2, self.tim3 = timers.Tim1(self), timers.Tim2(self), timers.Tim3(self)
        self.adc = [data.Adc(self, n) for n in range(5)]
        self.dac3, self.comp = system.Plain(self, "dac3"), data.Comparators(self)
        self.dma, self.dmamux, self.usart = data.Dma(self), data.Plain(self, "dmamux"), data.Usart(self)
        common = [data.Plain(self, f"adc{n}_common") for n in (12, 345)]
        gate = system.GATES
        self.pages = {}
        for base, size, block, clock in (
                (0x4000_0000, 0x400, self.tim2, "tim2"), (0x4000_0400, 0x400, self.tim3, "tim3"),
                (0x4000_3000, 0x400, self.iwdg, None), (0x4000_4400, 0x400, self.usart, "usart2"),
                (0x4000_7000, 0x400, self.pwr, "pwr"), (0x4001_0000, 0x100, self.syscfg, "syscfg"),
                (0x4001_0200, 0x100, self.comp, "syscfg"), (0x4001_0400, 0x400, self.exti, None),
                (0x4001_2C00, 0x400, self.tim1, "tim1"), (0x4002_0000, 0x400, self.dma, "dma1"),
                (0x4002_0800, 0x400, self.dmamux, "dmamux"), (0x4002_1000, 0x400, self.rcc, None),
                (0x4002_2000, 0x400, self.flash, None), (0x4800_0000, 0x400, self.gpio["a"], "gpioa"),
                (0x4800_0400, 0x400, self.gpio["b"], "gpiob"), (0x4800_0800, 0x400, self.gpio["c"], "gpioc"),
                (0x5000_0000, 0x100, self.adc[0], "adc12"), (0x5000_0100, 0x100, self.adc[1], "adc12"),
                (0x5000_0300, 0x100, common[0], "adc12"), (0x5000_0400, 0x100, self.adc[2], "adc345"),
                (0x5000_0500, 0x100, self.adc[3], "adc345"), (0x5000_0600, 0x100, self.adc[4], "adc345"),
                (0x5000_0700, 0x100, common[1], "adc345"), (0x5000_1000, 0x400, self.dac3, "dac3"),
                (0xE000_E100, 0x500, self.nvic, None), (0xE000_ED00, 0x100, self.scb, None),
                (0xE004_2000, 0x100, system.Plain(self, "dbgmcu"), None)):
            for page in range(base >> 8, (base + size) >> 8):
                self.pages[page] = (base, block, gate.get(clock))

    # --- bus ---

    def _find(self, address):
        entry = self.pages.get(address >> 8)
        if entry is None:
            self.wrong.append(f"access to {address:#010x}, where this model has nothing")
            return None, 0
        base, block, clock = entry
        if clock and not self.rcc.r.get(clock[0], 0) >> clock[1] & 1:
            self.wrong.append(f"{block.name} +{address - base:#x} used without its clock")
            self.met("clock_gate")
            return None, 0
        return block, address - base

    def read(self, address, size):
        block, offset = self._find(address)
        if block is None:
            return 0
        return block.read(offset & ~3) >> 8 * (offset & 3) & (1 << 8 * size) - 1

    def write(self, address, size, value):
        block, offset = self._find(address)
        if block is None:
            return
        if size != 4:  # only the priorities are written in bytes
            if block is not self.nvic:
                self.wrong.append(f"{block.name} +{offset:#x} written with {size} bytes")
            old, shift = block.read(offset & ~3), 8 * (offset & 3)
            value = old & ~(0xFF << shift) | value << shift
        block.write(offset & ~3, value)

    # --- time ---

    @property
    def now(self):
        return self.cpu.now

    def at(self, tick, call, world=False):
        """Calls call(tick) when that tick comes; world: also when a reset lies between. Returns a handle for cancel()."""
        self.order += 1
        event = [tick, self.order, call, world]
        heapq.heappush(self.heap, event)
        if tick < self.cpu.limit:
            self.cpu.limit = tick
        return event

    def cancel(self, event):
        if event is not None:
            event[2] = None

    def next_event(self):
        while self.heap and self.heap[0][2] is None:
            heapq.heappop(self.heap)
        return self.heap[0][0] if self.heap else 1 << 62

    def run_events(self, now):
        while self.next_event() <= now:
            tick, _, call, _ = heapq.heappop(self.heap)
            call(tick)
        return now

    # --- resets ---

    def reset(self, cause):
        self.reset_wanted = self.reset_wanted or cause

    def reset_now(self):
        self.resets.append((self.now, self.reset_wanted))
        self.build(self.reset_wanted)
        self.gate_moved(self.now)
        self.cpu.reset()

    def power_cycle(self, ram):
        """Supply off and on again; `ram`: kept (True) or arbitrary."""
        if not ram:
            self.cpu.uc.mem_write(RAM, self.world.noise_bytes(128 * 1024))
        self.flags = 0
        self.supply = 3.3
        self.reset(BOR)

    def nmi(self):
        self.cpu.pend(NMI)

    # --- what leaves the chip ---

    def gate_moved(self, tick):
        level = self.gate()
        if not self.gate_edges or self.gate_edges[-1][1] != level:
            if self.gate_edges or level:
                self.gate_edges.append((tick, level))
                self.world.gate_moved(tick, level)

    def gate(self):
        """Level of PA10; the pull-down outside holds it low while nothing drives it."""
        pin = self.gpio["a"]
        mode = pin.mode(10)
        if mode == 1:
            return pin.r.get(0x14, 0) >> 10 & 1
        if mode == 2 and pin.function(10) == 6:
            self.met("moe")
            return self.tim1.output()
        return 0

    def pin(self, port, number):
        return self.world.pin(port, number)

    def code(self, address):
        return FLASH <= address < FLASH + 0x80000
