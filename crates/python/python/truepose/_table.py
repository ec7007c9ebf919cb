"""Tables that results are given as."""

from __future__ import annotations

import importlib
from collections.abc import Iterator, Mapping
from html import escape
from typing import Any

import numpy as np
from numpy.typing import NDArray

from truepose import _core


class Table(Mapping[str, "NDArray[Any]"]):
    """Columns under their headers: a mapping from headers to arrays, and an Arrow table for every library of frames.

    ``pandas.DataFrame(table)``, ``polars.DataFrame(table)``, ``pyarrow.table(table)`` take it as it is, and
    `to_pandas`, `to_polars` and `to_arrow` do so.
    """

    __slots__ = ("_columns",)

    def __init__(self, columns: Mapping[str, Any]) -> None:
        self._columns: dict[str, NDArray[Any]] = {header: np.asarray(values) for header, values in columns.items()}

    def __getitem__(self, header: str) -> NDArray[Any]:
        return self._columns[header]

    def __iter__(self) -> Iterator[str]:
        return iter(self._columns)

    def __len__(self) -> int:
        return len(self._columns)

    @property
    def rows(self) -> int:
        """Number of rows."""
        return len(next(iter(self._columns.values()), ()))

    def __arrow_c_stream__(self, requested_schema: object | None = None) -> object:
        def plain(values: NDArray[Any]) -> Any:
            if values.dtype.kind in "iufb":
                return np.ascontiguousarray(values, dtype=np.float64)
            return [None if cell is None else str(cell) for cell in values.tolist()]

        return _core.arrow_stream([(header, plain(values)) for header, values in self._columns.items()])

    def to_pandas(self) -> Any:
        """A frame of pandas, which has to be installed."""
        return _library("pandas").DataFrame(dict(self._columns))

    def to_polars(self) -> Any:
        """A frame of polars, which has to be installed."""
        return _library("polars").DataFrame(self)

    def to_arrow(self) -> Any:
        """A table of pyarrow, which has to be installed."""
        return _library("pyarrow").table(self)

    def __repr__(self) -> str:
        return f"Table({self.rows} rows: {', '.join(self._columns)})"

    def _repr_html_(self) -> str:
        head = "".join(f"<th>{escape(header)}</th>" for header in self._columns)
        shown = min(self.rows, 20)
        body = "".join(
            "<tr>" + "".join(f"<td>{escape(_cell(values[row]))}</td>" for values in self._columns.values()) + "</tr>"
            for row in range(shown)
        )
        more = f"<p>{self.rows - shown} more rows</p>" if self.rows > shown else ""
        return f"<table><thead><tr>{head}</tr></thead><tbody>{body}</tbody></table>{more}"


def _library(name: str) -> Any:
    return importlib.import_module(name)


def _cell(value: Any) -> str:
    if isinstance(value, (float, np.floating)):
        return "" if np.isnan(value) else f"{value:.6g}"
    return "" if value is None else str(value)
