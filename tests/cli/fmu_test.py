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
