#!/usr/bin/env python3
"""Mutants of the firmware's safety code: run.py BUILD [NUMBER...]. BUILD is a release build with test_firmware built.

Each mutant changes one token of fire control, interlocks, recorder or gate; the file is compiled alone, linked into a copy of
test_firmware, and the copy run. A mutant that no test notices is a survivor. Three are known, each a second lock behind a first
one: the permit's config_intact (a damaged configuration has tripped by then), quiet_samples (shorter than the quarter of the
stuck-on time that the coil has to be quiet anyway), the one-shot token (fire has left `armed` by then). The sources are not touched. Not part of
continuous integration: a mutant takes some 20 s.
"""

import json
import shlex
import subprocess
import sys
import tempfile
from pathlib import Path

ROOT = Path(__file__).resolve().parents[2]

# file, text (found exactly once, or at the occurrence given), what takes its place
MUTANTS = [
    ("interlocks.cpp", "over_ >= 2", "over_ >= 3"),
    ("fire_step.cpp", "was_energised_ = was_energised_ || edge.on", "was_energised_ = edge.on"),
    ("interlocks.cpp", "since > c.stuck_on_samples && flows", "since > 4 * c.stuck_on_samples && flows"),
    ("recorder.cpp", "end = first + gaps_[g].count", "end = first + gaps_[g].count - 1"),
    ("interlocks.cpp", "over_ + 1 : 0", "over_ + 1 : 1"),
    ("interlocks.cpp", "- zero) > c.overcurrent_counts ? over_", "- zero) >= c.overcurrent_counts ? over_"),
    ("interlocks.cpp", "magnitude(v - zero) > c.no_current_counts", "magnitude(v) > c.no_current_counts"),
    ("interlocks.cpp", "i -= 2)", "i -= 3)"),
    ("interlocks.cpp", "last_current_ > c.stuck_on_samples / 2) current_since_", "last_current_ > c.stuck_on_samples / 4) current_since_"),
    ("interlocks.cpp", "last_current_ - current_since_ >= c.stuck_on_samples", "last_current_ - current_since_ >= 0"),
    ("interlocks.cpp", "silent(last_current_) > c.no_current_samples", "silent(last_current_) > 2 * c.no_current_samples"),
    ("interlocks.cpp", "silent(last_host_) > c.heartbeat_samples", "silent(last_host_) > 2 * c.heartbeat_samples"),
    ("interlocks.cpp", "since > c.weld_samples && present", "since > 2 * c.weld_samples && present"),
    ("interlocks.cpp", "&& coil_quiet(now))", ")"),
    ("interlocks.cpp", "jump || skipped || stale", "jump || stale"),
    ("interlocks.cpp", "skipped || stale || stuck", "skipped || stuck"),
    ("interlocks.cpp", "stale || stuck || block.overrun", "stale || block.overrun"),
    ("interlocks.cpp", "stuck || block.overrun", "stuck"),
    ("interlocks.cpp", "block.counter != counter_ + 1", "block.counter < counter_ + 1"),
    ("interlocks.cpp", "next_sample_ - last_mains_ > config_->mains_lost_samples", "next_sample_ - last_mains_ > 2 * config_->mains_lost_samples"),
    ("interlocks.cpp", "magnitude(v) > c.mains_lost_counts", "v > c.mains_lost_counts"),
    ("interlocks.cpp", "v >= c.travel_least_counts && v", "v"),
    ("interlocks.cpp", "&& v <= c.travel_most_counts", ""),
    ("interlocks.cpp", "v > c.contact_open_counts; };", "v >= c.contact_open_counts; };"),
    ("interlocks.cpp", "travel > c.travel_closed_counts", "travel > 2 * c.travel_closed_counts"),
    ("interlocks.cpp", "travel < c.travel_open_counts", "travel < 0"),
    ("interlocks.cpp", "laser_good_ > c.implausible_samples", "laser_good_ > 2 * c.implausible_samples"),
    ("interlocks.cpp", "contact_good_ > c.implausible_samples", "contact_good_ > 2 * c.implausible_samples"),
    ("interlocks.cpp", "if (brown_out_) return Fault::brown_out;", ""),
    ("interlocks.cpp", "if (emergency_stop_) return Fault::emergency_stop;", ""),
    ("interlocks.cpp", "if (!gate.on && (marks_ & implausible) != 0)", "if ((marks_ & implausible) != 0)"),
    ("interlocks.cpp", "if (relay_in_ == gate.relay) {", "if (relay_in_ || relay_in_ == gate.relay) {"),
    ("fire_step.cpp", "gate_.off_at().sample < block.first_sample", "gate_.off_at().sample < block.first_sample - 100"),
    ("fire_step.cpp", "if (first_block_ && !interlocks_->coil_quiet(end))", "if (false && !interlocks_->coil_quiet(end))"),
    ("fire_step.cpp", "found == Fault::sensor_implausible && committed", "found == Fault::sensor_implausible"),
    ("fire_step.cpp", "age > config_->phase_age_samples", "age > 2 * config_->phase_age_samples"),
    ("fire_step.cpp", "end - fired_at_ > config_->phase_timeout_samples) trip", "end - fired_at_ > 3 * config_->phase_timeout_samples) trip"),
    ("fire_step.cpp", "if (plan_.sample < now) {", "if (plan_.sample < now - 40) {"),
    ("fire_step.cpp", "++deadlines_missed_;", ""),
    ("fire_step.cpp", "end + block.late + config_->lead_samples", "end + config_->lead_samples"),
    ("fire_step.cpp", "const std::int64_t lead = lead_samples_256();", "const std::int64_t lead = 0;"),
    ("fire_step.cpp", "lead_whole + (sub < 0 ? -1 : 0)", "lead_whole"),
    ("fire_step.cpp", "if (!angle_known()) return wait_for_phase(end);", ""),
    ("fire_step.cpp", ".config_intact = !config_damaged_", ".config_intact = true"),
    ("fire_step.cpp", "end - gate_since_ > config_->quiet_samples", "end - gate_since_ > 0"),
    ("fire_step.cpp", "budget_.note_operation(plan_.sample);", ""),
    ("fire_control.cpp", "if (state_ != State::armed || !token_)", "if (state_ != State::armed)"),
    ("fire_control.cpp", "if (!boot_.unfit.empty())", "if (false)"),
    ("fire_control.cpp", "if (!unready_.empty())", "if (false)"),
    ("fire_control.cpp", "if (interlocks_->emergency_stop())", "if (false)"),
    ("fire_control.cpp", "interlocks_->reset(next_sample_);", ""),
    ("fire_control.cpp", "centi_degrees >= full_turn_centi", "centi_degrees > full_turn_centi"),
    ("fire_control.cpp", "ms > config_->hold_limit_ms", "ms > 2 * config_->hold_limit_ms"),
    ("fire_step.cpp", "if (!interlocks_->switch_proven(end)) {", "if (false) {"),
    ("fire_control.cpp", "return was_energised_ && !over", "return !over"),
    ("gate.h", "permit.hold_samples > permit.hold_limit", "false"),
    ("gate.h", "if (on_ || pending_on_) return false;", ""),
    ("gate.h", "off_at_ = {at.sample + permit.hold_samples, at.fraction};", "off_at_ = {at.sample + permit.hold_samples + 1, at.fraction};"),
    ("recorder.cpp", "if (end > length_) end = length_;", ""),
    ("recorder.cpp", "if (first < 0) first = 0;", ""),
]


def command_of(build, source):
    for entry in json.loads((build / "compile_commands.json").read_text()):
        if entry["file"].endswith(source):
            return [w for w in shlex.split(entry["command"]) if w != "ccache"], entry["directory"]
    raise LookupError(source)


def try_mutant(build, number, folder):
    name, text, other = MUTANTS[number]
    original = ROOT / "firmware" / name
    source = original.read_text()
    if source.count(text) != 1:
        return f"stale: found {source.count(text)} times"
    tree = Path(folder) / "firmware"
    tree.mkdir(exist_ok=True)
    (tree / name).write_text(source.replace(text, other))
    # a header changes what includes it: fire control, and the tests that use the gate by itself
    units = [f"firmware/{name}"] if name.endswith(".cpp") else [
        "firmware/fire_control.cpp", "firmware/fire_step.cpp", "tests/firmware/test_fire_control.cpp"]
    objects, replaced = [], {}
    for unit in units:
        if unit.startswith("tests/"):  # several tests are compiled as one file
            whole = next(p for p in (build / "tests/firmware/CMakeFiles/test_firmware.dir/Unity").glob("*.cxx")
                         if unit in p.read_text())
            words, directory = command_of(build, str(whole.relative_to(build)))
            place = whole
        else:
            words, directory = command_of(build, f"/{unit}")
            place = tree / Path(unit).name
        if not place.exists():
            place.write_text((ROOT / unit).read_text())
        made = str(Path(folder) / f"{place.name}.o")
        if unit.startswith("tests/"):
            replaced[f"{place.name}.o"] = made
        else:
            objects.append(made)
        words[words.index("-o") + 1] = made
        words[-1] = str(place)
        words = [w for w in words if w != "-Winvalid-pch"]
        words = [w for w in words if w not in ("-Werror", "-MD") and not w.startswith("-MF")]
        words = [words[0], f"-I{folder}", "-w", *words[1:]]
        done = subprocess.run(words, cwd=directory, capture_output=True, text=True)
        if done.returncode:
            return "does not compile"
    program = Path(folder) / "test_firmware"
    link = subprocess.run(["ninja", "-C", str(build), "-t", "commands", "test_firmware"], capture_output=True, text=True)
    line = [c for c in link.stdout.splitlines() if "-o tests/firmware/test_firmware" in c][-1]
    line = line[line.index("/"):].split(" && ")[0] if line.startswith(":") else line
    words = shlex.split(line)
    words[words.index("-o") + 1] = str(program)
    first = next(i for i, w in enumerate(words) if w.endswith(".o"))
    words = [replaced.get(Path(w).name, w) for w in words]
    words[first:first] = objects + ["-Wl,--allow-multiple-definition"]
    done = subprocess.run([w for w in words if w != "ccache"], cwd=build, capture_output=True, text=True)
    if done.returncode:
        return "does not link: " + done.stderr[-200:]
    try:
        done = subprocess.run([str(program), "-a"], capture_output=True, timeout=600)
    except subprocess.TimeoutExpired:
        return "killed"
    return "killed" if done.returncode else "SURVIVED"


def main(arguments):
    build = Path(arguments[0]).resolve()
    numbers = [int(n) for n in arguments[1:]] or range(len(MUTANTS))
    killed = tried = 0
    for number in numbers:
        with tempfile.TemporaryDirectory() as folder:
            verdict = try_mutant(build, number, folder)
        tried, killed = tried + 1, killed + (verdict == "killed")
        name, text, other = MUTANTS[number]
        print(f"{number:2} {verdict:10} {name}: {text!r} -> {other!r}", flush=True)
    print(f"{killed} of {tried} killed")


if __name__ == "__main__":
    main(sys.argv[1:])
