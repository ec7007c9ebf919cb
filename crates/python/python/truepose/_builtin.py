"""The built-in effects of a declared model, with the names, keys and defaults of model files (docs/files.md, section 3)."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from typing import Any

from truepose._effect import Declared

__all__ = [
    "Geometric",
    "JointCompliance",
    "LinkCompliance",
    "BaseCompliance",
    "LoadNonlinearity",
    "Transmission",
    "Backlash",
    "Coupling",
    "Guideway",
    "Thermal",
    "Drift",
    "Shift",
    "Instrument",
    "Polynomial",
    "Expansion",
]


class Geometric(Declared):
    """Constant errors of frames and targets.

    Parameters
    ----------
    frames: frames (`base`, joints, `tool`, ``"targets"``); default: all
    components: of ``x y z rx ry rz``; default: all
    bounds: lowest and highest value of its unknowns, SI units, for solvers that support bounds
    """

    family = "geometric"

    def __init__(
        self,
        frames: Sequence[str] | None = None,
        *,
        components: Sequence[str] | None = None,
        bounds: Sequence[float] | None = None,
    ) -> None:
        super().__init__(
            frames=frames,
            components=components,
            bounds=bounds,
        )


class JointCompliance(Declared):
    """A joint yields in proportion to its load; a compliance is positive when the joint yields with the load.

    Parameters
    ----------
    joints: default: every one that moves
    channel: the measured torque of the one joint that `joints` names is its load
    bounds: lowest and highest value of its unknowns, SI units, for solvers that support bounds
    """

    family = "joint_compliance"

    def __init__(
        self,
        joints: Sequence[str] | None = None,
        *,
        channel: str | None = None,
        bounds: Sequence[float] | None = None,
    ) -> None:
        super().__init__(
            joints=joints,
            channel=channel,
            bounds=bounds,
        )


class LinkCompliance(Declared):
    """A link bends and twists under the wrench at its tip and under its own weight, as a beam.

    Parameters
    ----------
    joints: joints in front of the links; default: all with a link of some length
    section: ``tube``, ``symmetric`` or ``general`` (default)
    own_weight: ``declared`` (default) or ``free``
    links: how many links beyond have free weights with arms of their own (default 0)
    bounds: lowest and highest value of its unknowns, SI units, for solvers that support bounds
    """

    family = "link_compliance"

    def __init__(
        self,
        joints: Sequence[str] | None = None,
        *,
        section: str | None = None,
        own_weight: str | None = None,
        links: int | None = None,
        bounds: Sequence[float] | None = None,
    ) -> None:
        super().__init__(
            joints=joints,
            section=section,
            own_weight=own_weight,
            links=links,
            bounds=bounds,
        )


class BaseCompliance(Declared):
    """The base tilts and sinks under the load that it carries.

    Parameters
    ----------
    tilt: ``isotropic`` (default) or ``separate``
    sink: default: true
    own_weight: ``declared`` (default), or ``free``: moments of links without a declared weight are unknowns
    links: how many links, from the first that moves, have a free weight (default 3)
    bounds: lowest and highest value of its unknowns, SI units, for solvers that support bounds
    """

    family = "base_compliance"

    def __init__(
        self,
        tilt: str | None = None,
        *,
        sink: bool | None = None,
        own_weight: str | None = None,
        links: int | None = None,
        bounds: Sequence[float] | None = None,
    ) -> None:
        super().__init__(
            tilt=tilt,
            sink=sink,
            own_weight=own_weight,
            links=links,
            bounds=bounds,
        )


class LoadNonlinearity(Declared):
    """Deflection that is not proportional to the load.

    Parameters
    ----------
    joint: the joint
    powers: default: 2 and 3, without a soft range
    soft_load: N·m or N
    soft_range: where it is looked for
    bounds: lowest and highest value of its unknowns, SI units, for solvers that support bounds
    """

    family = "load_nonlinearity"

    def __init__(
        self,
        joint: str,
        *,
        powers: Sequence[float] | None = None,
        soft_load: float | None = None,
        soft_range: Sequence[float] | None = None,
        bounds: Sequence[float] | None = None,
    ) -> None:
        super().__init__(
            joint=joint,
            powers=powers,
            soft_load=soft_load,
            soft_range=soft_range,
            bounds=bounds,
        )


class Transmission(Declared):
    """Transmission error: periodic in the joint's own motion, in proportion to it, or a smooth curve.

    Parameters
    ----------
    joint: the joint
    mode: ``periodic`` (default), ``gain`` or ``curve``
    harmonics: default: 1
    period: rad or m; default: one turn
    period_range: where it is looked for
    by_load: amplitude with a part in proportion to the load
    range: of a curve
    pieces: of a curve
    bounds: lowest and highest value of its unknowns, SI units, for solvers that support bounds
    """

    family = "transmission"

    def __init__(
        self,
        joint: str,
        *,
        mode: str | None = None,
        harmonics: Sequence[int] | None = None,
        period: float | None = None,
        period_range: Sequence[float] | None = None,
        by_load: bool | None = None,
        range: Sequence[float] | None = None,
        pieces: int | None = None,
        bounds: Sequence[float] | None = None,
    ) -> None:
        super().__init__(
            joint=joint,
            mode=mode,
            harmonics=harmonics,
            period=period,
            period_range=period_range,
            by_load=by_load,
            range=range,
            pieces=pieces,
            bounds=bounds,
        )


class Backlash(Declared):
    """Joint error that switches with the direction of the last move or of the load.

    Parameters
    ----------
    joint: the joint
    side: ``approach`` (default), ``load``, ``load_then_approach``, ``by_load`` or ``presliding``
    flank_load: N·m or N
    flank_range: where it is looked for
    width: pre-sliding distance, rad or m
    width_range: where it is looked for
    bounds: lowest and highest value of its unknowns, SI units, for solvers that support bounds
    """

    family = "backlash"

    def __init__(
        self,
        joint: str,
        *,
        side: str | None = None,
        flank_load: float | None = None,
        flank_range: Sequence[float] | None = None,
        width: float | None = None,
        width_range: Sequence[float] | None = None,
        bounds: Sequence[float] | None = None,
    ) -> None:
        super().__init__(
            joint=joint,
            side=side,
            flank_load=flank_load,
            flank_range=flank_range,
            width=width,
            width_range=width_range,
            bounds=bounds,
        )


class Coupling(Declared):
    """Joint error that depends on another joint's position.

    Parameters
    ----------
    joint: the joint
    driver: the other joint
    degree: default: 1
    harmonics: default: none
    range: of the driver
    bounds: lowest and highest value of its unknowns, SI units, for solvers that support bounds
    """

    family = "coupling"

    def __init__(
        self,
        joint: str,
        driver: str,
        *,
        degree: int | None = None,
        harmonics: Sequence[int] | None = None,
        range: Sequence[float] | None = None,
        bounds: Sequence[float] | None = None,
    ) -> None:
        super().__init__(
            joint=joint,
            driver=driver,
            degree=degree,
            harmonics=harmonics,
            range=range,
            bounds=bounds,
        )


class Guideway(Declared):
    """Displacement and rotation of a slide along its travel.

    Parameters
    ----------
    joint: the prismatic joint
    components: default: all
    range: default: its limits
    pieces: default: 6
    screw: lead of a lead screw, m
    screw_range: where it is looked for
    bounds: lowest and highest value of its unknowns, SI units, for solvers that support bounds
    """

    family = "guideway"

    def __init__(
        self,
        joint: str,
        *,
        components: Sequence[str] | None = None,
        range: Sequence[float] | None = None,
        pieces: int | None = None,
        screw: float | None = None,
        screw_range: Sequence[float] | None = None,
        bounds: Sequence[float] | None = None,
    ) -> None:
        super().__init__(
            joint=joint,
            components=components,
            range=range,
            pieces=pieces,
            screw=screw,
            screw_range=screw_range,
            bounds=bounds,
        )


class Thermal(Declared):
    """Error that follows a temperature channel.

    Parameters
    ----------
    channel: the channel
    joint: the joint, or
    frame: the frame
    grows: ``length``, ``scale`` or ``motion``
    components: of a frame
    reference: degC; default: 20
    offset: scale error of a slide at the reference temperature, too
    lag: first-order time constant, s
    lag_range: where it is looked for
    bounds: lowest and highest value of its unknowns, SI units, for solvers that support bounds
    """

    family = "thermal"

    def __init__(
        self,
        channel: str,
        *,
        joint: str | None = None,
        frame: str | None = None,
        grows: str | None = None,
        components: Sequence[str] | None = None,
        reference: float | None = None,
        offset: bool | None = None,
        lag: float | None = None,
        lag_range: Sequence[float] | None = None,
        bounds: Sequence[float] | None = None,
    ) -> None:
        super().__init__(
            channel=channel,
            joint=joint,
            frame=frame,
            grows=grows,
            components=components,
            reference=reference,
            offset=offset,
            lag=lag,
            lag_range=lag_range,
            bounds=bounds,
        )


class Drift(Declared):
    """Smooth change with time.

    Parameters
    ----------
    joint: the joint, or
    frame: the frame
    range: first and last time, s
    pieces: default: 4
    components: of a frame
    time_constant: s: exponential
    time_constant_range: where it is looked for
    bounds: lowest and highest value of its unknowns, SI units, for solvers that support bounds
    """

    family = "drift"

    def __init__(
        self,
        joint: str | None = None,
        *,
        frame: str | None = None,
        range: Sequence[float] | None = None,
        pieces: int | None = None,
        components: Sequence[str] | None = None,
        time_constant: float | None = None,
        time_constant_range: Sequence[float] | None = None,
        bounds: Sequence[float] | None = None,
    ) -> None:
        super().__init__(
            joint=joint,
            frame=frame,
            range=range,
            pieces=pieces,
            components=components,
            time_constant=time_constant,
            time_constant_range=time_constant_range,
            bounds=bounds,
        )


class Shift(Declared):
    """Sudden change at one time.

    Parameters
    ----------
    at: s
    joint: the joint, or
    frame: the frame
    at_range: where it is looked for
    components: of a frame
    gap: interval without measurements that contains the change, s
    bounds: lowest and highest value of its unknowns, SI units, for solvers that support bounds
    """

    family = "shift"

    def __init__(
        self,
        at: float,
        *,
        joint: str | None = None,
        frame: str | None = None,
        at_range: Sequence[float] | None = None,
        components: Sequence[str] | None = None,
        gap: Sequence[float] | None = None,
        bounds: Sequence[float] | None = None,
    ) -> None:
        super().__init__(
            at=at,
            joint=joint,
            frame=frame,
            at_range=at_range,
            components=components,
            gap=gap,
            bounds=bounds,
        )


class Instrument(Declared):
    """Error of the measurement, not of the robot.

    Parameters
    ----------
    mode: ``lag`` or ``scale``
    joints: of a lag
    shared: one fraction for all of them
    bounds: lowest and highest value of its unknowns, SI units, for solvers that support bounds
    """

    family = "instrument"

    def __init__(
        self,
        mode: str,
        *,
        joints: Sequence[str] | None = None,
        shared: bool | None = None,
        bounds: Sequence[float] | None = None,
    ) -> None:
        super().__init__(
            mode=mode,
            joints=joints,
            shared=shared,
            bounds=bounds,
        )


class Polynomial(Declared):
    """Every error as a polynomial of its own joint, and of the wrench times the joints beyond.

    Parameters
    ----------
    wrench: components of ``fx fy fz mx my mz``
    degree: default: 3
    small: joints of `small_degree`
    small_degree: default: 1
    degrees: of every joint
    components: default: all
    wrench_of: ``tool`` (default) or ``frame``
    wrench_degree: default: 1
    order: ``expand_first`` (default) or ``reduce_first``
    bounds: lowest and highest value of its unknowns, SI units, for solvers that support bounds
    """

    family = "polynomial"

    def __init__(
        self,
        wrench: Sequence[str] | None = None,
        *,
        degree: int | None = None,
        small: Sequence[str] | None = None,
        small_degree: int | None = None,
        degrees: Sequence[int] | None = None,
        components: Sequence[str] | None = None,
        wrench_of: str | None = None,
        wrench_degree: int | None = None,
        order: str | None = None,
        bounds: Sequence[float] | None = None,
    ) -> None:
        super().__init__(
            wrench=wrench,
            degree=degree,
            small=small,
            small_degree=small_degree,
            degrees=degrees,
            components=components,
            wrench_of=wrench_of,
            wrench_degree=wrench_degree,
            order=order,
            bounds=bounds,
        )


class Expansion(Declared):
    """Any series: a place times the product of one basis for each factor.

    Parameters
    ----------
    at: the place
    factors: of each the input (`of`) and the `basis`
    bounds: lowest and highest value of its unknowns, SI units, for solvers that support bounds
    """

    family = "expansion"

    def __init__(
        self,
        at: Mapping[str, Any],
        factors: Sequence[Mapping[str, Any]],
        *,
        bounds: Sequence[float] | None = None,
    ) -> None:
        super().__init__(
            at=at,
            factors=factors,
            bounds=bounds,
        )
