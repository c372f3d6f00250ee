"""`powbench fmu` writes a unit that unzips and loads; `powbench field --out` writes tables for other simulators."""

import csv
import ctypes
import json
import shutil
import subprocess
import unittest
import xml.etree.ElementTree as ET
import zipfile

import fixture


class UnitTest(unittest.TestCase):
    def setUp(self):
        self.place = fixture.folder() / self.id()
        self.place.mkdir()

    def test_the_unit_has_what_the_standard_asks_for_and_loads(self):
        for fmi, token, folder in ((2, "guid", "linux64"), (3, "instantiationToken", "x86_64-linux")):
            file = self.place / f"c{fmi}.fmu"
            said = json.loads(
                fixture.program("fmu", fixture.SOURCE / "scenes" / "reference.specimen.toml", "--fmi", fmi, "-o", file, "--json")
            )
            self.assertEqual(said["bytes"], file.stat().st_size)
            with zipfile.ZipFile(file) as unit:
                self.assertIsNone(unit.testzip())
                names = unit.namelist()
                self.assertEqual(names[0], "modelDescription.xml")
                root = ET.fromstring(unit.read(names[0]))
                self.assertIn("resources/contactor.txt", names)
                self.assertIn("magnet", unit.read("resources/specimen.toml").decode())
                unit.extractall(self.place / f"c{fmi}")
            self.assertEqual(root.get("fmiVersion"), f"{fmi}.0")
            variables = list(root.find("ModelVariables"))
            self.assertEqual(said["outputs"], sum(v.get("causality") == "output" for v in variables))
            binary = [n for n in names if n.startswith("binaries/")]
            if len(binary) == 1 and folder in binary[0]:  # this machine's
                self.assertEqual(binary[0], f"binaries/{folder}/{root.find('CoSimulation').get('modelIdentifier')}.so")
            again = self.place / "again.fmu"
            fixture.program("fmu", "--fmi", fmi, "-o", again)
            with zipfile.ZipFile(again) as second:
                self.assertEqual(second.read("resources/contactor.txt"), (self.place / f"c{fmi}/resources/contactor.txt").read_bytes())
            self.assertTrue(root.get(token).startswith("{"))
            if b"__asan_init" in (self.place / f"c{fmi}" / binary[0]).read_bytes():
                continue  # loads only into a program that has the sanitizer
            library = ctypes.CDLL(str(self.place / f"c{fmi}" / binary[0]))
            version = getattr(library, f"fmi{fmi}GetVersion")
            version.restype = ctypes.c_char_p
            self.assertEqual(version().decode(), f"{fmi}.0")
        said = fixture.program("fmu", "-o", self.place / "none" / "x.fmu", code=2)
        self.assertIn("cannot be written", said)
        self.assertIn("--fmi", fixture.program("fmu", "--fmi", 1, code=2))
        self.assertIn("no.toml", fixture.program("fmu", "no.toml", code=2))

    def test_tables_for_other_simulators(self):
        files = [self.place / f"table.{ending}" for ending in ("csv", "mat", "txt")]
        out = [word for f in files for word in ("--out", f)]
        said = json.loads(fixture.program("field", "-o", self.place, "--accuracy", "5%", *out, "--json"))
        self.assertEqual(said["tables"], [str(f) for f in files])
        rows = files[0].read_text().splitlines()
        self.assertEqual(len(rows), 1 + 81 * 61)
        last = [float(v) for v in rows[-1].split(",")]
        self.assertGreater(last[3], 0)
        self.assertTrue(files[1].read_bytes().startswith(b"MATLAB 5.0"))
        self.assertIn("double force(82,62)", files[2].read_text())
        for words, key in (
            (("--out", "x.xml"), "x.xml"),
            (("--out", "x.csv", "--ring"), "--ring"),
            (("--out", "x.csv", "--mesh", "y.msh"), "--mesh"),
        ):
            self.assertIn(key, fixture.program("field", "-o", self.place, *words, code=2))

    @unittest.skipUnless(shutil.which("fmusim"), "fmusim of the Reference FMUs is not in the path")
    def test_the_importers_of_the_reference_fmus_run_it(self):
        times = {}
        for name, fmi, words in (
            ("cs", 2, ("--interface-type", "cs")),
            ("me", 2, ("--interface-type", "me", "--solver", "cvode", "--tolerance", "1e-8")),
            ("events", 3, ("--event-mode-used", "--early-return-allowed")),
            ("whole steps", 3, ()),
        ):
            unit = self.place / f"{fmi}.fmu"
            fixture.program("fmu", "--fmi", fmi, "-o", unit)
            for step in ("1e-6", "1e-5", "137e-6", "1e-3"):
                out = self.place / "out.csv"
                words_of_all = ("--start-value", "source.volts", "230", "--start-value", "source.phase", "1", "--stop-time", "0.03")
                columns = ("--output-variable", "pole[1].touch_time", "--output-variable", "seat_time")
                subprocess.run(
                    ["fmusim", *words, *words_of_all, "--output-interval", step, *columns, "--output-file", out, unit],
                    check=True,
                    capture_output=True,
                    timeout=120,
                )
                last = list(csv.DictReader(out.read_text().splitlines()))[-1]
                times[name, step] = [float(last["pole[1].touch_time"]), float(last["seat_time"])]
        for key, found in times.items():
            for value, wanted in zip(found, times["cs", "1e-3"]):
                self.assertGreater(value, 0, key)
                self.assertLess(abs(value - wanted), 1e-6, key)
