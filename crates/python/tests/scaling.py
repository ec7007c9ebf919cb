"""Time, processor time and memory of an identification on a cluster of processes: `python scaling.py FOLDER [rows] [workers:files …]`.

The folder keeps the Parquet files for the next run. For each number of workers and files a line: wall time; processor time of the client with the scheduler
(which is in its process) and of all workers; the largest peak of a worker's memory; the digest of the fit, which is always the same; and the load of
the machine before and after. A cluster without work spends some processor time each second, beside the workers: without it, what the client and the
scheduler spend is taken to be serial, but no less than the calling thread computes, and limits the speed-up of one worker more and of any number.
"""

from __future__ import annotations

import hashlib
import os
import sys
import time
from pathlib import Path
from typing import Any

import distributed

import truepose as tp
import truepose.dask

sys.path.insert(0, str(Path(__file__).resolve().parents[3] / "examples" / "07_python"))
import cluster as example


IDLE = 10.0
"""Time for which a cluster without work is watched, s."""


def spent() -> tuple[float, float]:
    """Processor time of a process, s, and its peak of memory, MB."""
    times = os.times()
    peak = next(int(line.split()[1]) for line in Path("/proc/self/status").read_text().splitlines() if line.startswith("VmHWM"))
    return times.user + times.system, peak / 1024


def files(folder: Path, robot: tp.Robot, rows: int, count: int) -> list[Path]:
    place = folder / f"{rows}-{count}"
    if not (place / "whole").exists():
        place.mkdir(parents=True, exist_ok=True)
        example.write(place, robot, rows, count)
        (place / "whole").touch()
    return sorted(place.glob("*.parquet"))


def measure(robot: tp.Robot, paths: list[Path], rows: int, workers: int) -> None:
    with distributed.LocalCluster(n_workers=workers, threads_per_worker=1, dashboard_address=None) as cluster, distributed.Client(cluster) as client:
        # What every process of a cluster spends once: the import of the packages.
        truepose.dask.identify(robot, example.write(paths[0].parent.parent, robot, 4000, 1), client=client)
        own = spent()[0]
        time.sleep(IDLE)
        idle = (spent()[0] - own) / IDLE
        load, before, own = os.getloadavg()[0], client.run(spent), spent()[0]
        thread = time.thread_time()
        steps: list[tuple[str, float]] = [("sample and structure", time.perf_counter())]
        fit = truepose.dask.identify(robot, paths, client=client, progress=lambda words: steps.append((words, time.perf_counter())))
        steps.append(("", time.perf_counter()))
        thread = time.thread_time() - thread
        wall, own, after = steps[-1][1] - steps[0][1], spent()[0] - own, client.run(spent)
    there = sum(seconds - before[worker][0] for worker, (seconds, _) in after.items())
    alone = max(own - idle * wall, thread)
    serial = alone / (alone + there)
    limits = [1 / (serial + (1 - serial) / n) for n in (workers + 1, float("inf"))]
    print(
        f"{rows} rows, {len(paths)} files, {workers} workers: {wall:.1f} s wall; CPU: workers {there:.1f} s, client and scheduler {own:.2f} s, "
        f"{alone:.2f} s of it for the work, {thread:.2f} s in the calling thread; serial {100 * serial:.1f} %, so at most "
        f"{limits[0]:.2f} times faster on {workers + 1} workers, {limits[1]:.0f} on any number; peak of a worker "
        f"{max(peak for _, peak in after.values()):.0f} MB; fit {hashlib.sha256(fit.to_json().encode()).hexdigest()[:12]}; "
        f"load {load:.1f} and {os.getloadavg()[0]:.1f}"
    )
    print("  " + ", ".join(f"{words} {end - begin:.2f} s" for (words, begin), (_, end) in zip(steps, steps[1:])), flush=True)


def main(folder: str, rows: int = 1_000_000, *pairs: str) -> None:
    robot = tp.Robot.from_dh([{**row, "limits": (-3.0, 3.0)} for row in example.ROWS], name="arm")
    wanted: Any = [tuple(map(int, pair.split(":"))) for pair in pairs or ("1:40", "2:40", "3:40", "2:10")]
    for workers, count in wanted:
        measure(robot, files(Path(folder), robot, rows, count), rows, workers)


if __name__ == "__main__":
    main(sys.argv[1], *(int(text) for text in sys.argv[2:3]), *sys.argv[3:])
