"""Events of arrays whose answer is known, and simulated closings beside the integrator's own truth."""

import math
import unittest

import numpy as np
import powbench
from fixture import SOURCE, campaign, folder, program


def contact_voltage(rate: float) -> np.ndarray:
    """6 V open, 0 V closed: touch 10.000 ms, open again 10.500 .. 10.900 ms; the record begins 20 ms before."""
    t = np.arange(int(0.08 * rate)) / rate - 0.02
    v = np.where(t < 0.010, 6.0, 0.0)
    v[(t >= 0.0105) & (t < 0.0109)] = 6.0
    return v + np.random.default_rng(1).normal(0, 0.005, len(t))


class ExtractTest(unittest.TestCase):
    def test_a_known_train_of_touches(self):
        for rate in (100e3, 250e3):
            events = powbench.extract({"contact_a": contact_voltage(rate)}, rate, first_time=-0.02)
            self.assertAlmostEqual(float(events.quantities["t_ct1"]), 0.0100, delta=1.5 / rate)
            self.assertAlmostEqual(float(events.quantities["t_ct_bon"]), 0.0009, delta=2 / rate)
            self.assertEqual(events.contact_voltage.bounce_count, 1)
            self.assertTrue(events.quantities["t_ct1"].known)
            self.assertFalse(events.quantities["v_core"].known)
            self.assertTrue(math.isnan(float(events.quantities["v_core"])))
            self.assertIn("no_calibration", events.flags)
            table = powbench.to_pandas(events)
            self.assertEqual(list(table["channel"]), ["contact_voltage", "contact_voltage"])
            self.assertAlmostEqual(table["release"][0], 0.0105, delta=1.5 / rate)
            self.assertTrue(math.isnan(table["release"][1]))

    def test_arrays_of_a_record_give_the_events_of_the_record(self):
        store = powbench.open(campaign()[0])
        record = store.record(int(store.shots().index[0]))
        data = powbench.to_xarray(record)
        stored = powbench.extract(record)
        first = float(data["time"][0])
        events = powbench.extract(
            {n: data[n].values for n in data.data_vars}, record.sample_rate, first_time=first, mains_hertz=50
        )
        for symbol in ("t_ct1", "t_ct2", "i_peak"):
            ours, theirs = events.quantities[symbol], stored.quantities[symbol]
            # the channel's known delay and corner are not in an array: within the stated uncertainty and the delay
            self.assertAlmostEqual(ours.value, theirs.value, delta=max(3 * theirs.u, 1e-9))

    def test_lost_samples_and_options(self):
        v = contact_voltage(100e3)
        v[500:520] = np.nan
        events = powbench.extract({"contact_a": v}, 100e3, first_time=-0.02, merge_openings=0.001)
        self.assertEqual(events.contact_voltage.bounce_count, 0)  # the opening of 0.4 ms counts as closed
        self.assertIn("touch_sigmas", powbench.extract_options())
        with self.assertRaisesRegex(powbench.BadInput, "no extraction option 'merge'"):
            powbench.extract({"contact_a": v}, 100e3, first_time=-0.02, merge=1)
        with self.assertRaisesRegex(ValueError, "touch_sigmas"):
            powbench.extract({"contact_a": v}, 100e3, first_time=-0.02, touch_sigmas=-1)

    def test_impossible_arrays_are_refused(self):
        good = contact_voltage(100e3)
        cases = [
            (({}, 100e3), dict(first_time=0), "no channel is given"),
            (({"contact_a": good[:5]}, 100e3), dict(first_time=0), "allowed 8 or more"),
            (({"contact_a": good}, 1e9), dict(first_time=0), "allowed 1e3 .. 2.5e6"),
            (({"contact_a": good}, math.nan), dict(first_time=0), "allowed 1e3 .. 2.5e6"),
            (({"contact_a": good}, 100e3), dict(first_time=math.inf), "near switch-on"),
            (({"contact_a": good, "laser": good[:-1]}, 100e3), dict(first_time=0), "as many as the first"),
            (({"contact_a": good.reshape(2, -1)}, 100e3), dict(first_time=0), "one dimension"),
            (({"contact_a": good * 1e12}, 100e3), dict(first_time=0), "below 1e9"),
            (({"contact_b": good}, 100e3), dict(first_time=0), "did you mean 'contact_a'"),
            (({"contact_a": good},), dict(), "arrays need sample_rate"),
        ]
        for positional, named, sentence in cases:
            with self.assertRaisesRegex(powbench.BadInput, sentence):
                powbench.extract(*positional, **named)


class SimulateTest(unittest.TestCase):
    def test_events_are_near_the_truth_and_repeatable(self):
        closing = powbench.simulate(60)
        touch = closing.events.quantities["t_ct1"]
        self.assertAlmostEqual(touch.value, closing.truth["touch_s"], delta=50e-6)
        self.assertAlmostEqual(closing.events.quantities["t_xt1"].value, closing.truth["core_seat_s"], delta=50e-6)
        again = powbench.simulate(60)
        np.testing.assert_array_equal(closing.record.counts("laser"), again.record.counts("laser"))
        self.assertNotEqual(powbench.simulate(90).truth["touch_s"], closing.truth["touch_s"])

    def test_it_is_the_closing_that_the_command_line_simulates(self):
        store = powbench.open(campaign()[0])
        plan, file = folder() / "nominal.plan.toml", folder() / "nominal.db"
        plan.write_text('name = "n"\nangles_deg = [75]\nrepeats = 1\nsupply_volts = 240\n')
        program("sim", plan, "--db", file, "--nominal", "--progress", "none")
        stored = powbench.open(file).record(1)
        ours = powbench.simulate(75, supply_volts=240).record
        self.assertEqual(stored.channels, ours.channels)
        for name in ours.channels:
            np.testing.assert_array_equal(stored.counts(name), ours.counts(name), name)
        self.assertGreater(len(store.campaigns()), 0)

    def test_a_specimen_file_and_all_mistakes_at_once(self):
        file = SOURCE / "scenes" / "published.specimen.toml"
        self.assertNotEqual(
            powbench.simulate(60, specimen=file).truth["touch_s"], powbench.simulate(60).truth["touch_s"]
        )
        with self.assertRaises(powbench.BadInput) as caught:
            powbench.simulate(60, supply_volts=5000, hold_time_ms=math.nan)
        self.assertEqual(len(caught.exception.errors), 2)
        plan = folder() / "bad.plan.toml"
        plan.write_text('angles_deg = [60.0]\nrepeats = 1\nsupply_volts = 5000.0\nhold_time_ms = nan\n')
        said = program("plan", "check", plan, code=2).splitlines()
        for ours, theirs in zip(caught.exception.errors, said):
            self.assertEqual(ours.split(": ", 1)[1], theirs.split(": ", 1)[1])
        with self.assertRaises(powbench.BadInput):
            powbench.simulate(60, specimen=folder() / "no.specimen.toml")
