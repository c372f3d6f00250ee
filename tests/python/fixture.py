"""What the tests share: the program, the sources, and one small campaign on the simulated rig."""

import functools
import json
import pathlib
import subprocess
import tempfile

PROGRAM = ""
SOURCE = pathlib.Path()

PLAN = """name = "two angles"
specimen = "{source}/scenes/reference.specimen.toml"
angles_deg = [30, 120]
repeats = 2
seed = 7
"""


def program(*words: object, code: int = 0) -> str:
    """Standard output of `powbench WORDS`; with another expected exit code its standard error."""
    done = subprocess.run([PROGRAM, *map(str, words)], capture_output=True, text=True, check=False)
    if done.returncode != code:
        raise AssertionError(f"powbench {words} ended with {done.returncode}, not {code}:\n{done.stderr}")
    return done.stdout if code == 0 else done.stderr


def program_json(*words: object):
    return json.loads(program(*words, "--json"))


@functools.lru_cache(maxsize=None)
def folder() -> pathlib.Path:
    kept.append(tempfile.TemporaryDirectory(prefix="powbench-python-"))
    return pathlib.Path(kept[-1].name)


kept: list = []


@functools.lru_cache(maxsize=None)
def campaign() -> tuple:
    """(store, what Rig.run returned): fired from Python, simulated by the command line."""
    import powbench

    plan, store = folder() / "two.plan.toml", folder() / "two.db"
    plan.write_text(PLAN.format(source=SOURCE))
    with powbench.Rig("sim:") as rig:
        summary = rig.run(plan, store)
    program("sim", plan, "--db", store, "--progress", "none")
    return store, summary
