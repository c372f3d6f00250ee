"""`powbench fmu` writes a unit that unzips and loads; `powbench field --out` writes tables for other simulators."""

import ctypes
import json
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
            library = ctypes.CDLL(str(self.place / f"c{fmi}" / binary[0]))
            version = getattr(library, f"fmi{fmi}GetVersion")
            version.restype = ctypes.c_char_p
            self.assertEqual(version().decode(), f"{fmi}.0")
            again = self.place / "again.fmu"
            fixture.program("fmu", "--fmi", fmi, "-o", again)
            self.assertEqual(zipfile.ZipFile(again).read("resources/contactor.txt"), zipfile.ZipFile(file).read("resources/contactor.txt"))
            self.assertTrue(root.get(token).startswith("{"))
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
