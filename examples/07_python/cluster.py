"""Past one machine: an identification over Parquet files on a Dask cluster, with the bytes of the single machine.

`pip install 'dask[distributed]' pyarrow`; `python cluster.py [rows] [files] [workers]`
"""

from __future__ import annotations

import importlib
import sys
import tempfile
import time
from pathlib import Path
from typing import Any

import numpy as np

import truepose as tp
import truepose.dask
import truepose.stream

HALF = np.pi / 2
ROWS: list[dict[str, Any]] = [
    {"d": 0.1625, "alpha": HALF},
    {"a": -0.425},
    {"a": -0.3922},
    {"d": 0.1333, "alpha": HALF},
    {"d": 0.0997, "alpha": -HALF},
    {"d": 0.0996},
]


def write(folder: Path, robot: tp.Robot, rows: int, files: int) -> list[Path]:
    """Measured positions of an arm whose dimensions are slightly off, in Parquet files."""
    parquet: Any = importlib.import_module("pyarrow.parquet")
    arrow: Any = importlib.import_module("pyarrow")
    off = np.random.default_rng(3)
    real = tp.Robot.from_dh([{key: row.get(key, 0.0) + off.normal(scale=5e-4) for key in ("theta", "d", "a", "alpha")} for row in ROWS])
    # The rows of a file do not depend on how many files there are.
    paths = []
    ends = [rows * k // files for k in range(files + 1)]
    lattice = np.sqrt([2.0, 3.0, 5.0, 7.0, 11.0, 13.0])
    for k, (begin, end) in enumerate(zip(ends[:-1], ends[1:])):
        place = np.arange(begin, end)[:, None]
        q = 6.0 * ((place * lattice) % 1.0) - 3.0
        scatter = 2e-4 * (((place + 1) * np.sqrt([17.0, 19.0, 23.0])) % 1.0 - 0.5)
        position = real.fk(q)[:, :3, 3] + scatter
        columns = {f"j{j + 1}[rad]": q[:, j] for j in range(6)} | {f"{axis}[m]": position[:, j] for j, axis in enumerate("xyz")}
        paths.append(folder / f"part-{k:03}.parquet")
        parquet.write_table(arrow.table(columns), paths[-1], row_group_size=65536)
    return paths


def main(rows: int = 60_000, files: int = 8, workers: int = 2) -> None:
    robot = tp.Robot.from_dh([{**row, "limits": (-3.0, 3.0)} for row in ROWS], name="arm")
    distributed: Any = importlib.import_module("distributed")
    with tempfile.TemporaryDirectory() as name:
        paths = write(Path(name), robot, rows, files)
        with distributed.LocalCluster(n_workers=workers, threads_per_worker=1, dashboard_address=None) as cluster, distributed.Client(cluster) as client:
            begun = time.perf_counter()
            fit = truepose.dask.identify(robot, paths, client=client, progress=print)
            seconds = time.perf_counter() - begun
        print(f"{rows} rows in {files} files on {workers} workers: {seconds:.1f} s, held-out RMS {fit.summary['held_out']['rms_mm']:.4f} mm")
        if rows <= 100_000:
            alone = truepose.stream.identify(robot, paths)
            print("the bytes of one machine:", fit.to_json() == alone.to_json())
        fit.save("fit.json")


if __name__ == "__main__":
    main(*map(int, sys.argv[1:]))
