"""Effects that are written in Python: fitted, discovered, stored, and wrong in every way."""

from __future__ import annotations

import pickle
from collections.abc import Iterable, Mapping, Sequence
from pathlib import Path
from typing import Any

import numpy as np
import pytest
from numpy.typing import ArrayLike

import truepose as tp


class EncoderGain(tp.Effect):
    """An encoder that reads a constant fraction too little."""

    family = "acme/encoder_gain"

    def __init__(self, joint: str) -> None:
        self.joint = joint

    def columns(self, robot: tp.Robot) -> Sequence[tp.Column]:
        assert self.joint in [joint.name for joint in robot.joints]
        return [tp.Column(f"gain {self.joint}", size=1e-3, along=self.joint)]

    def evaluate(self, at: tp.Postures) -> ArrayLike:
        assert at.q.shape == (len(at), len(at.joints)) and at.loads.shape == (len(at), 0)
        return at.joint(self.joint)[:, None]


class EncoderGains(tp.Hypothesis):
    family = "acme/encoder_gain"

    def variants(self, setting: tp.Setting) -> Iterable[tp.Variant]:
        return [tp.Variant(EncoderGain(joint), joint=joint) for joint in setting.moved]

    def meaning(self, joint: str) -> str:
        return f"The encoder of {joint} reads a constant fraction off."


Bent = tuple[np.ndarray, np.ndarray]


def test_an_effect_is_fitted(scara: tp.Robot, bent: Bent) -> None:
    q, position = bent
    fit = tp.identify(scara, q=q, position=position, model=[tp.Geometric(["base"]), EncoderGain("j2")])
    gain = fit.coefficients.to_pandas().set_index("name").loc["gain j2"]
    assert gain["family"] == "acme/encoder_gain"
    assert abs(gain["value"] - 1e-3) < 4 * gain["sd"] and gain["sd"] < 2e-5
    assert fit.held_out.rms < 5e-5
    plain = tp.identify(scara, q=q, position=position, model=[tp.Geometric(["base"])])
    assert plain.held_out.rms > 1e-4


def test_it_is_the_same_as_the_built_in_effect_of_its_columns(scara: tp.Robot, bent: Bent) -> None:
    q, position = bent
    own = tp.identify(scara, q=q, position=position, model=[tp.Geometric(["base"]), EncoderGain("j2")])
    built_in = tp.identify(scara, q=q, position=position, model=[tp.Geometric(["base"]), tp.Transmission("j2", mode="gain")])
    a, b = (dict(zip(fit.coefficients["name"], fit.coefficients["value"])) for fit in (own, built_in))
    assert a["gain j2"] == pytest.approx(b["gain j2"], rel=1e-2)
    np.testing.assert_allclose(own.predict(q).position, built_in.predict(q).position, atol=1e-6)


def test_a_fit_with_it_is_stored_and_used(scara: tp.Robot, bent: Bent, tmp_path: Path) -> None:
    q, position = bent
    fit = tp.identify(scara, q=q, position=position, model=[tp.Geometric(["base"]), EncoderGain("j2")])
    fit.save(tmp_path / "fit.json")
    with pytest.raises(tp.InputError, match="acme/encoder_gain"):
        tp.load(tmp_path / "fit.json")
    again = tp.load(tmp_path / "fit.json", effects=[EncoderGain])
    np.testing.assert_array_equal(again.predict(q).position, fit.predict(q).position)
    assert pickle.loads(pickle.dumps(fit)).to_json() == again.to_json() == fit.to_json()
    commands = again.compensate(position[:10] + [0, 0, 0.01], seed=q[:10])
    assert commands.ok.all()
    np.testing.assert_allclose(again.predict(commands.q).position, position[:10] + [0, 0, 0.01], atol=1e-9)


def test_it_is_discovered(scara: tp.Robot, bent: Bent) -> None:
    q, position = bent
    model = [tp.Geometric()]
    found = tp.discover(scara, q=q, position=position, model=model, hypotheses=[EncoderGains()], without=["transmission", "unmodelled"])
    assert [(effect.family, effect.joint) for effect in found.effects] == [("acme/encoder_gain", "j2")]
    assert found.effects[0].entry["meaning"] == "The encoder of j2 reads a constant fraction off."
    (gain,) = found.effects[0].parameters["value"]
    assert gain == pytest.approx(1e-3, rel=0.05)
    assert pickle.loads(pickle.dumps(found.fit)).to_json() == found.fit.to_json()
    with pytest.raises(tp.InputError, match="no hypothesis"):
        tp.discover(scara, q=q, position=position, without=["nonsense"])


class Loaded(tp.Effect):
    """The compliance of a joint, as an effect of its own."""

    family = "acme/spring"
    loads = True

    def __init__(self, joint: str) -> None:
        self.joint = joint

    def columns(self, robot: tp.Robot) -> Sequence[tp.Column]:
        return [tp.Column("counterbalance", size=1e-5, unit="rad/(N*m)", along=self.joint)]

    def evaluate(self, at: tp.Postures) -> ArrayLike:
        return at.load(self.joint)[:, None]


def test_loads_are_those_of_the_bent_robot(robot: tp.Robot, frame: Any) -> None:
    rows = tp.measurements(robot, frame)
    declared: list[Any] = [tp.Geometric(), tp.JointCompliance(["a2"])]
    built_in = tp.identify(robot, rows, model=declared, folds=0, prior="none")
    own = tp.identify(robot, rows, model=[tp.Geometric(), Loaded("a2")], folds=0, prior="none")
    values = [dict(zip(fit.coefficients["name"], fit.coefficients["value"])) for fit in (built_in, own)]
    assert values[1]["counterbalance"] == pytest.approx(values[0]["compliance a2"], rel=1e-6)
    np.testing.assert_allclose(own.predict(rows).position, built_in.predict(rows).position, atol=1e-9)


class Warm(tp.Effect):
    """A height that follows a temperature."""

    family = "acme/warm"
    needs = ("oil",)

    def columns(self, robot: tp.Robot) -> Sequence[tp.Column]:
        return [tp.Column("growth", size=1e-5, unit="m/K", frame="base", component="z")]

    def evaluate(self, at: tp.Postures) -> ArrayLike:
        return at.signals["oil"][:, None] - 20.0


def test_channels(scara: tp.Robot, bent: Bent) -> None:
    q, position = bent
    oil = np.linspace(20, 40, len(q))
    arrays: dict[str, Any] = {"q": q, "position": position + np.outer(2e-5 * (oil - 20), [0, 0, 1]), "channels": {"oil[degC]": oil}}
    fit = tp.identify(scara, model=[tp.Geometric(), Warm()], **arrays)
    assert dict(zip(fit.coefficients["name"], fit.coefficients["value"]))["growth"] == pytest.approx(2e-5, rel=0.02)
    with pytest.raises(tp.InputError, match="oil"):
        tp.identify(scara, q=q, position=position, model=[tp.Geometric(), Warm()])
    with pytest.raises(tp.InputError, match="oil"):
        fit.predict(q)


def wrong(answer: Any = None, family: str = "acme/wrong", column: Any = None, parameters: Any = None) -> tp.Effect:
    class Wrong(tp.Effect):
        def columns(self, robot: tp.Robot) -> Sequence[tp.Column]:
            return [column or tp.Column("c", size=1e-3, along="j1")]

        def evaluate(self, at: tp.Postures) -> ArrayLike:
            return answer(at) if callable(answer) else answer  # type: ignore[no-any-return]

        def parameters(self) -> Mapping[str, Any]:
            return parameters if parameters is not None else {}

    Wrong.family = family
    return Wrong()


def raises(at: tp.Postures) -> ArrayLike:
    raise ZeroDivisionError("mine")


armed = False


def sometimes(at: tp.Postures) -> ArrayLike:
    if armed:
        raise ZeroDivisionError("later")
    return at.q[:, :1]


@pytest.mark.parametrize(
    ("effect", "error", "words"),
    [
        (wrong(raises), ZeroDivisionError, "mine"),
        (wrong(None), tp.InputError, "array of numbers|shape|finite"),
        (wrong("text"), tp.InputError, "array of numbers"),
        (wrong(object()), tp.InputError, "array of numbers"),
        (wrong(lambda at: at.q[:, 0]), tp.InputError, "returned the shape"),
        (wrong(lambda at: at.q), tp.InputError, "200 × 1 numbers and returned 200 × 4"),
        (wrong(lambda at: at.q[1:, :1]), tp.InputError, "returned 199 × 1"),
        (wrong(lambda at: np.where(np.arange(len(at)) == 6, np.nan, 1.0)[:, None]), tp.InputError, "row 7.*not finite"),
        (wrong(lambda at: at.joint("j9")[:, None]), ValueError, "j9"),
        (wrong(1.0, family="wrong"), tp.InputError, "prefix"),
        (wrong(1.0, family="acme/my effect"), tp.InputError, "prefix"),
        (wrong(1.0, column=tp.Column("c", size=0.0, along="j1")), tp.InputError, "size"),
        (wrong(1.0, column=tp.Column("c", size=1.0, along="j9")), tp.InputError, "no joint `j9`"),
        (wrong(1.0, column=tp.Column("c", size=1.0, frame="j1")), tp.InputError, "component"),
        (wrong(1.0, column=tp.Column("c", size=1.0, frame="j1", component="w")), tp.InputError, "no component"),
        (wrong(1.0, column=tp.Column("c", size=1.0, frame="j1", along="j1")), tp.InputError, "one of"),
        (wrong(1.0, column=tp.Column("c", size=1.0)), tp.InputError, "one of"),
        (wrong(1.0, column=3), AttributeError, "name"),
        (wrong(1.0, parameters={"a": object()}), tp.InputError, "JSON"),
        (wrong(lambda at: at.q[:, :1], parameters={"a": {1: 2}}), None, ""),
    ],
)
def test_a_wrong_effect_is_an_exception(scara: tp.Robot, bent: Bent, effect: tp.Effect, error: Any, words: str) -> None:
    q, position = bent
    if error is None:
        tp.identify(scara, q=q, position=position, model=[tp.Geometric(), effect])
        return
    with pytest.raises(error, match=words) as raised:
        tp.identify(scara, q=q, position=position, model=[tp.Geometric(), effect])
    if "row 7" in words:
        assert raised.value.row == 7


def test_an_effect_that_raises_later_ends_the_call_with_its_exception(scara: tp.Robot, bent: Bent) -> None:
    q, position = bent
    global armed
    fit = tp.identify(scara, q=q, position=position, model=[tp.Geometric(), wrong(sometimes)], folds=0)
    armed = True
    for _ in range(2):
        with pytest.raises(ZeroDivisionError, match="later"):
            fit.predict(q[:3] + 0.01)
        with pytest.raises(ZeroDivisionError, match="later"):
            fit.compensate(position[:3], seed=q[:3])


def test_a_hypothesis_that_is_wrong_is_an_exception(scara: tp.Robot, bent: Bent) -> None:
    q, position = bent

    class Raises(EncoderGains):
        def variants(self, setting: tp.Setting) -> Iterable[tp.Variant]:
            raise ZeroDivisionError("mine")

    class Rubbish(EncoderGains):
        def variants(self, setting: tp.Setting) -> Iterable[tp.Variant]:
            return [3]  # type: ignore[list-item]

    with pytest.raises(ZeroDivisionError, match="mine"):
        tp.discover(scara, q=q, position=position, hypotheses=[Raises()])
    with pytest.raises(AttributeError):
        tp.discover(scara, q=q, position=position, hypotheses=[Rubbish()])
