"""Robot calibration: identifies geometric and elastic errors of a robot arm, finds effects that the model lacks, and compensates.

>>> import truepose as tp
>>> robot = tp.Robot.from_toml("robot.toml")  # doctest: +SKIP
>>> fit = tp.identify(robot, frame, model=[tp.Geometric(), tp.JointCompliance()])  # doctest: +SKIP
>>> fit.held_out.rms, fit.predict(q).position, fit.compensate(poses).q  # doctest: +SKIP

All arrays are in SI units (m, rad, kg, N, N·m, s); tables have the headers of files (``theta[deg]``, ``x[mm]``).
"""

from truepose import _core
from truepose._acceptance import Acceptance, iso9283
from truepose._arrays import Arrays, ArrowStream
from truepose._builtin import (
    Backlash,
    BaseCompliance,
    Coupling,
    Drift,
    Expansion,
    Geometric,
    Guideway,
    Instrument,
    JointCompliance,
    LinkCompliance,
    LoadNonlinearity,
    Polynomial,
    Shift,
    Thermal,
    Transmission,
)
from truepose._calibrator import Calibrator
from truepose._core import InputError
from truepose._data import Measurements, TrueposeWarning, measurements, read
from truepose._discovery import Discovery, Finding, Rival
from truepose._effect import Column, Declared, Effect, Hypothesis, Postures, Setting, Variant
from truepose._errors import Interrupted
from truepose._fit import Commands, Fit, HeldOut, Predictions, Residuals, load
from truepose._recording import Recording, read_mcap, standstills
from truepose._rewriting import Rewritten, rewrite
from truepose._robot import Joint, Observability, Robot, Target
from truepose._table import Table
from truepose._verbs import (
    Check,
    Comparison,
    Look,
    Plan,
    check,
    compare,
    discover,
    fleet,
    identify,
    monitor,
    plan,
    plan_monitoring,
    plan_observed,
    simulate,
    transfer,
)

__version__ = _core.VERSION

__all__ = [
    "Acceptance",
    "Arrays",
    "ArrowStream",
    "Backlash",
    "BaseCompliance",
    "Calibrator",
    "Check",
    "Column",
    "Commands",
    "Comparison",
    "Coupling",
    "Declared",
    "Discovery",
    "Drift",
    "Effect",
    "Expansion",
    "Finding",
    "Fit",
    "Geometric",
    "Guideway",
    "HeldOut",
    "Hypothesis",
    "InputError",
    "Instrument",
    "Interrupted",
    "Joint",
    "JointCompliance",
    "LinkCompliance",
    "LoadNonlinearity",
    "Look",
    "Measurements",
    "Observability",
    "Plan",
    "Polynomial",
    "Postures",
    "Predictions",
    "Recording",
    "Residuals",
    "Rewritten",
    "Rival",
    "Robot",
    "Setting",
    "Shift",
    "Table",
    "Target",
    "Thermal",
    "Transmission",
    "TrueposeWarning",
    "Variant",
    "__version__",
    "check",
    "compare",
    "discover",
    "fleet",
    "identify",
    "iso9283",
    "load",
    "measurements",
    "monitor",
    "plan",
    "plan_monitoring",
    "plan_observed",
    "read",
    "read_mcap",
    "rewrite",
    "simulate",
    "standstills",
    "transfer",
]
