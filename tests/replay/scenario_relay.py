"""The safety relay and the coil's switch, proven by each shot: what does not follow is found before the edge, or behind the shot."""

from bench import booted


def armed_then(image, report, name, fault, **broken):
    """Broken while idle, then armed and fired: no edge, its own fault, the pump stopped."""
    b = booted(image)
    for what, value in broken.items():
        setattr(b.world, what, value)
    b.world.wait(5)
    report.verdict(f"{name}: nothing flows while idle", b.state(), b.state() == ("idle", "0 none"))
    b.command("arm")
    b.fire()
    b.world.wait_for(lambda: b.ctl("state") == "fault", 150)
    report.verdict(f"{name}: fault", b.state(), b.state() == ("fault", fault))
    report.verdict(f"{name}: no edge", f"{len(b.chip.gate_edges)} edges", not b.chip.gate_edges)
    b.world.wait(30)
    report.verdict(f"{name}: no current is left", b.world.coil_on(b.now()), not b.world.coil_on(b.now()))
    report.rules.update(b.chip.rules)


def relay_stays(image, report):
    b = booted(image)
    b.energise(hold_ms=10)
    b.world.relay_welded = True
    done = b.world.wait_for(lambda: b.ctl("state") == "captured", 200)
    report.verdict("relay does not open: the shot is whole", b.state(), done)
    b.world.wait(110)
    report.verdict("relay does not open: fault behind the shot", b.state(), b.state() == ("fault", "21 relay_welded"))
    b.command("abort")
    report.verdict("relay does not open: not acknowledged", b.command("arm"), b.ctl("state") == "fault")
    b.world.relay_welded = False
    b.world.wait(20)
    b.command("abort")
    report.verdict("relay opens again: acknowledged", b.state(), b.state() == ("idle", "0 none"))
    report.rules.update(b.chip.rules)


def switch_stays(image, report):
    b = booted(image)
    b.energise(hold_ms=10)
    b.world.shorted = True
    b.world.wait_for(lambda: b.ctl("state") == "fault", 100)
    report.verdict("switch does not open: fault behind the shot", b.state(), b.state() == ("fault", "4 coil_stuck_on"))
    b.world.wait(30)
    report.verdict("switch does not open: the relay ends the current", b.world.coil_on(b.now()), not b.world.coil_on(b.now()))
    report.rules.update(b.chip.rules)


def run(image, report):
    report.apart(lambda r: armed_then(image, r, "switch shorted", "4 coil_stuck_on", shorted=True),
                 lambda r: armed_then(image, r, "relay does not close", "22 relay_open", relay_dead=True),
                 lambda r: relay_stays(image, r), lambda r: switch_stays(image, r))
