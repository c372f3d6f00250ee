"""Faults that appear at the pins, at phases of the mains (4, or POWBENCH_REPLAY_PHASES), armed, with the edge ahead, and energised.

Limits from firmware/faults.h. What the other scenarios show is not repeated: stop, supply, crystal, lost samples, resets, relay and switch.
"""

import os
import re
from pathlib import Path

from bench import branch, booted
from cpu import HERTZ, US

FAULTS = Path(__file__).resolve().parents[2] / "firmware" / "faults.h"
PHASES = int(os.environ.get("POWBENCH_REPLAY_PHASES", "4"))
FILTER = 20.0  # us: from the pin through the analogue filter and one scan; the limits count from the samples


def limit_of(name):
    found = re.search(rf"X\((\d+), {name}, \w+, ([\d']+),", FAULTS.read_text())
    return int(found[1]), int(found[2].replace("'", ""))


def mains(factor):
    def act(b):
        b.world.volts_rms *= factor
    return act


def forced(ampere):
    return lambda b: b.world.force_current(ampere)


def coil_open(b):
    b.world.coil_open = True


def laser_out(b):
    b.world.offset["laser"] = 2.9


def silence(b):
    """The owner says nothing: a replayed host never does unless it is asked to."""


# fault, what happens, states, hold time in ms
CASES = (("mains_lost", mains(0.0), ("armed", "ahead", "energised"), 60), ("phase_invalid", mains(0.4), ("ahead",), 60),
         ("coil_overcurrent", forced(1.85), ("armed", "ahead", "energised"), 60), ("coil_not_energising", coil_open, ("energised",), 60),
         ("sensor_implausible", laser_out, ("armed", "ahead"), 60), ("host_lost", silence, ("energised",), 400))


def base(image, state, hold):
    b = booted(image)
    if state == "energised":
        b.energise(hold_ms=hold)
        b.world.wait(2)
    else:
        b.arm(hold_ms=hold)
    return b


def late(b, cause, limit):
    """The gate went on when the fault had long been there."""
    return any(level and t > cause + (limit + FILTER) * US for t, level in b.chip.gate_edges)


def play(b, state, act, phase, number, limit):
    """us that the gate was on, or went on, after the cause; infinity where the fault is another one or the gate stays."""
    period = HERTZ / b.world.hertz
    start = b.chip.now + round(phase * period / PHASES)
    if state == "ahead":
        b.fire()  # the edge follows within a cycle and a block
    b.cpu.run(max(start, b.chip.now))
    cause = b.chip.gate_edges[0][0] if number == 8 else b.chip.now
    on_before = len(b.chip.gate_edges)
    act(b)
    b.run_us(limit + FILTER + (0 if number == 8 else 25_000))
    if number in (2, 17) and len(b.chip.gate_edges) > 0:  # the edge was there first: the shot goes on to its end
        b.world.wait(70)
        return (0.0, "") if not late(b, cause, limit) and not b.chip.gate() else (float("inf"), "an edge too late")
    on_until = [t for t, level in b.chip.gate_edges[on_before:] if not level]
    time = (on_until[-1] - cause) / US if on_until else 0.0
    fault = b.ctl("fault")
    expected = str(number) if number != 2 else "0"  # invalid for a second before it is one
    if late(b, cause, limit) or b.chip.gate() or fault.split()[0] != expected:
        return float("inf"), fault
    return time, ""


def run(image, report):
    bases = {}  # each case begins in a copy of its own
    for name, act, states, hold in CASES:
        number, limit = limit_of(name)
        for state in states:
            key = state == "energised", hold
            bases[key] = b = bases.get(key) or base(image, state, hold)
            phases = range(PHASES) if number != 8 else (0, 5)
            found = branch([lambda p=p: play(b, state, act, p, number, limit) for p in phases])
            wrong = [v if ending != "done" else v[1] for ending, v in found if ending != "done" or v[1]]
            worst = max((v[0] for ending, v in found if ending == "done"), default=float("inf"))
            report.verdict(f"{name}, {state}: gate off", f"{len(found)} cases, worst {worst:.0f} us of {limit}{'; ' + wrong[0][-160:] if wrong else ''}",
                           not wrong and worst <= limit + FILTER)
    report.rules.update(b.chip.rules)
