"""Boot, the serial line, and one whole shot."""

import math
import struct
import xml.etree.ElementTree as xml
import zlib

from bench import DAQ, Bench
from cpu import HERTZ
from world import World

CHANNELS = 8


def boot(image, report):
    b = Bench(image).boot(40)
    early = b.command("arm")
    report.verdict("boot: not armed before the zero is known", f"{early}, {b.ctl('last_error')}", early == -16)
    b.world.wait(90)
    chip = b.chip
    report.broken("boot: rules broken", b)
    cr2 = chip.pwr.r.get(4, 0)
    report.verdict("boot: supply monitor watches 2.9 V", f"PWR_CR2 {cr2:#x}", cr2 & 15 == 6 << 1 | 1)
    locks = chip.syscfg.r.get(0x1C, 0) & 15
    report.verdict("boot: break inputs locked", f"CFGR2 {locks:#x}", locks == 15)
    report.verdict("boot: gate low throughout", f"{len(chip.gate_edges)} edges", not chip.gate_edges)
    first = {c.triggers[0] - chip.tim1.origin for c in chip.adc}
    report.verdict("boot: first conversion at its tick", sorted(first), first == {1700})
    spacing = {b - a for c in chip.adc for a, b in zip(c.triggers, c.triggers[1:])}
    report.verdict("boot: conversions every 1700 ticks", sorted(spacing), spacing == {1700})
    state = b.state()
    report.verdict("boot: idle, no fault", state, state == ("idle", "0 none"))
    reset = b.ctl("last_reset")
    report.verdict("boot: last reset", reset, reset == "power_on")
    return b


def identity(b, report):
    """What tells one program, board and configuration from another."""
    crc = b.world.read(f"{DAQ} image_crc32")
    report.verdict("identity: checksum of the image", crc, int(crc, 16) == zlib.crc32(b.image.bytes))
    commit, board = b.world.read(f"{DAQ} fw_commit"), b.world.read(f"{DAQ} board_id")
    report.verdict("identity: commit and board", f"{commit}, {board}", len(commit) >= 7 and board == "0c0b0a090807060504030201")


def serial_line(b, report):
    version = b.world.ask("VERSION\r\n")
    report.verdict("line: VERSION", version.strip(), version.startswith("0.24."))
    b.world.received.clear()
    length = int(b.world.ask("PRINT\r\n", milliseconds=200).split("\n")[0])
    need = len(str(length)) + 1 + length + 1
    b.cpu.run(1 << 62, lambda: len(b.world.received) >= need, HERTZ)
    text = b.world.received.decode("latin-1").split("\n", 1)[1][:length]
    devices = [d.get("name") for d in xml.fromstring(text).iter("device")]
    report.verdict("line: PRINT is XML of its length", f"{length} B, {devices}",
                   devices == ["contactor-daq", "contactor-ctl", "fire"])
    answer = b.world.ask("READBUF iio:device0 100\r\n")
    report.verdict("line: READBUF without a buffer", answer.strip(), answer == "-9\n")
    b.command("hold_time_ms", "nan")
    report.verdict("line: not a number is refused", b.command("hold_time_ms", "nan"),
                   b.command("hold_time_ms", "nan") == -22)
    # a byte that the line has garbled: what was half received is forgotten, the next request is whole
    b.world.send("WRITE contactor-ctl fi")
    b.world.wait(1)
    b.chip.usart.receive(0x55, flags=2)
    b.world.wait(1)
    version = b.world.ask("VERSION\r\n")
    report.verdict("line: recovers from a framing error", version.strip(), version.startswith("0.24."))


def read_record(b):
    """The whole record of eight channels, as samples x channels."""
    assert b.world.ask(f"OPEN {DAQ} 1000 ff\r\n") == "0\n"
    length = int(b.world.read(f"{DAQ} record_length"))
    size = 2 * CHANNELS * length
    b.world.received.clear()
    b.world.send(f"READBUF {DAQ} {size}\r\n")
    head = len(f"{size}\n000000ff\n")
    b.cpu.run(1 << 62, lambda: len(b.world.received) >= head + size, 2 * HERTZ)
    data = bytes(b.world.received[head:head + size])
    b.world.ask(f"CLOSE {DAQ}\r\n")
    values = struct.unpack(f"<{CHANNELS * length}h", data)
    return data, [values[i:i + CHANNELS] for i in range(0, len(values), CHANNELS)]


def shot(b, report, degrees=37.0):
    chip = b.chip
    armed = b.arm(centi_degrees=round(degrees * 100))
    report.verdict("shot: armed", f"{armed}, {b.ctl('last_error')}", armed == 1 and b.ctl("state") == "armed")
    fired = b.fire()
    again = b.command("fire")
    report.verdict("shot: one arm gives one fire", f"{fired}, {again}", fired == 1 and again == -11)
    b.world.wait_for(lambda: len(chip.gate_edges) >= 2, 200)
    if len(chip.gate_edges) != 2:
        report.verdict("shot: gate on and off", chip.gate_edges, False)
        return
    (on, _), (off, _) = chip.gate_edges
    angle = b.world.phase_degrees(on)
    report.verdict("shot: closing angle", f"{angle:.3f} deg for {degrees}", abs(angle - degrees) < 0.01)
    report.verdict("shot: hold time", f"{(off - on) / HERTZ * 1e3:.4f} ms", abs(off - on - HERTZ // 20) <= 1)
    done = b.world.wait_for(lambda: b.ctl("state") == "captured", 100)
    report.verdict("shot: captured", b.state(), done)
    data, scans = read_record(b)
    crc = b.world.read(f"{DAQ} record_crc32")
    report.verdict("shot: checksum of the record", crc, int(crc, 16) == zlib.crc32(data))
    # the record's own mains at the gate edge, by least squares over one period behind it
    at = int(b.world.read(f"{DAQ} fire_sample"))
    offset = int(b.world.read(f"{DAQ} fire_offset_ns")) * 1e-9
    delay = mains_delay(b)
    found = record_angle(scans, at, offset - delay, b.world.hertz)
    report.verdict("shot: closing angle in the record", f"{found:.3f} deg", abs(found - degrees) < 0.05)
    report.broken("shot: rules broken", b)


# exception number -> name, most instructions a run in the mean, most in one
LEVELS = {16 + 15: ("samples", 2000, 2500), 14: ("control", 2000, 3000), 16 + 90: ("background", 4000, 25000),
          16 + 38: ("serial line", 1500, 3000)}


def levels(b, report):
    """Instructions of each interrupt level since the start, a shot and its record among them."""
    for number, (name, mean_limit, limit) in LEVELS.items():
        runs, total, worst = b.cpu.handlers.get(number, [0, 0, 0])
        mean = total / max(runs, 1)
        report.verdict(f"instructions: {name}", f"{mean:.0f} a run, worst {worst}, {runs} runs",
                       runs > 0 and mean <= mean_limit and worst <= limit)


def mains_delay(b):
    """s: how much later the mains channel shows its quantity, by the bench's own attribute."""
    b.world.received.clear()
    length = int(b.world.ask("PRINT\r\n", milliseconds=200).split("\n")[0])
    need = len(str(length)) + 1 + length + 1
    b.cpu.run(1 << 62, lambda: len(b.world.received) >= need, HERTZ)
    tree = xml.fromstring(b.world.received.decode("latin-1").split("\n", 1)[1][:length])
    for device in tree.iter("device"):
        for channel in device.iter("channel"):
            scan = channel.find("scan-element")
            if scan is not None and scan.get("index") == "5":
                return int(b.world.read(f"{DAQ} INPUT {channel.get('id')} delay_ns")) * 1e-9
    raise LookupError("no mains channel")


def record_angle(scans, edge, offset, hertz):
    """Phase of the mains at the gate edge, degrees; sample `edge` lies `offset` s behind it."""
    period = round(100_000 / hertz)
    s = c = 0.0
    for k in range(period):
        w = 2 * math.pi * hertz * (k / 100_000 + offset)
        s += scans[edge + k][5] * math.sin(w)
        c += scans[edge + k][5] * math.cos(w)
    return math.degrees(math.atan2(c, s)) % 360


def with_offsets(image, report):
    """Offsets as usual sensors have them: the bench starts, fires, and the record's zero is right."""
    for volts in (0.005, -0.020, 0.060):
        world = World()
        world.offset = {"coil_current": volts, "coil_voltage": -volts}
        b = Bench(image, world).boot(130)
        name = f"offset {1e3 * volts:+.0f} mV on current and voltage"
        report.verdict(f"{name}: starts without a fault", b.state(), b.state() == ("idle", "0 none"))
        offset = int(world.read(f"{DAQ} INPUT current0 offset"))
        counts = -volts / 3.3 * 65536
        report.verdict(f"{name}: captured", f"{offset}, true {counts:.0f}", abs(offset - counts) <= 4)
        b.energise(hold_ms=10)
        done = world.wait_for(lambda: b.ctl("state") == "captured", 200)
        report.verdict(f"{name}: shot", b.state(), done)

    world = World()
    world.offset = {"coil_current": 0.2}
    b = Bench(image, world).boot(130)
    answer = b.command("arm")
    report.verdict("offset +200 mV: not armed", f"{answer}, {b.ctl('last_error')}",
                   answer == -16 and b.ctl("last_error").startswith("offset of coil current"))
    world = World()
    world.shorted = world.relay_welded = True
    b = Bench(image, world).boot(130)
    report.verdict("current at rest after the start: fault", b.state(), b.state() == ("fault", "16 reset_while_energised"))
    b.command("abort")
    report.verdict("current at rest after the start: not armed", f"{b.command('arm')}, {b.ctl('fault')}",
                   b.state() == ("fault", "21 relay_welded"))
    world.shorted = world.relay_welded = False
    b.command("abort")
    b.command("zero_capture")
    world.wait(120)
    report.verdict("current ended: captured on command", b.ctl("zero_capture"), b.command("arm") == 1)


def run(image, report):
    b = boot(image, report)
    identity(b, report)
    serial_line(b, report)
    shot(b, report)
    levels(b, report)
    report.rules.update(b.chip.rules)
