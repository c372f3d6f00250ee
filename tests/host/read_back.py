"""Reads what powbench exported with other people's libraries and compares it, bit for bit, with the numbers written beside.

Usage: read_back.py FOLDER: record.nc, record.xlsx, record.cfg/.dat, record.csv; columns.txt names the columns, expected.bin holds
them one after the other as float64. Prints one line for each format: `FORMAT LIBRARY equal`, `... differs: WHY`, or `... not installed`.
"""
import os
import struct
import sys

import numpy as np

folder = sys.argv[1]
names = open(os.path.join(folder, "columns.txt")).read().split()
raw = np.fromfile(os.path.join(folder, "expected.bin"))
expected = dict(zip(names, raw.reshape(len(names), -1)))


def path(name):
    return os.path.join(folder, name)


def same(a, b):
    a, b = np.asarray(a, dtype=np.float64), np.asarray(b, dtype=np.float64)
    nan = np.isnan(a)
    return a.shape == b.shape and (nan == np.isnan(b)).all() and (a[~nan].view(np.int64) == b[~nan].view(np.int64)).all()


def compare(columns):
    for name in names:
        if name not in columns:
            return "no column " + name
        if not same(columns[name], expected[name]):
            return "column " + name
    return None


def with_xarray():
    import netCDF4  # by which xarray reads; without it there is no reader
    import xarray

    with xarray.open_dataset(path("record.nc")) as d:
        assert d["pvdf_a"].dims == ("time",) and d["time"].attrs["units"] == "s" and d["pvdf_a"].attrs["units"] == "N"
        assert d.attrs["title"].startswith("powbench")
        return compare({n: d[n.rsplit("_", 1)[0]].values for n in names})


def with_netcdf4():
    import netCDF4

    with netCDF4.Dataset(path("record.nc")) as d:
        assert d["time"].dimensions == ("time",) and d.dimensions["time"].size == len(expected[names[0]])
        return compare({n: np.ma.filled(d[n.rsplit("_", 1)[0]][:], np.nan) for n in names})


def with_h5py():
    import h5py

    with h5py.File(path("record.nc")) as d:
        counts = d["pvdf_a_counts"]
        value = (counts[:] + counts.attrs["offset"][0]) * counts.attrs["scale"][0]
        known = ~np.isnan(expected["pvdf_a_N"])
        if not same(value[known], expected["pvdf_a_N"][known]):
            return "counts of pvdf_a"
        return compare({n: d[n.rsplit("_", 1)[0]][:] for n in names})


def with_openpyxl():
    import openpyxl

    rows = openpyxl.load_workbook(path("record.xlsx"), read_only=True)["record"].iter_rows(values_only=True)
    header = next(rows)
    table = np.array([[np.nan if v is None else v for v in row] for row in rows], dtype=np.float64)
    return compare({n: table[:, header.index(n)] for n in names})


def with_pandas():
    import pandas

    d = pandas.read_csv(path("record.csv"), comment="#", float_precision="round_trip")
    return compare({n: d["{} [{}]".format(*n.rsplit("_", 1))].values for n in names})


def comtrade():
    """IEC 60255-24, read here by its text: value = a x + b, the time from rate and trigger."""
    lines = open(path("record.cfg"), newline="").read().split("\r\n")
    count = int(lines[1].split(",")[0])
    channels = [line.split(",") for line in lines[2 : 2 + count]]
    rate, rows = lines[4 + count].split(",")

    def seconds(line):
        h, m, s = line.split(",")[1].split(":")
        return 3600 * int(h) + 60 * int(m) + float(s)

    before = seconds(lines[6 + count]) - seconds(lines[5 + count])
    wide = lines[7 + count] == "BINARY32"
    data = np.fromfile(path("record.dat"), dtype=np.dtype([("n", "<u4"), ("t", "<u4"), ("x", "<i4" if wide else "<i2", count)]))
    assert len(data) == int(rows) and (data["n"] == np.arange(len(data)) + 1).all()
    time = np.arange(len(data)) / float(rate) - before
    if np.abs(time - expected["time_s"]).max() > 1e-9:
        return "times"
    for k, c in enumerate(channels):
        x = data["x"][:, k].astype(np.float64)
        value = float(c[5]) * x + float(c[6])
        value[data["x"][:, k] == (-2147483648 if wide else -32768)] = np.nan
        want = expected["{}_{}".format(c[1], c[4])]
        if float(c[6]) == 0 and not same(value, want):
            return "channel " + c[1]
        if (np.isnan(value) != np.isnan(want)).any() or np.nanmax(np.abs(value - want)) > 1e-12 * np.nanmax(np.abs(want)):
            return "channel " + c[1]
    return None


failed = False
for label, read in [("nc xarray", with_xarray), ("nc netCDF4", with_netcdf4), ("nc h5py", with_h5py), ("xlsx openpyxl", with_openpyxl),
                    ("csv pandas", with_pandas), ("comtrade numpy", comtrade)]:
    if label.startswith("nc ") and not os.path.exists(path("record.nc")):
        print(label, "not built")
        continue
    try:
        wrong = read()
        print(label, "equal" if wrong is None else "differs: " + wrong)
        failed = failed or wrong is not None
    except ImportError:
        print(label, "not installed")
sys.exit(1 if failed else 0)
