"""The scenarios of tests/port on the image: what every port owes, by the same files as the native and the emulated board."""

from pathlib import Path

from bench import booted, branch
from cpu import HERTZ, US

FOLDER = Path(__file__).resolve().parents[1] / "port" / "scenarios"


class Mismatch(Exception):
    pass


def time_of(number, unit):
    return float(number) * {"us": 1.0, "ms": 1e3}[unit]


def causes(b):
    """What breaks at the pins, by name: begins, ends."""
    world, image = b.world, b.image
    stage = {}

    def setting(name, begin, end):
        return lambda: setattr(world, name, begin), lambda: setattr(world, name, end)

    def patch(symbol, code):
        def begin():
            stage[symbol] = image.symbols[symbol] & ~1
            b.cpu.uc.mem_write(stage[symbol], code)
            b.cpu.uc.ctl_remove_cache(stage[symbol], stage[symbol] + len(code))
        return begin, lambda: b.heal(stage[symbol])

    return {"stop_open": (world.open_stop, lambda: world.open_stop(False)),
            "mains_off": setting("volts_rms", 0.0, 230.0),
            "overcurrent": (lambda: world.force_current(1.95), lambda: world.force_current(None)),
            "supply_low": (lambda: b.chip.pwr.set_supply(2.75), lambda: b.chip.pwr.set_supply(3.3)),
            "samples_lost": (lambda: setattr(b.chip.adc[1], "stalled", True), None),
            "coil_open": setting("coil_open", True, False),
            "owner_silent": (lambda: None, lambda: None),  # this host says nothing unless it is asked to
            "laser_out": (lambda: world.offset.update(laser=2.9), lambda: world.offset.clear()),
            "relay_welded": setting("relay_welded", True, False),
            "relay_dead": setting("relay_dead", True, False),
            "switch_shorted": setting("shorted", True, False),
            "contact_welded": setting("welded", True, False),
            "control_hangs": patch("control_handler", b"\xfe\xe7"),
            "crash": patch("control_handler", b"\x00\xde")}


class Player:
    def __init__(self, bench):
        self.b, self.mark, self.slowest = bench, bench.chip.now, 0.0
        self.causes = causes(bench)

    def run(self, words):
        verb = words[0]
        if verb != "needs":  # everything is offered here
            getattr(self, verb if verb not in ("is", "set") else f"{verb}_")(*words[1:])

    def path(self, attribute):
        return "OUTPUT phase0 raw" if attribute == "angle" else attribute

    def must(self, good, found):
        if not good:
            raise Mismatch(found)

    def set_(self, attribute, value):
        answer = self.b.command(self.path(attribute), value)
        self.mark = self.b.world.line_free
        self.must(answer == 1, self.b.ctl("last_error"))

    def refused(self, attribute, value):
        self.must(self.b.command(self.path(attribute), value) < 0, "accepted")

    def shot(self, degrees, hold):
        self.set_("angle", round(100 * float(degrees)))
        self.set_("hold_time_ms", hold)
        self.set_("arm", 1)
        self.b.world.wait(80)

    def is_(self, attribute, *value):
        found = self.b.ctl(self.path(attribute))
        self.must(found == " ".join(value), f"it is {found}")

    def until(self, attribute, *rest):
        wanted, end = " ".join(rest[:-3]), self.b.chip.now + time_of(*rest[-2:]) * US
        while self.b.ctl(attribute) != wanted:
            self.must(self.b.chip.now < end, f"it is {self.b.ctl(attribute)}")
            self.b.run_us(200)

    def wait(self, number, unit):
        self.b.run_us(time_of(number, unit))

    def cause(self, name):
        self.mark = self.b.chip.now
        self.causes[name][0]()

    def end(self, name):
        self.causes[name][1]()

    def last(self, level):
        return next((t for t, l in reversed(self.b.chip.gate_edges) if l == level), None)

    def gate(self, level, how, number, unit):
        time = time_of(number, unit)
        if level == "on":
            self.must(self.b.wait_gate(1, time / 1e3), f"it is off; {self.b.ctl('last_error')}")
            self.mark = self.b.chip.now
        elif how == "for":
            on = self.last(1)
            self.b.run_us(time)
            self.must(not self.b.chip.gate() and self.last(1) == on, "it was on")
        else:
            self.b.cpu.run(max(self.b.chip.now, self.mark + round((time + 500) * US)))
            self.must(not self.b.chip.gate(), "it is on")
            took = max(0.0, ((self.last(0) or 0) - self.mark) / US)
            self.slowest = max(self.slowest, took)
            self.must(took <= time, f"after {took:.2f} us")

    def held(self, number, unit, _, number2, unit2):
        found = (self.last(0) - self.last(1)) / US
        self.must(abs(found - time_of(number, unit)) <= time_of(number2, unit2), f"{found:.2f} us")

    def angle(self, degrees, _, tolerance):
        found = self.b.world.phase_degrees(self.last(1))
        self.must(abs((found - float(degrees) + 180) % 360 - 180) <= float(tolerance), f"{found:.3f} degrees")

    def relay(self, where, *rest):
        state = lambda: self.b.world.relay(self.b.now())
        if where == "in":
            return self.must(state(), "it is out")
        end = self.b.chip.now + time_of(*rest[-2:]) * US
        while state():
            self.must(self.b.chip.now < end, "it is in")
            self.b.run_us(200)


def play(b, path):
    player = Player(b)
    for number, line in enumerate(path.read_text().splitlines(), 1):
        words = line.split("#")[0].split()
        try:
            if words:
                player.run(words)
        except Mismatch as found:
            return False, f"line {number}: {line}: {found}", b.chip.rules
    return True, f"slowest gate off {player.slowest:.2f} us" if player.slowest else "", b.chip.rules


def run(image, report):
    b = booted(image)
    files = sorted(FOLDER.glob("*.scenario"))
    for path, (ending, found) in zip(files, branch([lambda p=p: play(b, p) for p in files])):
        good, text, rules = found if ending == "done" else (False, found.strip()[-200:], {})
        report.verdict(f"port: {path.stem}", text, good)
        report.rules.update(rules)
    report.verdict("port: scenarios", len(files), len(files) >= 20)
