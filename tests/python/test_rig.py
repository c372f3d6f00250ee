"""Rigs: the way of the command line, the interpreter free meanwhile, Ctrl-C switches off."""

import _thread
import subprocess
import sys
import threading
import time
import unittest

import numpy as np
import powbench
from fixture import PROGRAM, campaign, folder, program


def runs_meanwhile(call) -> bool:
    """Another thread gets the interpreter while `call` runs: it can only if the call gives it up, for nobody is interrupted."""
    before = sys.getswitchinterval()
    sys.setswitchinterval(1000)
    rounds, ends, begun = [0], threading.Event(), threading.Event()

    def count():
        begun.set()
        while not ends.is_set():
            rounds[0] += 1
            time.sleep(0)

    thread = threading.Thread(target=count)
    thread.start()
    begun.wait()
    try:
        first = rounds[0]
        call()
        return rounds[0] > first
    finally:
        ends.set()
        thread.join()
        sys.setswitchinterval(before)


class RigTest(unittest.TestCase):
    def test_one_closing(self):
        with powbench.Rig("sim:") as rig:
            self.assertEqual(rig.info["origin"], "SIMULATED RIG")
            self.assertEqual(rig.status()["state"], "idle")
            shot = rig.fire(60, seed=3)
            self.assertIn(shot.outcome, ("PASS", "NOT JUDGED"))
            self.assertAlmostEqual(shot.record.conditions["angle_deg"], 60)
            self.assertAlmostEqual(np.degrees(shot.events.coil.closing_angle.value), 60, delta=1)
            self.assertTrue(rig.status()["owner"].startswith("powbench-"), rig.status())
            again = rig.fire(60, seed=3)
            np.testing.assert_array_equal(shot.record.counts("pvdf_a"), again.record.counts("pvdf_a"))
            self.assertIn(rig.stop(), ("idle", "captured"))
        with self.assertRaisesRegex(powbench.RigError, "is closed"):
            rig.fire(60)

    def test_a_stop_ends_a_closing_that_waits_for_another_owner(self):
        with subprocess.Popen(
            [PROGRAM, "rig", "--listen", "127.0.0.119"], stdout=subprocess.PIPE, stderr=subprocess.STDOUT, text=True
        ) as server:
            try:
                for line in server.stdout:
                    if "127.0.0.119" in line:
                        break
                with powbench.Rig("ip:127.0.0.119") as owner, powbench.Rig("ip:127.0.0.119") as rig:
                    self.assertIn(owner.fire(60).outcome, ("PASS", "NOT JUDGED"))  # and keeps the lease for 5 s
                    shots = []
                    waits = threading.Thread(target=lambda: shots.append(rig.fire(90)))
                    waits.start()
                    while waits.is_alive():
                        rig.stop()
                        waits.join(0.05)
                    self.assertEqual((shots[0].outcome, shots[0].reason), ("ABORTED", "stopped by the operator"))
                    self.assertIsNone(shots[0].record)
            finally:
                server.terminate()

    def test_what_may_not_be_fired_is_refused_before_the_coil(self):
        with powbench.Rig("sim:") as rig:
            with self.assertRaisesRegex(powbench.BadInput, "hold_time_ms"):
                rig.fire(60, hold_time_ms=60_000)
            with self.assertRaisesRegex(powbench.BadInput, "angles_deg"):
                rig.fire(400)
            self.assertEqual(rig.status()["state"], "idle")

    def test_an_interlock_is_an_outcome_with_a_sentence(self):
        rig_file = folder() / "open.rig.toml"
        rig_file.write_text("[faults]\nrelay_open = true\n")
        with powbench.Rig(f"sim:{rig_file}") as rig:
            shot = rig.fire(60)
        self.assertEqual(shot.outcome, "ERROR")
        self.assertTrue(shot.reason)
        self.assertIsNone(shot.record)
        self.assertIsNone(shot.events)

    def test_unknown_rigs_get_the_sentence_of_the_command_line(self):
        for uri in ("sim", "nowhere:7", ""):
            with self.assertRaises(powbench.RigError) as caught:
                powbench.Rig(uri)
            if uri:
                self.assertIn(str(caught.exception), program("info", uri, code=2))
        with self.assertRaises(powbench.BadInput):
            powbench.Rig("sim:no-such.rig.toml")

    def test_ctrl_c_ends_a_plan_and_keeps_what_was_fired(self):
        plan, file = folder() / "long.plan.toml", folder() / "long.db"
        plan.write_text('name = "long"\nangles_deg = [30, 60]\nrepeats = 5\npause_s = 3000\n')

        def interrupt():
            while True:  # the first shot is in the store
                try:
                    if len(powbench.open(file).shots()):
                        break
                except powbench.Error:
                    pass
                time.sleep(0.01)
            _thread.interrupt_main()

        with powbench.Rig("sim:") as rig:
            thread = threading.Thread(target=interrupt)
            thread.start()
            with self.assertRaises(KeyboardInterrupt):
                rig.run(plan, file)
            thread.join()
            self.assertNotIn(rig.status()["state"], ("armed", "firing"))
        table = powbench.open(file).shots()
        self.assertEqual(len(table), 1)
        self.assertFalse(powbench.open(file).campaigns()["finished"].iloc[0])

    def test_the_interpreter_is_free_in_long_calls(self):
        store = powbench.open(campaign()[0])
        record = store.record(int(store.shots().index[0]))
        self.assertFalse(runs_meanwhile(lambda: sum(range(1_000_000))))  # the probe itself: this call keeps it
        self.assertTrue(runs_meanwhile(lambda: powbench.simulate(60)))
        self.assertTrue(runs_meanwhile(lambda: powbench.extract(record)))
        self.assertTrue(runs_meanwhile(lambda: store.waveforms()))
        with powbench.Rig("sim:") as rig:
            self.assertTrue(runs_meanwhile(lambda: rig.fire(60)))
