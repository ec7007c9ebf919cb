"""Frames, mappings and arrays as tables of the compiled part."""

from __future__ import annotations

import os
from collections.abc import Iterable, Mapping, Sequence
from typing import TYPE_CHECKING, Any, Protocol, TypeAlias, TypedDict, runtime_checkable

import numpy as np
from numpy.typing import ArrayLike, NDArray

from truepose import _core
from truepose._core import InputError

if TYPE_CHECKING:
    from truepose._robot import Robot

Floats: TypeAlias = NDArray[np.float64]
"""An array of float64."""


@runtime_checkable
class ArrowStream(Protocol):
    """A frame of polars, pyarrow, DuckDB, pandas …: anything with the Arrow PyCapsule interface."""

    def __arrow_c_stream__(self, requested_schema: object | None = None) -> object: ...


class Arrays(TypedDict, total=False):
    """Measurements as arrays, in SI units (m, rad, kg, N, N·m, s), one row for each measured target.

    `q` n × dof; `position` n × 3; `orientation` quaternions (w, x, y, z) n × 4, rotation vectors n × 3 or matrices n × 3 × 3; `pose` n × 4 × 4 in
    place of both; NaN is not measured. `payload` (one mass or n) with its centre of gravity `com` (3 or n × 3, in the tool's frame), or `wrench` n × 6
    (force and moment at the tool's origin, in its axes). `target` names, `visit` integers, `time`, `approach` n × dof of -1, 0, 1, `position_sd`
    and `orientation_sd` (one number, 3, or n × 3). `channels`: further columns under their headers, such as ``"temperature[degC]"``.
    """

    q: ArrayLike
    position: ArrayLike
    orientation: ArrayLike
    pose: ArrayLike
    payload: ArrayLike
    com: ArrayLike
    wrench: ArrayLike
    target: Sequence[str | None]
    visit: ArrayLike
    time: ArrayLike
    approach: ArrayLike
    position_sd: ArrayLike
    orientation_sd: ArrayLike
    channels: Mapping[str, ArrayLike]


Path: TypeAlias = "str | os.PathLike[str]"

Frame: TypeAlias = "ArrowStream | Mapping[str, Any]"
"""A table in memory: a frame, or a mapping from headers to columns."""

Column: TypeAlias = "Floats | list[str | None]"


def table(frame: object, name: str = "data") -> _core.Table:
    """A frame or a mapping as a table; its columns are copied once."""
    if isinstance(frame, Mapping):
        return _core.Table(name, [(str(header), column(str(header), values)) for header, values in frame.items()])
    # pandas: by position (headers may be doubled), without its index, and without pyarrow.
    if hasattr(frame, "iloc") and hasattr(frame, "columns"):
        pandas: Any = frame
        headers = [str(header) for header in pandas.columns]
        return _core.Table(name, [(header, column(header, pandas.iloc[:, k])) for k, header in enumerate(headers)])
    if isinstance(frame, ArrowStream):
        named: Any = getattr(frame, "column_names", getattr(frame, "columns", ()))
        if isinstance(named, (list, tuple)) and any("\0" in str(header) for header in named):
            # The interface cannot pass it on: polars ends the interpreter.
            raise InputError("a header contains a NUL character; rename the column")
        return _core.read_table(name, frame)
    raise InputError(
        f"a table is a frame (pandas, polars, pyarrow, DuckDB …), a mapping from headers to columns, or a path, and not {type(frame).__name__}"
    )


def column(header: str, values: Any) -> Column:
    """A column as numbers (NaN: empty) or texts (None: empty)."""
    kind = getattr(getattr(values, "dtype", None), "kind", None)
    if kind == "M" and getattr(values.dtype, "tz", None) is not None and hasattr(values, "dt"):
        values = values.dt.tz_convert("UTC").dt.tz_localize(None)
    if kind in ("i", "u", "f", "b") and hasattr(values, "array"):
        # A column of pandas, of which integers and truth values may have empty cells.
        return np.asarray(values.to_numpy(dtype="float64", na_value=np.nan), dtype=np.float64)
    try:
        array = np.asarray(values)
    except (ValueError, TypeError) as error:
        raise InputError(f"column `{header}` is no one-dimensional array: {error}") from None
    if array.ndim != 1:
        raise InputError(f"column `{header}` has {array.ndim} dimensions; a column has one")
    if array.dtype.kind in "iufb":
        return np.asarray(array, dtype=np.float64)
    if array.dtype.kind in "Mm":
        unit = "datetime64[ns]" if array.dtype.kind == "M" else "timedelta64[ns]"
        whole = array.astype(unit).astype(np.int64)
        return np.where(np.isnat(array), np.nan, whole / 1e9)
    if array.dtype.kind in "OUT":
        return _texts(header, array.tolist())
    raise InputError(f"column `{header}` holds {array.dtype}; a table of measurements holds plain numbers and texts")


def _texts(header: str, cells: Iterable[Any]) -> Column:
    texts: list[str | None] = []
    numbers: list[float] = []
    for row, cell in enumerate(cells):
        empty = cell is None or (isinstance(cell, float) and cell != cell) or type(cell).__name__ in ("NAType", "NaTType")
        if empty:
            texts.append(None)
            numbers.append(np.nan)
        elif isinstance(cell, str):
            texts.append(cell)
        elif isinstance(cell, (int, float, np.number, np.bool_)):
            try:
                numbers.append(float(cell))
            except (OverflowError, TypeError):
                raise _cell(row, header, f"{type(cell).__name__} is no number that a table can hold") from None
            texts.append(repr(cell) if isinstance(cell, (int, float)) else str(cell))
        else:
            raise _cell(row, header, f"{type(cell).__name__} is neither a number nor a text")
    if len(numbers) == len(texts):
        return np.array(numbers, dtype=np.float64)
    return texts


def _cell(row: int, header: str, message: str) -> InputError:
    error = InputError(f"data:{row + 1}: column `{header}`: {message}")
    error.row, error.column, error.source = row + 1, header, "data"
    error.errors = [(row + 1, header, message)]
    return error


def floats(name: str, values: ArrayLike, *shape: int | None) -> Floats:
    """An array of this shape (None: any length)."""
    try:
        array = np.asarray(values, dtype=np.float64)
    except (ValueError, TypeError) as error:
        raise InputError(f"{name} is no array of numbers: {error}") from None
    fits = array.ndim == len(shape) and all(want is None or have == want for have, want in zip(array.shape, shape))
    if not fits:
        wanted = " × ".join("n" if want is None else str(want) for want in shape)
        raise InputError(f"{name} has the shape {array.shape}; it has to be {wanted}")
    return np.ascontiguousarray(array)


def joint_values(robot: Robot, q: ArrayLike) -> Floats:
    """Joint values n × dof; one row may stand alone."""
    try:
        array = np.asarray(q, dtype=np.float64)
    except (ValueError, TypeError) as error:
        raise InputError(f"q is no array of numbers: {error}") from None
    if array.ndim == 1:
        array = array[np.newaxis, :]
    return floats("q", array, None, robot.dof)


def quaternions(name: str, values: ArrayLike, rows: int) -> dict[str, Floats]:
    """Columns of an orientation: quaternions n × 4, rotation vectors n × 3, or matrices n × 3 × 3."""
    try:
        array = np.asarray(values, dtype=np.float64)
    except (ValueError, TypeError) as error:
        raise InputError(f"{name} is no array of numbers: {error}") from None
    if array.shape == (rows, 4):
        return {header: array[:, k] for k, header in enumerate(("qw", "qx", "qy", "qz"))}
    if array.shape == (rows, 3):
        return {header: array[:, k] for k, header in enumerate(("rx[rad]", "ry[rad]", "rz[rad]"))}
    if array.shape == (rows, 3, 3):
        turned = _of_matrices(name, array)
        return {header: turned[:, k] for k, header in enumerate(("qw", "qx", "qy", "qz"))}
    raise InputError(
        f"{name} has the shape {array.shape}; it has to be {rows} × 4 (quaternions w x y z), {rows} × 3 (rotation vectors) or {rows} × 3 × 3"
    )


def _of_matrices(name: str, matrices: Floats) -> Floats:
    measured = ~np.isnan(matrices).any(axis=(1, 2))
    product = np.einsum("nij,nkj->nik", matrices, matrices) - np.eye(3)
    with np.errstate(invalid="ignore", over="ignore"):
        off = (np.abs(product).max(axis=(1, 2)) > 1e-3) | (np.linalg.det(np.nan_to_num(matrices)) < 0)
    wrong = np.flatnonzero(off & measured)
    if wrong.size:
        raise _cell(int(wrong[0]), name, "is no rotation matrix")
    result = np.full((len(matrices), 4), np.nan)
    for row in np.flatnonzero(measured):
        r = matrices[row]
        diagonal = [np.trace(r), r[0, 0], r[1, 1], r[2, 2]]
        largest = int(np.argmax(diagonal))
        # Shepperd 1978.
        if largest == 0:
            q = np.array([1 + diagonal[0], r[2, 1] - r[1, 2], r[0, 2] - r[2, 0], r[1, 0] - r[0, 1]])
        else:
            i, j, k = [(0, 1, 2), (1, 2, 0), (2, 0, 1)][largest - 1]
            q = np.zeros(4)
            q[0], q[1 + i] = r[k, j] - r[j, k], 1 + r[i, i] - r[j, j] - r[k, k]
            q[1 + j], q[1 + k] = r[j, i] + r[i, j], r[k, i] + r[i, k]
        result[row] = q / np.linalg.norm(q)
    return result


def spread_over(name: str, values: ArrayLike, rows: int, width: int) -> Floats:
    """One number, one row, or a row each, as rows × width."""
    try:
        array = np.asarray(values, dtype=np.float64)
    except (ValueError, TypeError) as error:
        raise InputError(f"{name} is no array of numbers: {error}") from None
    if array.shape not in ((), (width,), (rows, width)):
        raise InputError(f"{name} has the shape {array.shape}; it has to be one number, {width}, or {rows} × {width}")
    return np.broadcast_to(array, (rows, width))


def each(name: str, values: ArrayLike, rows: int) -> Floats:
    """One number, or one for each row."""
    alone: Floats = spread_over(name, np.asarray(values), 1, rows)[0]
    return alone


def columns_of(robot: Robot, arrays: Arrays) -> dict[str, Any]:
    """Arrays as columns of a table, under the headers that files have."""
    known = set(Arrays.__annotations__)
    for key in arrays:
        if key not in known:
            raise InputError(f"unknown argument `{key}` (arrays: {', '.join(sorted(known))})")
    if "q" not in arrays:
        raise InputError("give a table of measurements, or at least `q` and `position` (arrays, in SI units)")
    q = joint_values(robot, arrays["q"])
    rows = len(q)
    result: dict[str, Any] = {f"{joint.name}[{joint.unit}]": q[:, k] for k, joint in enumerate(robot.joints)}

    def put(headers: Sequence[str], values: Floats) -> None:
        result.update({header: values[:, k] for k, header in enumerate(headers)})

    if "pose" in arrays:
        pose = floats("pose", arrays["pose"], rows, 4, 4)
        put(("x[m]", "y[m]", "z[m]"), pose[:, :3, 3])
        result.update(quaternions("pose", pose[:, :3, :3], rows))
    if "position" in arrays:
        put(("x[m]", "y[m]", "z[m]"), floats("position", arrays["position"], rows, 3))
    if "orientation" in arrays:
        result.update(quaternions("orientation", arrays["orientation"], rows))
    if "payload" in arrays:
        result["payload[kg]"] = each("payload", arrays["payload"], rows)
        put(("cx[m]", "cy[m]", "cz[m]"), spread_over("com", arrays.get("com", (0.0, 0.0, 0.0)), rows, 3))
    if "wrench" in arrays:
        put(("fx[N]", "fy[N]", "fz[N]", "tx[N*m]", "ty[N*m]", "tz[N*m]"), floats("wrench", arrays["wrench"], rows, 6))
    if "time" in arrays:
        result["time[s]"] = column("time", arrays["time"])
    if "visit" in arrays:
        result["visit"] = column("visit", arrays["visit"])
    if "target" in arrays:
        result["target"] = _texts("target", arrays["target"])
    if "approach" in arrays:
        put([f"approach_{joint.name}" for joint in robot.joints], floats("approach", arrays["approach"], rows, robot.dof))
    if "position_sd" in arrays:
        put(("sx[m]", "sy[m]", "sz[m]"), spread_over("position_sd", arrays["position_sd"], rows, 3))
    if "orientation_sd" in arrays:
        put(("srx[rad]", "sry[rad]", "srz[rad]"), spread_over("orientation_sd", arrays["orientation_sd"], rows, 3))
    for header, values in arrays.get("channels", {}).items():
        result[header] = column(header, values)
    return result
