"""Replays the board's image: run.py FOLDER_WITH_THE_IMAGE [SCENARIO...]. Ends with `N passed, N failed`.

Needs Debian's python3-unicorn. The rules, their sources and what is not modelled: `run.py --rules`.
"""

import sys
from collections import Counter

import rules
from bench import Image, Report, branch, prepare
import scenario_calibration
import scenario_faults
import scenario_model
import scenario_port
import scenario_relay
import scenario_reset
import scenario_shot
import scenario_stop

SCENARIOS = {"model": scenario_model.run, "parity": scenario_model.parity, "calibration": scenario_calibration.run, "torn": scenario_calibration.torn,
              "shot": scenario_shot.run, "offsets": scenario_shot.with_offsets, "sending": scenario_stop.abort_while_sending, "relay": scenario_relay.run, "faults": scenario_faults.run, "lost": scenario_stop.lost_samples,
             "supply": scenario_reset.supply, "options": scenario_reset.options, "crystal": scenario_reset.crystal,
             "hang": scenario_reset.hang, "crash": scenario_reset.crash, "clock": scenario_reset.stop_clock,
             "stop": scenario_stop.run, "port": scenario_port.run}


def print_rules():
    for name, (what, source) in rules.RULES.items():
        print(f"{name:16} {what} [{source}]")
    print("\nNot modelled:")
    for what in rules.NOT_MODELLED:
        print(f"- {what}")


def main(arguments):
    if arguments == ["--rules"]:
        return print_rules()
    image, wanted = Image(arguments[0]), arguments[1:]
    names = [n for n in SCENARIOS if not wanted or n in wanted]
    met, passed, failed = Counter(), 0, 0

    def play(name):
        report = Report()
        SCENARIOS[name](image, report)
        return report.lines, report.rules

    prepare(image)
    for name, (ending, result) in zip(names, branch([lambda n=n: play(n) for n in names])):
        lines = result[0] if ending == "done" else [(False, name, result.strip())]
        if ending == "done":
            met.update(result[1])
        for good, what, value in lines:
            passed, failed = passed + good, failed + (not good)
            print(f"{'ok     ' if good else 'FAILED '} {what:50} {value}", flush=True)
    if not wanted:
        unmet = sorted(set(rules.RULES) - set(met))
        print(f"{'FAILED ' if unmet else 'ok     '} {'vendor rules never met':50} {', '.join(unmet) or 'none'}")
        passed, failed = passed + (not unmet), failed + bool(unmet)
    print(f"{passed} passed, {failed} failed")
    return int(failed > 0)


if __name__ == "__main__":
    sys.exit(main(sys.argv[1:]))
