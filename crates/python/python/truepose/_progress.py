"""What is going on: a line in a terminal or a notebook, or a call for each step."""

from __future__ import annotations

import sys
import time
from collections.abc import Callable
from types import TracebackType
from typing import Any, TypeAlias

Progress: TypeAlias = "bool | Callable[[str], object]"
"""True: a line in the terminal or notebook; a function: called with the words of each step."""


class Line:
    """The present step, in one line that disappears at the end."""

    def __init__(self, wanted: Progress) -> None:
        self.show: Callable[[str], object] | None = None
        self._display: Any = None
        self._begun = time.monotonic()
        if callable(wanted):
            self.show = wanted
        elif wanted:
            self.show = self._line
            self._display = _notebook()

    def _line(self, words: str) -> None:
        words = f"{time.monotonic() - self._begun:5.0f} s  {words}"
        if self._display is not None:
            self._display.update({"text/plain": words}, raw=True)
        else:
            print(f"\r\033[K{words}" if sys.stderr.isatty() else words, end="" if sys.stderr.isatty() else "\n", file=sys.stderr, flush=True)

    def __enter__(self) -> Callable[[str], object] | None:
        return self.show

    def __exit__(self, kind: type[BaseException] | None, error: BaseException | None, trace: TracebackType | None) -> None:
        if self._display is not None:
            self._display.update({"text/plain": ""}, raw=True)
        elif self.show == self._line and sys.stderr.isatty():
            print("\r\033[K", end="", file=sys.stderr, flush=True)


def _notebook() -> Any:
    """A line of the running notebook; None elsewhere."""
    if "IPython" not in sys.modules:
        return None
    ipython: Any = sys.modules["IPython"]
    shell = ipython.get_ipython()
    if shell is None or not hasattr(shell, "kernel"):
        return None
    return ipython.display.display({"text/plain": ""}, raw=True, display_id=True)
