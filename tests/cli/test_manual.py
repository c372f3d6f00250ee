"""Help, manual pages, completion and reference say the same: that of the command tree."""

import os
import re
import shutil
import subprocess
import unittest

from fixture import SOURCE, folder, program


def verbs_of(help_text: str) -> list[str]:
    """Names under `Subcommands:` of a help text."""
    part = help_text.split("Subcommands:\n", 1)
    return re.findall(r"^  ([a-z]+)", part[1], re.M) if len(part) == 2 else []


def all_verbs() -> list[str]:
    top = verbs_of(program("--help"))
    deep = [f"{v} {w}" for v in top for w in verbs_of(program(v, "--help"))]
    return top + deep


class ManualTest(unittest.TestCase):
    @classmethod
    def setUpClass(cls):
        cls.out = folder() / "manual"
        program("manual", "-o", cls.out)
        cls.verbs = all_verbs()

    def page(self, verb: str) -> str:
        return (self.out / "man" / ("powbench-" + verb.replace(" ", "-") + ".1")).read_text().replace("\\-", "-")

    def test_every_verb_and_option_of_the_help_is_in_all_of_them(self):
        self.assertGreater(len(self.verbs), 20)
        self.assertNotIn("manual", self.verbs)  # hidden
        completion = (self.out / "completions" / "powbench").read_text()
        reference = (self.out / "reference" / "commands.md").read_text()
        options = 0
        for verb in self.verbs:
            text, page = program(*verb.split(), "--help"), self.page(verb)
            self.assertIn(f"## powbench {verb}\n", reference)
            self.assertIn(f"'{verb}'", completion)
            words = re.search(rf"'{verb}'\) words='([^']*)'", completion).group(1).split()
            for option in re.findall(r"^  (?:-\w,)?(--[a-z-]+)", text, re.M):
                options += 1
                self.assertIn(option, page, verb)
                self.assertIn(option, words, verb)
                self.assertIn(f"{option}", reference)
        self.assertGreater(options, 100)
        pages = {p.name for p in (self.out / "man").iterdir()}
        self.assertEqual(len(pages), len(self.verbs) + 1)

    def test_what_an_option_means_stands_in_page_and_help_alike(self):
        squeezed = " ".join(program("run", "--help").split())
        self.assertIn("shots without a record in a row before stopping", squeezed)
        self.assertIn("shots without a record in a row before stopping (default: 5)", self.page("run"))

    def test_bash_completes(self):
        def complete(*words):
            script = (
                f"source {self.out}/completions/powbench; COMP_WORDS=({' '.join(words)} ''); "
                "COMP_CWORD=$((${#COMP_WORDS[@]} - 1)); _powbench; printf '%s\\n' \"${COMPREPLY[@]}\""
            )
            return subprocess.run(["bash", "-c", script], capture_output=True, text=True, check=True).stdout.split()

        self.assertIn("run", complete("powbench"))
        self.assertEqual(complete("powbench", "plan")[:3], ["check", "show", "template"])
        self.assertIn("--resume", complete("powbench", "run", "x.plan.toml"))
        self.assertEqual(complete("powbench", "run", "--progress"), ["auto", "bar", "lines", "none"])

    def test_the_pages_are_clean_roff(self):
        tool = shutil.which("groff")
        if tool is None:
            self.skipTest("no groff")
        for page in sorted((self.out / "man").iterdir()):
            done = subprocess.run([tool, "-man", "-Tutf8", "-ww", "-z", page], capture_output=True, text=True, check=False)
            self.assertEqual((done.returncode, done.stderr), (0, ""), page.name)

    def test_the_reference_of_files_holds_every_key(self):
        text = (self.out / "reference" / "files.md").read_text()
        for kind in ("plan", "rig", "specimen", "calibration"):
            self.assertIn(program("plan", "template", kind).strip(), text)


class HelpTest(unittest.TestCase):
    def test_help_verb_is_verb_help(self):
        for verb in (["run"], ["plan", "check"], []):
            self.assertEqual(program("help", *verb), program(*verb, "--help"))

    def test_wrong_verbs_are_met_with_what_was_meant(self):
        for words, meant in [
            (["help", "acquire"], "did you mean 'powbench run'?"),
            (["help", "reprot"], "did you mean 'powbench report'?"),
            (["help", "plan", "chekc"], "did you mean 'powbench plan check'?"),
            (["browser"], "did you mean 'powbench serve'?"),
            (["man"], "did you mean 'powbench help'?"),
            (["fire"], "did you mean 'powbench run'?"),
        ]:
            self.assertIn(meant, program(*words, code=2))

    def test_the_version_names_the_commit(self):
        said = program("--version").strip()
        self.assertRegex(said, r"^powbench \d+\.\d+\.\d+, commit ([0-9a-f]{12,}(-dirty-[0-9a-f]{12})?|not known)$")
        if os.path.exists(SOURCE / ".git"):
            done = subprocess.run(
                ["git", "-c", "safe.directory=*", "log", "--format=%H"], cwd=SOURCE, capture_output=True, text=True, check=True
            )
            commit = said.split("commit ")[1].split("-dirty")[0]
            self.assertTrue(any(h.startswith(commit) for h in done.stdout.split()), said)


class RunTest(unittest.TestCase):
    def test_failures_are_summed_by_limit(self):
        plan = folder() / "strict.plan.toml"
        plan.write_text(
            'name = "strict"\nangles_deg = [30, 60]\nrepeats = 4\n[limits.t_ct1]\nmax_ms = 1\n[limits.t_xt1]\nmax_ms = 100\n'
        )
        said = program("run", plan, "--rig", "sim:", "--db", folder() / "strict.db", "--progress", "none", code=1)
        self.assertRegex(said, r"t_ct1, allowed ≤ 1 ms: 8 FAIL, furthest 1[0-9.]+ ms at (30|60) deg")
        self.assertNotIn("t_xt1", said)
        named = [line for line in said.splitlines() if line.startswith("shot ")]
        self.assertEqual(len(named), 5)
        self.assertEqual(said.count("more shots outside limits are summed at the end"), 1)

    def test_the_demo_ends_in_three_sentences(self):
        done = subprocess.run(
            [__import__("fixture").PROGRAM, "demo", "-o", folder() / "demo", "--progress", "none"],
            capture_output=True, text=True, check=True,
        )
        last = done.stderr.splitlines()[-3:]
        self.assertEqual(last[0], "Verdict PASS: 21 of 21 closings are within the limits of the plan.")
        self.assertRegex(last[1], r"^Best closing angle \d+ deg of 7 measured: it bounces for \d\.\d\d ms")
        self.assertEqual(last[2], f"Open {folder() / 'demo'}/report.html in a browser: every closing beside its simulation.")
