"""From a cause to the gate off: stop chain, abort, overcurrent, supply, clock, at every place around the edges."""

from bench import branch, booted
from cpu import HERTZ, US

LIMIT = 120.0  # us, faults.h: stop, overcurrent, lost samples, supply
BY_WIRE = 120.0  # us from the last byte


def edges(b):
    """Ticks of the on and off edge that come if nothing is done."""
    (ending, found), = branch([lambda: (b.wait_gate(1), b.wait_gate(0), b.chip.gate_edges)[2]])
    assert ending == "done" and len(found) == 2, found
    return found[0][0], found[1][0]


def worst(b, ticks, act, report):
    """act(b) at each of the ticks: longest time in us that the gate was on after it, and the place; late edges count too."""

    def case(tick):
        b.cpu.run(tick)
        act(b)
        cause = b.chip.now
        b.run_us(1500)
        on_until = [t for t, level in b.chip.gate_edges if not level and t > cause]
        time = (on_until[-1] - cause) / US if on_until else 0.0
        return float("inf") if b.chip.gate() else time, b.chip.rules

    found = branch([lambda t=t: case(t) for t in ticks])
    bad = [value for ending, value in found if ending != "done"]
    if bad:
        return float("inf"), bad[0].strip().splitlines()[-1]
    times = [value[0] for _, value in found]
    for _, value in found:
        report.rules.update(value[1])
    at = max(range(len(times)), key=times.__getitem__)
    return times[at], f"{len(times)} cases, worst {times[at]:.1f} us"


def causes():
    def stop(b):
        b.world.open_stop()

    def short_stop(b):
        """Opens for 20 us: shorter than a block."""
        b.world.open_stop()
        b.run_us(20)
        b.world.open_stop(False)

    def abort(b):
        b.world.send("WRITE contactor-ctl abort 1\r\n1")
        b.cpu.run(b.world.line_free)

    def supply(b):
        b.chip.pwr.set_supply(2.75)

    def current(b):
        b.world.force_current(1.95)

    def negative(b):
        b.world.force_current(-1.95)

    def clock(b):
        b.chip.rcc.crystal_stops()
    return (("stop chain opens", stop, LIMIT), ("stop chain opens for 20 us", short_stop, LIMIT),
            ("abort by wire", abort, BY_WIRE), ("supply falls", supply, 1.0), ("current +1.95 A", current, 1.0),
            ("current -1.95 A", negative, 1.0), ("crystal stops", clock, 1.0))


def run(image, report):
    b = booted(image)
    b.arm(hold_ms=4)
    b.fire()
    on, off = edges(b)
    # around the on edge, in the middle, and around the end, in steps that wander through the block of 100 us
    places = {"before the on edge": [on - round(k * 17.3 * US) for k in range(1, 19, 2)],
              "behind the on edge": [on + round((5 + k * 17.3) * US) for k in range(0, 10, 2)],
              "before the off edge": [off - round(k * 17.3 * US) for k in range(1, 28, 2)]}
    for name, act, limit in causes():
        for place, ticks in places.items():
            time, text = worst(b, ticks if limit > 1 else ticks[::4], act, report)
            report.verdict(f"{name} {place}: gate off", text, time <= limit)
    report.rules.update(b.chip.rules)


def lost_samples(image, report):
    """A converter whose results nobody fetches any more, a DMA channel that stands still: energised."""
    def stall(b):
        b.chip.adc[1].stalled = True

    def dead(b):
        b.chip.dma.dead.add(2)

    def case(report, name, act):
        b = booted(image)
        b.energise(hold_ms=20)
        b.world.wait(2)
        cause = b.chip.now
        act(b)
        b.run_us(400)
        time = b.off_after(cause)
        report.verdict(f"{name}: gate off", f"{time:.1f} us" if time is not None else "on", time is not None and time <= LIMIT)
        report.verdict(f"{name}: fault", b.ctl("fault"), b.ctl("fault") == "7 samples_lost")
        report.rules.update(b.chip.rules)

    report.apart(lambda r: case(r, "converter overrun", stall), lambda r: case(r, "DMA channel stands still", dead))


def abort_while_sending(image, report):
    """The description is 26 ms on the line, a record half a second: an abort in the middle of either."""
    def case(report, place, request):
        b = booted(image)
        if request:
            b.energise(hold_ms=100)
        else:
            b.energise(hold_ms=4)
            b.world.wait_for(lambda: b.ctl("state") == "captured", 100)
            b.world.ask("OPEN contactor-daq 1000 ff\r\n")
            request = "READBUF contactor-daq 97600\r\n"
        b.world.received.clear()
        b.world.send(request)
        b.world.wait(8)
        begun = len(b.world.received)
        b.world.send("WRITE contactor-ctl abort 1\r\n1")
        b.cpu.run(b.world.line_free)
        cause = b.chip.now
        done = []
        b.cpu.watch[b.image.symbols["powbench::firmware::FireControl::stop()"] & ~1] = lambda cpu: done.append(cpu.now)
        b.world.wait(2)
        time = (done[0] - cause) / US if done else float("inf")
        report.verdict(f"abort while the {place} is sent: heard", f"{time:.1f} us, {begun} B before it",
                       begun > 100 and time <= BY_WIRE)
        if place == "description":
            time = b.off_after(cause)
            report.verdict("abort while the description is sent: gate off", time, time is not None and time <= BY_WIRE)

    report.apart(lambda r: case(r, "description", "PRINT\r\n"), lambda r: case(r, "record", None))
