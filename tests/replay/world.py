"""What stands around the chip: mains, coil, contact, sensors at the pins of docs/how-to/board.md; the host on the serial line."""

import math
import random

from cpu import HERTZ, Hung

BYTE = 850  # ticks: ten bits at 2 Mbaud
# converter (0 .. 4), input -> channel, at the pin: volts at zero, volts a unit (docs/how-to/board.md, table of the pins)
PINS = {(0, 6): ("pvdf_a", 1.65, 6.36e-3), (1, 7): ("pvdf_b", 1.65, 6.36e-3), (2, 12): ("coil_current", 1.65, 0.75),
        (2, 5): ("aux", 1.65, 0.15), (3, 4): ("coil_voltage", 1.65, 2.5e-3), (3, 5): ("mains_voltage", 1.65, 2.5e-3),
        (4, 1): ("laser", 0.0, 300.0), (4, 2): ("contact_a", 0.0, 0.3)}
FILTER = 7.5e-6  # s, delay of every analogue input but the laser's


class World:
    """Mains as a sine of `hertz` whose rising zero crossing is at `origin` s; a coil that follows the gate."""

    def __init__(self, hertz=50.0, origin=0.0123, seed=1):
        self.hertz, self.origin = hertz, origin
        self.volts_rms = 230.0
        self.random = random.Random(seed)
        self.stop_open = False
        self.offset = {}  # volts added at a pin, by channel
        self.shorted = False  # the coil's switch does not open
        self.coil_open = False
        self.welded = False
        self.relay_welded = self.relay_dead = False
        self.gate_changes = []  # (s, level)
        self.pump_edges = []  # ticks
        self.received = bytearray()
        self.forced_current = None
        self.line_free = 0

    def attach(self, chip):
        self.chip = chip

    def noise_bytes(self, n):
        return self.random.randbytes(n)

    # --- the bench ---

    def mains(self, t):
        return self.volts_rms * math.sqrt(2) * math.sin(2 * math.pi * self.hertz * (t - self.origin))

    def phase_degrees(self, tick):
        return (tick / HERTZ - self.origin) * self.hertz * 360 % 360

    def coil_on(self, t):
        """The switch conducts: from the gate's edge to the first zero of the current behind its end."""
        if self.coil_open or not self.relay(t):
            return False
        if self.shorted:
            return True
        on = False
        for at, level in self.gate_changes:
            if at > t:
                break
            on, edge = level, at
            if not level:
                half = 0.5 / self.hertz
                zero = math.ceil((at - self.origin - self.lag) / half) * half + self.origin + self.lag
                on = t < zero
        return on

    def relay(self, t):
        """The safety relay is in: its pump has moved within the last 10 ms."""
        if self.relay_welded or self.relay_dead:
            return self.relay_welded
        return len(self.pump_edges) > 1 and t * HERTZ - self.pump_edges[-1] < 0.010 * HERTZ

    lag = 0.003  # s, of the coil's current behind its voltage

    def current(self, t):
        if self.forced_current is not None:
            return self.forced_current
        if not self.coil_on(t):
            return 0.0
        return 0.6 * math.sin(2 * math.pi * self.hertz * (t - self.origin - self.lag))

    def closed(self, t):
        """Share of the core's way: 12 ms after switch-on it moves for 4 ms, 20 ms after switch-off it returns."""
        if self.welded:
            return 1.0
        share = 0.0
        for at, level in self.gate_changes:
            if at <= t:
                delay, goal = (0.012, 1.0) if level else (0.020, 0.0)
                way = min(max((t - at - delay) / 0.004, 0.0), 1.0)
                share += (goal - share) * way
        return share

    def quantity(self, channel, t):
        if channel == "mains_voltage":
            return self.mains(t)
        if channel == "coil_current":
            return self.current(t)
        if channel == "coil_voltage":
            return self.mains(t) if self.coil_on(t) else 0.0
        if channel == "laser":
            return 0.001 + 0.005 * self.closed(t)
        if channel == "contact_a":
            return 0.05 if self.closed(t) > 0.8 else 6.0
        return 0.0

    def volts(self, converter, channel, tick):
        name, zero, gain = PINS[converter, channel]
        t = tick / HERTZ - (0.0 if name == "laser" else FILTER)
        noise = self.random.gauss(0.0, 0.3e-3)
        return zero + gain * self.quantity(name, t) + self.offset.get(name, 0.0) + noise

    def pin_volts(self, port, number):
        return 1.65 + 0.75 * self.current(self.chip.now / HERTZ) + self.offset.get("coil_current", 0.0)

    def pin(self, port, number):
        """Level of a digital input."""
        if (port, number) == ("c", 12):  # a contact to ground that is closed while the relay is out
            return self.relay(self.chip.now / HERTZ)
        return self.stop_open if (port, number) == ("c", 10) else False

    def gate_moved(self, tick, level):
        self.gate_changes.append((tick / HERTZ, level))

    def pumped(self, tick):
        self.pump_edges.append(tick)
        del self.pump_edges[:-4]

    def open_stop(self, is_open=True):
        self.stop_open = is_open
        self.chip.exti.pin("c", 10, is_open)
        self.chip.cpu.attention = True

    def force_current(self, ampere):
        self.forced_current = ampere
        self.chip.comp.look()

    # --- the host ---

    def heard(self, byte, tick):
        self.received.append(byte)
        self.last_byte = tick

    def send(self, text):
        data = text.encode() if isinstance(text, str) else text
        at = max(self.chip.now, self.line_free)
        for i, byte in enumerate(data):
            self.chip.at(at + (i + 1) * BYTE, lambda t, b=byte: self.chip.usart.receive(b), world=True)
        self.line_free = at + len(data) * BYTE

    def ask(self, text, lines=1, milliseconds=60):
        """Sends a request, returns the answer of so many lines."""
        self.received.clear()
        self.send(text)
        self.chip.cpu.run(1 << 62, lambda: self.received.count(b"\n") >= lines, milliseconds * HERTZ // 1000)
        return self.received.decode("latin-1")

    def read(self, what):
        """Value of an attribute, for instance 'contactor-ctl state'."""
        answer = self.ask(f"READ {what}\r\n", lines=1)
        length = int(answer.split("\n")[0])
        if length < 0:
            return str(length)
        need = len(str(length)) + 1 + length + 1
        self.chip.cpu.run(1 << 62, lambda: len(self.received) >= need, HERTZ // 10)
        return self.received.decode("latin-1").split("\n", 1)[1][:length].rstrip("\0")

    def write(self, what, value):
        """Writes an attribute; the number answered: bytes taken, or minus an error."""
        value = str(value)
        return int(self.ask(f"WRITE {what} {len(value)}\r\n{value}"))

    def wait(self, milliseconds):
        self.chip.cpu.run(self.chip.now + int(milliseconds * HERTZ / 1000))

    def wait_for(self, condition, milliseconds):
        try:
            self.chip.cpu.run(1 << 62, condition, int(milliseconds * HERTZ / 1000))
            return True
        except Hung:
            return False
