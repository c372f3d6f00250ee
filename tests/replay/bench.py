"""The image in its world, brought to a state of the bench; and cases that begin from there, each in a process of its own."""

import os
import pickle
import re
import subprocess
import sys
import traceback
from collections import Counter

from chip import Chip
from cpu import HERTZ, US
from world import World

CTL, DAQ = "contactor-ctl", "contactor-daq"
TOKEN = "t"  # of the lease that the commands carry


class Image:
    """The linked program: bytes for flash, addresses of its functions."""

    def __init__(self, folder):
        with open(f"{folder}/board.bin", "rb") as file:
            self.bytes = file.read()
        listing = subprocess.run(["arm-none-eabi-nm", "-C", f"{folder}/board.elf"], capture_output=True, text=True,
                                 check=True).stdout
        self.symbols = {}
        for line in listing.splitlines():
            found = re.match(r"([0-9a-f]{8}) \w (.+)", line)
            if found:
                self.symbols[found[2]] = int(found[1], 16)


class Bench:
    def __init__(self, image, world=None, **options):
        self.image, self.world = image, world or World()
        self.chip = Chip(image.bytes, self.world, **options)
        self.cpu = self.chip.cpu

    def boot(self, milliseconds=125):
        """Until the zero of the current has been captured, 0.1 s."""
        self.world.wait(milliseconds)
        return self

    def ctl(self, name):
        return self.world.read(f"{CTL} {name}")

    def command(self, name, value=1):
        """A command of the lease's owner; 1 when it is accepted, else the error number."""
        self.world.write(f"{CTL} lease", f"{TOKEN} 3600000 replay")
        answer = self.world.write(f"{CTL} {name}", f"{value} {TOKEN}")
        return min(answer, 1)

    def state(self):
        return self.ctl("state"), self.ctl("fault")

    def arm(self, centi_degrees=3700, hold_ms=50):
        self.command("OUTPUT phase0 raw", centi_degrees)
        self.command("hold_time_ms", hold_ms)
        answer = self.command("arm")
        self.world.wait(80)
        return answer

    def fire(self):
        return self.command("fire")

    def wait_gate(self, level, milliseconds=100):
        """Runs until the gate has that level; False when it does not come."""
        return self.world.wait_for(lambda: self.chip.gate() == level, milliseconds)

    def energise(self, **how):
        assert self.arm(**how) == 1, self.ctl("last_error")
        assert self.fire() == 1, self.ctl("last_error")
        assert self.wait_gate(1), self.ctl("last_error")
        return self

    def now(self):
        """s since the start."""
        return self.chip.now / HERTZ

    def run_us(self, microseconds):
        self.cpu.run(self.chip.now + int(microseconds * US))

    def off_after(self, cause_tick):
        """us from the cause to the gate's last off edge; None while it is on."""
        if self.chip.gate():
            return None
        edges = self.chip.gate_edges
        return max(0.0, (edges[-1][0] - cause_tick) / US) if edges else 0.0

    def hang(self, function):
        """From now on this function never ends."""
        address = self.image.symbols[function] & ~1
        self.cpu.uc.mem_write(address, b"\xfe\xe7")
        self.cpu.uc.ctl_remove_cache(address, address + 2)
        return address

    def heal(self, address):
        self.cpu.uc.mem_write(address, self.image.bytes[address - 0x0800_0000:address - 0x0800_0000 + 2])
        self.cpu.uc.ctl_remove_cache(address, address + 2)


_ready = None  # a bench that has booted, until somebody uses it


def prepare(image):
    """Boots one bench; every process that is forked from here finds it and need not boot its own."""
    global _ready
    _ready = Bench(image).boot()


def booted(image):
    """A bench of its own that has booted."""
    global _ready
    found, _ready = _ready, None
    return found or Bench(image).boot()


class Report:
    def __init__(self):
        self.lines, self.rules = [], Counter()

    def apart(self, *cases):
        """Each case(report) in a process of its own; their verdicts in order."""
        def play(case):
            report = Report()
            case(report)
            return report
        for ending, found in branch([lambda c=c: play(c) for c in cases]):
            if ending == "done":
                self.lines += found.lines
                self.rules.update(found.rules)
            else:
                self.lines.append((False, "case", found.strip()[-300:]))

    def verdict(self, name, value, good):
        self.lines.append((bool(good), name, str(value)))

    def broken(self, name, bench, known=()):
        wrong = [w for w in dict.fromkeys(bench.chip.wrong) if w not in known]
        self.verdict(name, "; ".join(wrong[:3]) or "none", not wrong)


def branch(calls):
    """Each call in a copy of this process, as many at once as there are processors; their results in order."""
    results, running = [None] * len(calls), {}
    width = os.cpu_count() or 1

    def collect(block):
        for fd, (pid, index) in list(running.items()):
            if block and fd != next(iter(running)):
                continue
            with os.fdopen(fd, "rb") as pipe:
                results[index] = pickle.loads(pipe.read())
            os.waitpid(pid, 0)
            del running[fd]
            if block:
                return

    for index, call in enumerate(calls):
        if len(running) >= width:
            collect(block=True)
        out, into = os.pipe()
        sys.stdout.flush()
        pid = os.fork()
        if pid == 0:
            os.close(out)
            try:
                answer = ("done", call())
            except BaseException:  # the parent must learn of every end of a case
                answer = ("failed", traceback.format_exc())
            with os.fdopen(into, "wb") as pipe:
                pickle.dump(answer, pipe)
            os._exit(0)
        os.close(into)
        running[out] = (pid, index)
    while running:
        collect(block=True)
    return results
