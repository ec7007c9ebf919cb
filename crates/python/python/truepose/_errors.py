"""Exceptions."""

from __future__ import annotations

from typing import TYPE_CHECKING, Any

from truepose._core import InputError

if TYPE_CHECKING:
    from truepose._discovery import Discovery

__all__ = ["InputError", "Interrupted"]


class Interrupted(KeyboardInterrupt):
    """A search that was ended with Ctrl-C. `found` is what was found until then, or None.

    It is a `KeyboardInterrupt`, so that a notebook stops as usual; catch it to go on with what there is:

    Examples
    --------
    >>> try:
    ...     result = tp.discover(robot, data)  # doctest: +SKIP
    ... except tp.Interrupted as interrupted:
    ...     result = interrupted.found
    """

    found: Discovery | None

    def __init__(self, message: str = "interrupted", found: Discovery | None = None) -> None:
        super().__init__(message)
        self.found = found

    @classmethod
    def _of(cls, found: Any) -> Interrupted:
        from truepose._discovery import Discovery

        if found is None:
            return cls("interrupted before the first finding")
        kept = Discovery(found)
        names = ", ".join(effect.title for effect in kept.effects)
        return cls(f"interrupted; found so far (exception's `found`): {names or 'nothing'}", kept)
