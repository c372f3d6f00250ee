"""A solenoid from its file to a closing, as docs/how-to/solenoid.md does it."""

import json
import unittest

from fixture import SOURCE, folder, program

SCENE = str(SOURCE / "scenes" / "solenoid.specimen.toml")


class SolenoidTest(unittest.TestCase):
    def test_the_published_pull_in_within_its_bound(self):
        out = folder() / "closing"
        words = ("sim", SCENE, "--volts", "12", "--cache", str(out), "--accuracy", "1%", "--json")
        run = json.loads(program(*words, "--hold", "40", "-o", str(folder() / "closing.csv")))
        self.assertAlmostEqual(run["pull_in_s"] * 1e3, 12.6134, delta=0.015 * 12.6134)
        self.assertLess(run["dip_current_A"], run["peak_current_A"])
        self.assertLess(run["energy_residual"], 1e-5)
        lines = (folder() / "closing.csv").read_text().splitlines()
        self.assertGreater(len(lines), 1000)
        self.assertTrue(lines[0].startswith("time [s],"))
        program(*words, "-o", str(folder() / "closing.svg"))
        self.assertIn("<svg", (folder() / "closing.svg").read_text())

    def test_describe_and_template(self):
        facts = json.loads(program("specimen", "describe", SCENE, "--volts", "12", "--json"))
        self.assertAlmostEqual(facts["current_A"], 1.2)
        self.assertGreater(facts["places"][-1]["pull_N"], 10 * facts["places"][0]["pull_N"])
        own = folder() / "own.specimen.toml"
        own.write_text(program("plan", "template", "solenoid"))
        self.assertIn("W at 24 V", program("specimen", "describe", str(own)))
        self.assertIn("not close", program("sim", str(own), "--volts", "3", "--cache", str(folder() / "own"), "--accuracy", "5%"))

    def test_what_does_not_apply_is_refused_with_a_word(self):
        self.assertIn("no contacts", program("sim", SCENE, "--mechanics", "rigid", code=2))
        self.assertIn("--fields = circuit", program("sim", SCENE, "--fields", "circuit", code=2))
        self.assertIn("conductivity_S_per_m", program("sim", SCENE, "--fields", "eddy", code=2))
        self.assertIn("powbench sim", program("ladder", SCENE, code=2))
        plan = SOURCE / "scenes" / "demo.plan.toml"
        self.assertIn("conditions of a contactor", program("sim", plan, "--volts", "24", code=2))


if __name__ == "__main__":
    unittest.main()
