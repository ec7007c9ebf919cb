"""The program `truepose` inside the wheel."""

from __future__ import annotations

import os
import sys


def main() -> None:
    """Runs the program with the arguments of the process; ends the process with its exit code."""
    from truepose import _core

    code = _core.run(["truepose", *sys.argv[1:]])
    # A run that was interrupted leaves its thread behind: the process ends as it is.
    sys.stdout.flush()
    sys.stderr.flush()
    os._exit(code)
