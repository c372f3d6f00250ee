"""Resets and what is known of them afterwards: supply, watchdog, crashes, option bytes; and the gate through all of it."""

from bench import Bench, branch, booted
from chip import BOR
from cpu import HERTZ, US
from system import OPTR_BENCH, OPTR_DELIVERED


def acknowledged(b):
    """Fault until abort; then the bench arms again."""
    refused = b.command("arm")
    b.command("abort")
    return refused == -1 and b.ctl("state") == "idle"


def supply(image, report):
    """Sag while energised, and the three ways a supply comes back."""
    b = booted(image)
    b.energise(hold_ms=50)
    cause = b.chip.now
    b.chip.pwr.set_supply(2.85)
    b.run_us(300)
    report.verdict("supply 2.85 V: gate off", f"{b.off_after(cause):.2f} us", b.off_after(cause) <= 1.0)
    report.verdict("supply 2.85 V: fault", b.state(), b.state() == ("fault", "9 brown_out"))
    b.command("abort")
    report.verdict("supply 2.85 V: abort does not clear it", b.ctl("state"), b.ctl("state") == "fault")
    b.chip.pwr.set_supply(3.3)
    b.run_us(300)
    report.verdict("supply back: abort clears it", b.ctl("state"), acknowledged(b))

    def reset(ram, energised):
        case = booted(image)
        if energised:
            case.energise(hold_ms=50)
        edges = len(case.chip.gate_edges)
        case.chip.power_cycle(ram)
        case.world.wait(125)
        gate = case.chip.gate_edges[edges:]
        return case.ctl("last_reset"), case.ctl("fault"), gate, acknowledged(case) if case.ctl("fault") != "0 none" else True

    for ram, energised, cause, fault in ((True, False, "brown_out", "9 brown_out"),
                                         (True, True, "brown_out", "16 reset_while_energised"),
                                         (False, False, "power_on", "0 none"), (False, True, "power_on", "0 none")):
        (ending, found), = branch([lambda: reset(ram, energised)])
        name = f"reset by supply, RAM {'kept' if ram else 'lost'}, {'energised' if energised else 'idle'}"
        good = ending == "done" and found[0] == cause and found[1] == fault and found[3]
        good = good and all(level == 0 for _, level in found[2])
        report.verdict(name, found[:2] if ending == "done" else found, good)
    report.rules.update(b.chip.rules)


def options(image, report):
    for value, what in ((OPTR_DELIVERED, "as delivered"), (OPTR_BENCH | 1 << 24, "without parity check"),
                        (OPTR_BENCH & ~0x700 | 0x300, "brown-out level 3")):
        b = Bench(image, option_bytes=value).boot()
        answer = b.command("arm")
        text = b.ctl("last_error")
        report.verdict(f"option bytes {what}: not armed", f"{answer}, {text}",
                       answer == -1 and text.startswith("option bytes:") and b.ctl("state") == "idle")
        b.command("fire")
        b.world.wait(125)
        report.verdict(f"option bytes {what}: gate low", len(b.chip.gate_edges), not b.chip.gate_edges)


def crystal(image, report):
    b = Bench(image, crystal=False).boot(90)
    report.verdict("no crystal: not armed", b.state(), b.command("arm") == -1)
    report.broken("no crystal: rules broken", b)


def hang(image, report):
    """A level that never ends, energised: off at the end of the hold time at the latest, then the watchdog."""
    def case(report, function, fault="10 watchdog_reset"):
        b = booted(image)
        b.energise(hold_ms=20)
        on = b.chip.gate_edges[-1][0]
        address = b.hang(function)
        reset = b.world.wait_for(lambda: b.chip.resets, 130)
        off = [t for t, level in b.chip.gate_edges if not level]
        b.heal(address)
        report.verdict(f"{function} hangs: watchdog", b.chip.resets, reset and b.chip.resets[0][1] == "watchdog")
        late = (off[0] - on) / HERTZ * 1e3 if off else float("inf")
        report.verdict(f"{function} hangs: gate off at the end of the hold time", f"{late:.3f} ms of 20", late <= 20.02)
        b.world.wait(125)
        report.verdict(f"{function} hangs: known afterwards", (b.ctl("last_reset"), b.ctl("fault")),
                       b.ctl("last_reset") == "watchdog" and b.ctl("fault") == fault and acknowledged(b))
        report.rules.update(b.chip.rules)

    report.apart(*(lambda r, f=f: case(r, f) for f in ("samples_handler", "control_handler", "background_handler")))


def crash(image, report):
    """An instruction that is none, a wild access, and a stack that overflows: energised."""
    def udf(b, address):
        b.cpu.uc.mem_write(address, b"\x00\xde")
        b.cpu.uc.ctl_remove_cache(address, address + 2)

    def wild(b, address):
        b.cpu.uc.mem_write(address, b"\x4f\xf0\x60\x40\x01\x68")  # mov.w r0, #0xe0000000; ldr r1, [r0]
        b.cpu.uc.ctl_remove_cache(address, address + 6)

    def overflow(b, address):
        b.cpu.uc.mem_write(address, b"\x2d\xe9\xff\x5f\xfc\xe7")  # push {r0-r12, lr}; b .-4
        b.cpu.uc.ctl_remove_cache(address, address + 6)

    def case(report, name, act, word):
        b = booted(image)
        b.energise(hold_ms=50)
        address = image.symbols["control_handler"] & ~1
        b.world.wait(1)
        act(b, address)
        entry = []
        handler = image.symbols["fault_handler"] & ~1
        b.cpu.watch[handler] = lambda cpu: entry.append(cpu.now)
        found = b.world.wait_for(lambda: not b.chip.gate(), 5)
        off = b.chip.gate_edges[-1][0]
        reset = b.world.wait_for(lambda: b.chip.resets, 5)
        b.cpu.uc.mem_write(address, image.bytes[address - 0x0800_0000:address - 0x0800_0000 + 6])
        b.cpu.uc.ctl_remove_cache(address, address + 6)
        time = (off - entry[0]) / US if entry else float("inf")
        report.verdict(f"{name}: gate off behind the handler's entry", f"{time:.2f} us", found and reset and time < 1.0)
        b.world.wait(125)
        last = b.ctl("last_reset")
        report.verdict(f"{name}: known afterwards", f"{last}; {b.ctl('fault')}",
                       word in last and "software" in last and b.ctl("fault") == "11 crash_reset" and acknowledged(b))
        report.rules.update(b.chip.rules)

    report.apart(lambda r: case(r, "undefined instruction", udf, "usage_fault"), lambda r: case(r, "wild access", wild, "fault"),
                 lambda r: case(r, "stack overflow", overflow, "stack_overflow"))


def stop_clock(image, report):
    """The crystal stops while energised: break, NMI, restart."""
    b = booted(image)
    b.energise(hold_ms=50)
    cause = b.chip.now
    b.chip.rcc.crystal_stops()
    b.run_us(50)
    report.verdict("crystal stops: gate off", f"{b.off_after(cause):.2f} us", b.off_after(cause) <= 1.0)
    b.world.wait_for(lambda: b.chip.resets, 5)
    b.world.wait(125)
    report.verdict("crystal stops: known afterwards", b.ctl("last_reset"), "nmi" in b.ctl("last_reset"))
    report.rules.update(b.chip.rules)
