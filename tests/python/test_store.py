"""Stores: the command line is the referee."""

import csv
import io
import math
import unittest

import numpy as np
import powbench
from fixture import campaign, folder, program, program_json


class StoreTest(unittest.TestCase):
    def setUp(self):
        self.file, self.summary = campaign()
        self.store = powbench.open(self.file)

    def test_a_plan_fired_from_python_is_a_campaign_of_the_command_line(self):
        listed = program_json("campaigns", "--db", self.file)
        self.assertEqual(len(listed), 1)
        table = self.store.campaigns()
        row = table.loc[self.summary["campaign"]]
        self.assertEqual(row["name"], listed[0]["name"])
        self.assertEqual(row["origin"], listed[0]["origin"])
        self.assertEqual(row["origin"], "SIMULATED RIG")
        self.assertTrue(row["finished"])
        self.assertEqual((row["measured"], row["simulated"]), (4, 2))
        self.assertEqual((self.summary["planned"], self.summary["done"]), (4, 4))
        self.assertIsNone(self.summary["stopped"])

    def test_the_table_of_shots_is_that_of_the_command_line(self):
        listed = program_json("shots", "--db", self.file)
        table = self.store.shots(kind=None)
        self.assertEqual(sorted(table.index), sorted(s["shot"] for s in listed))
        for s in listed:
            row = table.loc[s["shot"]]
            self.assertEqual((row["kind"], row["outcome"], row["attempt"]), (s["kind"], s["outcome"], s["attempt"]))
            self.assertEqual(row["angle"], s["angle_deg"])
            self.assertEqual((row["t_ct1"], row["u_t_ct1"]), (s["touch_s"]["value"], s["touch_s"]["u"]))
            self.assertAlmostEqual(math.radians(row["angle_reached"]), s["reached_rad"]["value"], places=12)
        self.assertEqual(table.attrs["units"]["u_v_core"], "m/s")
        self.assertEqual(set(self.store.shots()["kind"]), {"measured"})

    def test_events_and_comparison_are_those_of_the_command_line(self):
        shot = int(self.store.shots().index[0])
        shown = program_json("show", shot, "--db", self.file)["events"]
        import json

        self.assertEqual(json.loads(self.store.events(shot).to_json()), shown)
        compared = [r for r in program_json("compare", "--db", self.file) if "measured" in r]
        table = self.store.compare()
        for ours, theirs in zip(table.to_dict("records"), compared):
            self.assertEqual((ours["quantity"], ours["n"]), (theirs["quantity"], theirs["repeats"] if "repeats" in theirs else theirs["n"]))
        self.assertGreater(len(table), 10)

    def test_waveforms_are_the_exported_ones(self):
        shots = [int(s) for s in self.store.shots().index]
        data = self.store.waveforms(["pvdf_a", "coil_current"], dtype="float64")
        self.assertEqual(data["pvdf_a"].dims, ("shot", "time"))
        self.assertEqual(list(data["shot"].values), shots)
        self.assertEqual(data["pvdf_a"].attrs["units"], "N")
        self.assertEqual(data["coil_current"].attrs["units"], "A")
        self.assertEqual(data["time"].attrs["units"], "s")
        for shot in shots[:2]:
            text = [line for line in program("export", shot, "--db", self.file).splitlines() if not line.startswith("#")]
            rows = list(csv.DictReader(io.StringIO("\n".join(text))))
            name = next(k for k in rows[0] if k.startswith("pvdf_a"))
            exported = np.array([float(r[name]) for r in rows])
            ours = data["pvdf_a"].sel(shot=shot).values
            self.assertEqual(len(ours), len(exported))
            np.testing.assert_allclose(ours, exported, rtol=0, atol=1e-5)
            stamp = np.array([float(r[next(k for k in rows[0] if k.startswith("time"))]) for r in rows])
            offset = float(data["fire_offset"].sel(shot=shot))
            np.testing.assert_allclose(data["time"].values + offset, stamp, rtol=0, atol=1e-9)

    def test_waveforms_records_and_counts_agree(self):
        shots = [int(s) for s in self.store.shots().index]
        single = self.store.waveforms(dtype="float32", threads=2)
        for i, shot in enumerate(shots):
            record = self.store.record(shot)
            for name in record.channels:
                facts = record.channel(name)
                values = (record.counts(name).astype(float) + facts["offset"]) * facts["scale"]
                np.testing.assert_array_equal(values, record.values(name))
                np.testing.assert_array_equal(values.astype(np.float32), single[name].values[i])
        with self.assertRaises(ValueError):
            record.counts("pvdf_a")[0] = 1  # a record never changes
        one = powbench.to_xarray(record)
        self.assertEqual(one["laser"].attrs["units"], "m")
        self.assertEqual(one.attrs["supply_volts"], 230)
        np.testing.assert_array_equal(one["time"].values, record.times())
        self.assertAlmostEqual(float(one["time"][record.fire_sample]), record.fire_offset, places=15)

    def test_lost_samples_are_nan_and_unequal_clocks_are_refused(self):
        file = folder() / "imported.db"

        def imported(name, samples, lost):
            rows = [f"{1e-5 * i - 0.02:.5f}," + ("" if i in lost else f"{6 - 6 * (i > 3000)}.0") for i in range(samples)]
            (folder() / name).write_text("time [s],contact_a [V]\n" + "\n".join(rows) + "\n")
            program("import", folder() / name, "--db", file)

        imported("lossy.csv", 6000, range(100, 125))
        store = powbench.open(file)
        data = store.waveforms(["contact_a", "laser"])
        lost = np.isnan(data["contact_a"].values[0])
        self.assertEqual(list(np.flatnonzero(lost)), list(range(100, 125)))
        self.assertTrue(np.isnan(data["laser"].values).all())  # a channel that the record has not is not known
        self.assertEqual(store.campaigns()["origin"].iloc[0], "IMPORT")
        imported("longer.csv", 7000, ())
        with self.assertRaisesRegex(powbench.BadInput, "do not share a time axis"):
            store.waveforms()
        with self.assertRaises(powbench.WrongStore):
            store.record(99)

    def test_mistakes_are_sentences(self):
        with self.assertRaises(powbench.WrongStore) as caught:
            powbench.open(folder() / "none.db")
        said = program("campaigns", "--db", folder() / "none.db", code=2)
        self.assertIn(str(caught.exception), said)
        damaged = folder() / "damaged.db"
        data = bytearray(self.file.read_bytes())
        at = len(data) // 2
        data[at : at + 64] = bytes(64)
        damaged.write_bytes(data)
        with self.assertRaises(powbench.StoreError):
            powbench.open(damaged).waveforms()
        with self.assertRaisesRegex(powbench.BadInput, "did you mean 'pvdf_a'"):
            self.store.waveforms(["pvdf_aa"])
        with self.assertRaisesRegex(powbench.BadInput, "allowed measured, simulated"):
            self.store.shots(kind="both")
        with self.assertRaisesRegex(powbench.BadInput, "float32, float64"):
            self.store.waveforms(dtype="int16")
        self.assertTrue(issubclass(powbench.BadInput, ValueError))
        self.assertTrue(issubclass(powbench.WrongStore, powbench.Error))
