"""What a search for effects found."""

from __future__ import annotations

import json
import os
from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from html import escape
from typing import Any

from truepose import _core
from truepose._arrays import Path
from truepose._fit import Fit, image
from truepose._table import Table


@dataclass(frozen=True)
class Rival:
    """The fit of a competing hypothesis that is not distinguishable from a finding."""

    finding: int
    words: str
    fit: Fit


class Finding:
    """An effect that the declared model lacks. `entry` has all of its keys in discovery.json."""

    __slots__ = ("entry", "figure")

    def __init__(self, entry: Mapping[str, Any], figure: str | None) -> None:
        self.entry = entry
        self.figure = figure
        """Partial residuals against what drives the effect (SVG); None where it has no such figure."""

    @property
    def family(self) -> str:
        """Family of the effect."""
        return str(self.entry["family"])

    @property
    def joint(self) -> str | None:
        """The joint, ``base`` or ``tool``; None where it has no such place."""
        joint = self.entry.get("joint")
        return None if joint is None else str(joint)

    @property
    def title(self) -> str:
        """Family and place."""
        keys = ("joint", "driver", "component", "channel", "target", "covariate")
        return " ".join([self.family, *(str(self.entry[key]) for key in keys if self.entry.get(key) is not None)])

    @property
    def p_value(self) -> float:
        """Family-wise p of its existence."""
        return float(self.entry["p_value"])

    @property
    def probability(self) -> float:
        """Probability of its name (family and place), given that the effect exists."""
        return float(self.entry["name_probability"])

    @property
    def parameters(self) -> Table:
        """Its coefficients: name, value, SI unit, 95 % interval."""
        rows: Sequence[Mapping[str, Any]] = self.entry.get("parameters", [])
        columns: dict[str, Any] = {key: [row[key] for row in rows] for key in ("name", "value", "unit")}
        return Table({**columns, "low_95": [row["ci95"][0] for row in rows], "high_95": [row["ci95"][1] for row in rows]})

    @property
    def alternatives(self) -> Sequence[Mapping[str, Any]]:
        """Competing hypotheses, with their probabilities."""
        found: Sequence[Mapping[str, Any]] = self.entry.get("alternatives", [])
        return found

    @property
    def held_out_mm(self) -> tuple[float, float]:
        """RMS of the 3-D position error on held-out rows before and after it was added, mm."""
        rms = self.entry["holdout_rms_mm"]
        return float(rms["before"]), float(rms["after"])

    def __repr__(self) -> str:
        return f"Finding({self.title!r}, p={self.p_value:.2g}, probability={self.probability:.2g})"

    def _repr_html_(self) -> str:
        figure = image(self.figure) if self.figure else ""
        before, after = self.held_out_mm
        words = f"{self.title}: p = {self.p_value:.2g}, probability of the name {self.probability:.2g}, held out {before:.4g} → {after:.4g} mm"
        return f"<p>{escape(words)}</p>{self.parameters._repr_html_()}{figure}"


class Discovery:
    """The result of a search: effects, verdict, and the enlarged fit."""

    __slots__ = ("_core", "_summary")

    def __init__(self, core: _core.Discovery) -> None:
        self._core = core
        self._summary: dict[str, Any] = json.loads(core.summary())

    @property
    def summary(self) -> dict[str, Any]:
        """discovery.json."""
        return self._summary

    @property
    def verdict(self) -> str:
        """``adequate``, ``unexplained`` or ``undecided``."""
        return str(self._summary["verdict"])

    @property
    def warnings(self) -> list[str]:
        """What a user should know of sessions and landmarks."""
        return self._core.remarks()

    @property
    def incomplete(self) -> bool:
        """Whether the search was interrupted: there may be more effects."""
        return self._summary.get("incomplete") is not None

    @property
    def effects(self) -> list[Finding]:
        """Effects that the declared model lacks, in the order in which they were added."""
        figures = dict(self._core.figures()) if self._summary["effects"] and not self.incomplete else {}
        return [Finding(entry, figures.get(f"effect_{k}.svg")) for k, entry in enumerate(self._summary["effects"], 1)]

    @property
    def noise_floor_mm(self) -> float | None:
        """Repeatability limit: expected 3-D RMS of a new row if the model were perfect, mm; None where it is not known."""
        floor = self._summary.get("noise_floor_mm")
        return None if floor is None else float(floor)

    @property
    def fit(self) -> Fit:
        """The enlarged fit."""
        return Fit(self._core.fit())

    @property
    def rivals(self) -> list[Rival]:
        """Fits of competing hypotheses, where they were asked for: for `plan`."""
        return [Rival(finding, words, Fit(fit)) for finding, words, fit in self._core.rivals()]

    def report(self, folder: Path) -> None:
        """Writes the report into a folder: `index.html`, its figures (SVG) and `discovery.json`."""
        self._core.write_report(os.fspath(folder))

    @property
    def figures(self) -> dict[str, str]:
        """Figures of the report: name → SVG."""
        return dict(self._core.figures())

    def __str__(self) -> str:
        return self._core.text()

    def __repr__(self) -> str:
        found = ", ".join(effect.title for effect in self.effects) or "no effects"
        return f"Discovery({self.verdict}: {found})"

    def _repr_html_(self) -> str:
        before, after = (self._summary[key]["holdout"] for key in ("before", "after"))
        rms = "" if not before or not after else f": held-out RMS {before['rms_mm']:.4g} → {after['rms_mm']:.4g} mm"
        parts = [f"<p><b>{escape(self._summary['robot'])}</b>, {escape(self.verdict)}{rms}</p>"]
        parts += [effect._repr_html_() for effect in self.effects]
        return "".join(parts)
