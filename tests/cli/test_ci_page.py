"""The page docs/how-to/ci.md runs as written."""

import os
import re
import subprocess
import unittest
import xml.etree.ElementTree as ET

import fixture


class CiPageTest(unittest.TestCase):
    def setUp(self):
        page = (fixture.SOURCE / "docs" / "how-to" / "ci.md").read_text()
        self.plan = re.findall(r"^```toml\n(.*?)^```$", page, re.M | re.S)[0]
        self.job, self.keep_going = re.findall(r"^```sh\n(.*?)^```$", page, re.M | re.S)
        self.place = fixture.folder() / self.id()
        self.place.mkdir()
        (self.place / "bin").mkdir()
        (self.place / "bin" / "powbench").symlink_to(os.path.abspath(fixture.PROGRAM))

    def run_job(self, script: str, plan: str) -> int:
        (self.place / "ci.plan.toml").write_text(plan)
        path = f"{self.place}/bin:{os.environ['PATH']}"
        done = subprocess.run(["bash", "-e", "-c", script], cwd=self.place, env={**os.environ, "PATH": path}, check=False)
        return done.returncode

    def test_the_job_passes_and_leaves_its_results(self):
        self.assertEqual(self.run_job(self.job, self.plan), 0)
        results = ET.parse(self.place / "ci-report" / "junit.xml").getroot()
        self.assertGreater(len(list(results.iter("testcase"))), 8)
        self.assertEqual(len(list(results.iter("failure"))), 0)
        self.assertTrue((self.place / "ci-report" / "report.html").stat().st_size > 10_000)

    def test_a_bad_contactor_ends_the_job_with_1_and_has_a_report(self):
        strict = self.plan.replace("max_ms = 10\n", "max_ms = 0.1\n")
        self.assertNotEqual(strict, self.plan)
        self.assertEqual(self.run_job(self.keep_going, strict), 1)
        results = ET.parse(self.place / "ci-report" / "junit.xml").getroot()
        self.assertGreater(len(list(results.iter("failure"))), 0)
