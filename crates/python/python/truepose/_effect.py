"""Effects: declared by name, or written in Python; and hypotheses, with which an effect of your own is discovered."""

from __future__ import annotations

import os
from abc import ABC, abstractmethod
from collections.abc import Iterable, Mapping, Sequence
from dataclasses import dataclass, field
from typing import TYPE_CHECKING, Any, ClassVar, TypeAlias

from numpy.typing import ArrayLike

from truepose._arrays import Floats, Path
from truepose._core import InputError

if TYPE_CHECKING:
    from truepose._robot import Robot


class Declared:
    """A built-in effect by its family and keys, as a model file has them; `truepose.Geometric` and its siblings name the keys."""

    family: str

    def __init__(self, family: str | None = None, /, **keys: Any) -> None:
        if family is not None:
            self.family = family
        self._keys = {key: value for key, value in keys.items() if value is not None}

    def to_toml(self) -> str:
        """The effect as a model file has it."""
        from truepose._robot import _text, _value

        lines = ["[[effects]]", f"family = {_text(self.family)}"]
        return "\n".join(lines + [f"{key} = {_value(value)}" for key, value in self._keys.items()]) + "\n"

    def __eq__(self, other: object) -> bool:
        return isinstance(other, Declared) and self.to_toml() == other.to_toml()

    def __hash__(self) -> int:
        return hash(self.to_toml())

    def __repr__(self) -> str:
        keys = ", ".join(f"{key}={value!r}" for key, value in self._keys.items())
        return f"{type(self).__name__}({keys})"


@dataclass(frozen=True)
class Column:
    """An unknown of an effect that is written in Python: where a unit of it acts, and how large it is expected to be.

    `along`: the joint's own motion, rad or m; or `frame` (``base``, a joint's name for the frame behind that joint, ``tool``) or `target` with a
    `component` of ``x y z rx ry rz``. `size` is the expected size in `unit`: it scales the column and is its prior standard deviation.
    """

    name: str
    size: float
    unit: str = "1"
    along: str | None = None
    frame: str | None = None
    target: str | None = None
    component: str | None = None


@dataclass(frozen=True)
class Postures:
    """A batch of n postures, as an effect sees them.

    `q` n × dof: joint values (variables), rad or m; `signals`: what the effect `needs`, each n; `loads` n × dof: loads about (N·m) or along (N)
    each joint's axis, where the effect asks for `loads` (else n × 0).
    """

    joints: Sequence[str]
    q: Floats
    signals: Mapping[str, Floats]
    loads: Floats

    def __len__(self) -> int:
        return len(self.q)

    def joint(self, name: str) -> Floats:
        """Values of a joint, n."""
        return self.q[:, list(self.joints).index(name)]

    def load(self, name: str) -> Floats:
        """Loads about or along a joint's axis, n."""
        return self.loads[:, list(self.joints).index(name)]


class Effect(ABC):
    """An effect that is written in Python: an error source with its own columns of Φ.

    A subclass names its `family` (with a prefix), its `columns`, and evaluates Φ in a batch of postures. It may depend on joint values, on the signals
    in `needs` (channels by name, ``time``, ``approach_<joint>``) and, with `loads`, on the loads of the joints; on nothing else, since answers are
    kept. Its parameters are its attributes: they are written into fits and given back to the class when one is loaded.

    Examples
    --------
    >>> class EncoderGain(tp.Effect):
    ...     family = "acme/encoder_gain"
    ...     def __init__(self, joint):
    ...         self.joint = joint
    ...     def columns(self, robot):
    ...         return [tp.Column(f"gain {self.joint}", size=1e-3, along=self.joint)]
    ...     def evaluate(self, at):
    ...         return at.joint(self.joint)[:, None]
    """

    family: ClassVar[str]
    needs: ClassVar[Sequence[str]] = ()
    loads: ClassVar[bool] = False

    @abstractmethod
    def columns(self, robot: Robot) -> Sequence[Column]:
        """The unknowns on this robot."""

    @abstractmethod
    def evaluate(self, at: Postures) -> ArrayLike:
        """Error per unit of each unknown, rad or m: n × columns."""

    def parameters(self) -> Mapping[str, Any]:
        """What the fit file stores: numbers, texts, lists and mappings of such. Default: the attributes."""
        return dict(vars(self))

    @classmethod
    def from_parameters(cls, parameters: Mapping[str, Any]) -> Effect:
        """The effect with these parameters. Default: the constructor with them as keywords."""
        return cls(**parameters)


@dataclass(frozen=True)
class Setting:
    """What a hypothesis needs to know: the robot, the range over which each joint was moved (None: it never moved), and the channels of the data."""

    robot: Robot
    _ranges: Sequence[tuple[str, tuple[float, float] | None]] = field(repr=False)
    channels: Sequence[str]

    @property
    def ranges(self) -> Mapping[str, tuple[float, float] | None]:
        """Range of each joint in the data, rad or m."""
        return dict(self._ranges)

    @property
    def moved(self) -> Sequence[str]:
        """Joints that moved."""
        return [joint for joint, visited in self._ranges if visited is not None]


@dataclass(frozen=True)
class Variant:
    """One form of a hypothesis at one place: the effect that would be added, and where it is."""

    effect: Effect
    joint: str | None = None
    component: str | None = None
    channel: str | None = None


class Hypothesis(ABC):
    """Where a search suspects an effect of your own. Passed to `truepose.discover` as ``hypotheses=[…]``.

    Examples
    --------
    >>> class EncoderGains(tp.Hypothesis):
    ...     family = "acme/encoder_gain"
    ...     def variants(self, setting):
    ...         return [tp.Variant(EncoderGain(joint), joint=joint) for joint in setting.moved]
    ...     def meaning(self, joint):
    ...         return f"The encoder of {joint} reads a constant fraction off."
    """

    family: ClassVar[str]

    @abstractmethod
    def variants(self, setting: Setting) -> Iterable[Variant]:
        """All variants for a robot and its data, from few to many coefficients."""

    @abstractmethod
    def meaning(self, joint: str) -> str:
        """One sentence: what a finding there means, and what to look at."""


Model: TypeAlias = "Declared | Effect | Path | Sequence[Declared | Effect | Mapping[str, Any]] | None"
"""A declared model: a model file, an effect, or a list of effects; None: constant errors of every frame and target."""


def items(model: Model) -> list[tuple[str, Any]] | None:
    """A model as the compiled part takes it."""
    if model is None:
        return None
    if isinstance(model, (str, os.PathLike)):
        return [("file", os.fspath(model))]
    if isinstance(model, (Declared, Effect)):
        return [_item(model)]
    try:
        listed = list(model)
    except TypeError:
        raise InputError(f"a model is a list of effects or a file, and not {type(model).__name__}") from None
    return [_item(effect) for effect in listed]


def _item(effect: Declared | Effect | Mapping[str, Any]) -> tuple[str, Any]:
    if isinstance(effect, Declared):
        return "text", effect.to_toml()
    if isinstance(effect, Effect):
        return "object", effect
    if isinstance(effect, Mapping) and isinstance(effect.get("family"), str):
        return "text", Declared(effect["family"], **{key: value for key, value in effect.items() if key != "family"}).to_toml()
    raise InputError(f"an effect is one of truepose.Geometric and its siblings, or of a subclass of truepose.Effect, and not {effect!r:.80}")
