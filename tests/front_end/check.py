"""Analogue stages in ngspice against what the firmware assumes: check.py. Ends with `N passed, N failed`.

Gains and delays are read from firmware/port/stm32g474/front_end.h. Without ngspice (Debian: ngspice) it says so and ends with
nothing passed.
"""

import cmath
import math
import pathlib
import re
import shutil
import subprocess
import sys
import tempfile

HERE = pathlib.Path(__file__).resolve().parent
HEADER = HERE.parents[1] / "firmware/port/stm32g474/front_end.h"
STAGES = ("force", "current", "voltage", "pole", "laser", "snubber")


def assumed():
    text = HEADER.read_text()
    found = {name: float(value) for name, value in re.findall(r"(\w+) = (-?[\d.]+(?:e-?\d+)?)[,;]", text)}
    return found | {"force_gain": found["film_coulomb_per_newton"] / found["feedback_farad"],
                    "force_corner": 1 / (2 * math.pi * found["feedback_farad"] * found["feedback_ohm"])}


def simulate(folder, netlist):
    subprocess.run(["ngspice", "-b", str(HERE / netlist)], cwd=folder, check=True, capture_output=True, timeout=60)
    lines = (pathlib.Path(folder) / netlist.replace(".cir", ".out")).read_text().splitlines()
    return [[float(x) for x in line.split()] for line in lines]


class Sweep:
    def __init__(self, rows):
        self.hertz = [r[0] for r in rows]
        self.values = {name: [complex(r[3 * i + 1], r[3 * i + 2]) for r in rows] for i, name in enumerate(STAGES)}

    def at(self, name, hertz):
        return self.values[name][min(range(len(self.hertz)), key=lambda i: abs(self.hertz[i] - hertz))]

    def delay(self, name, hertz):
        """-d(phase) / d(omega) around a frequency, s."""
        i = min(range(len(self.hertz)), key=lambda k: abs(self.hertz[k] - hertz))
        a, b = self.values[name][i - 5], self.values[name][i + 5]
        return -cmath.phase(b / a) / (2 * math.pi * (self.hertz[i + 5] - self.hertz[i - 5]))


def main():
    if shutil.which("ngspice") is None:
        print("ngspice is not here: nothing checked\n0 passed, 0 failed")
        return 0
    told, results = assumed(), []

    def verdict(name, value, wanted, tolerance, unit):
        good = abs(value - wanted) <= tolerance
        results.append(good)
        print(f"{'ok     ' if good else 'FAILED '} {name:44} {value:.5g} {unit}, assumed {wanted:.5g} +- {tolerance:.2g}")

    with tempfile.TemporaryDirectory() as folder:
        sweep = Sweep(simulate(folder, "stages.cir"))
        pump = simulate(folder, "pump.cir")
    for name, key in (("force", "force_gain"), ("current", "volts_per_ampere"), ("voltage", "volts_per_volt"),
                      ("pole", "volts_per_contact")):
        # nominal values: what is left is the calibration's, which takes 10 %
        verdict(f"{name}: gain at 1 kHz", abs(sweep.at(name, 1000)), told[key], 0.015 * told[key], "V")
        # 0.15 us are 0.003 degrees at 50 Hz, and 1.5 % of a sample
        verdict(f"{name}: delay at 1 kHz", 1e6 * sweep.delay(name, 1000), 1e6 * told["filter_delay"], 0.15, "us")
        verdict(f"{name}: delay at 5 kHz", 1e6 * sweep.delay(name, 5000), 1e6 * told["filter_delay"], 0.25, "us")
    verdict("laser: share of the sensor's 10 V at 1 kHz", abs(sweep.at("laser", 1000)), 0.3, 0.003, "")
    flat = abs(sweep.at("force", 100))
    corner = next(f for f, v in zip(sweep.hertz, sweep.values["force"]) if abs(v) > flat / math.sqrt(2))
    verdict("force: low corner", corner, told["force_corner"], 0.01, "Hz")
    # an image of the converter's noise band: a burst's mean has its first zero at 1 / 7.15 us
    verdict("force: gain at 140 kHz, of that at 1 kHz", abs(sweep.at("force", 140e3)) / flat, 0.0, 0.06, "")
    verdict("snubber: current at 50 Hz, limit 6 mA", 1e3 * abs(sweep.at("snubber", 50)), 0.0, 6.0, "mA")
    running = [r[1] for r in pump if 0.030 < r[0] < 0.0399]
    verdict("pump: lowest gate voltage while it runs", min(running), 2.6, 0.5, "V")
    # the transistor is off below 0.8 V
    off = next(r[0] for r in pump if r[0] > 0.040 and r[1] < 0.8)
    verdict("pump: off after the last edge", 1e3 * (off - 0.040), 5.0, 5.0, "ms")
    passed = sum(results)
    print(f"{passed} passed, {len(results) - passed} failed")
    return int(passed != len(results))


if __name__ == "__main__":
    sys.exit(main())
