"""Writing of files: whole or not at all."""

from __future__ import annotations

import os
import tempfile

from truepose._arrays import Path
from truepose._core import InputError


def write_text(path: Path, text: str) -> None:
    """Writes a text beside the file, and then in its place."""
    path = os.path.abspath(os.fspath(path))
    folder = os.path.dirname(path)
    if os.path.exists(path) and not os.path.isfile(path):
        # A pipe, or a device.
        with open(path, "w", encoding="utf-8", newline="") as out:
            out.write(text)
        return
    try:
        handle, unfinished = tempfile.mkstemp(prefix=".truepose-", dir=folder)
    except OSError as error:
        raise InputError(f"{path}: cannot be written: {error.strerror}") from None
    try:
        with os.fdopen(handle, "w", encoding="utf-8", newline="") as out:
            out.write(text)
        mask = os.umask(0)
        os.umask(mask)
        os.chmod(unfinished, 0o666 & ~mask)
        os.replace(unfinished, path)
    except BaseException:
        os.unlink(unfinished)
        raise
