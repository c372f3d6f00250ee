"""The commit that the build writes down tells any two states of the sources apart."""

import pathlib
import re
import subprocess
import tempfile
import unittest

from fixture import SOURCE


def git(at: pathlib.Path, *words: str) -> None:
    who = ["-c", "user.name=test", "-c", "user.email=test@localhost", "-c", "commit.gpgsign=false"]
    subprocess.run(["git", "-C", at, *who, *words], check=True, capture_output=True)


class CommitTest(unittest.TestCase):
    def setUp(self):
        kept = tempfile.TemporaryDirectory(prefix="powbench-commit-")
        self.addCleanup(kept.cleanup)
        self.sources = pathlib.Path(kept.name) / "sources"
        self.sources.mkdir()

    def commit(self) -> str:
        file = self.sources.parent / "commit.cpp"
        script = SOURCE / "cmake" / "commit.cmake"
        subprocess.run(["cmake", f"-DSOURCE={self.sources}", f"-DFILE={file}", "-P", script], check=True)
        return re.search(r'program_commit = "(.*)"', file.read_text())[1]

    def test_two_states_of_the_sources_have_two_names(self):
        (self.sources / "a.txt").write_text("1")
        git(self.sources, "init", "-q")
        git(self.sources, "add", ".")
        git(self.sources, "commit", "-qm", "first")
        first = self.commit()
        self.assertRegex(first, "^[0-9a-f]{12}$")
        (self.sources / "a.txt").write_text("2")
        second = self.commit()
        (self.sources / "a.txt").write_text("3")
        third = self.commit()
        self.assertEqual(len({first, second, third}), 3)
        for changed in (second, third):
            self.assertTrue(changed.startswith(first + "-dirty-"), changed)
        (self.sources / "a.txt").write_text("1")
        self.assertEqual(self.commit(), first)

    def test_sources_without_git_are_named_by_their_file(self):
        self.assertEqual(self.commit(), "not known")
        (self.sources / ".commit").write_text("0123456789ab\n")
        self.assertEqual(self.commit(), "0123456789ab")
