"""Waveforms into xarray: python_read.py PACKAGE_FOLDER [GIGABYTES]. Writes a store of copies of one simulated record and reads it.

One table: what is read, its size in memory, wall and processor time. The plain copy of as many bytes stands beside it.
"""

import os
import resource
import sys
import tempfile
import time

sys.path.insert(0, sys.argv[1])
import numpy as np  # noqa: E402
import powbench  # noqa: E402


def cpu() -> float:
    use = resource.getrusage(resource.RUSAGE_SELF)
    return use.ru_utime + use.ru_stime


def timed(call):
    wall, before = time.perf_counter(), cpu()
    result = call()
    return result, time.perf_counter() - wall, cpu() - before


def row(what, gigabytes, wall, used):
    print(f"{what:<44} {gigabytes:>6.2f} {wall:>8.2f} {used:>8.2f} {gigabytes / used:>8.2f}")


def main() -> None:
    wanted = float(sys.argv[2]) if len(sys.argv) > 2 else 1.0
    with tempfile.TemporaryDirectory() as folder:
        plan, file = os.path.join(folder, "p.toml"), os.path.join(folder, "r.db")
        with open(plan, "w", encoding="utf-8") as out:
            out.write('name = "copies"\nangles_deg = [60]\nrepeats = 40\n')
        with powbench.Rig("sim:") as rig:
            rig.run(plan, file)
        store = powbench.open(file)
        shots = [int(s) for s in store.shots().index]
        one = store.waveforms(shots=shots[:1])
        times = max(1, round(wanted * 1e9 / one.nbytes / len(shots)))
        many = shots * times
        for _ in range(2):  # the second reading has the pages of the file
            data, wall, used = timed(lambda: store.waveforms(shots=many))
        stored = sum(data[n].size * 2 for n in data.data_vars) / 1e9
        size = sum(data[n].nbytes for n in data.data_vars) / 1e9
        print(f"{len(many)} records, {os.cpu_count()} cores; GB/s per second of processor")
        print(f"{'':<44} {'GB':>6} {'wall s':>8} {'cpu s':>8} {'GB/s':>8}")
        row("waveforms(), float32 in memory", size, wall, used)
        row("the same, of counts as stored", stored, wall, used)
        source = np.ones(int(size * 1e9 / 4), np.float32)
        _, wall, used = timed(source.copy)
        row("copy of an array of that size", size, wall, used)


if __name__ == "__main__":
    main()
