"""An effect of your own: written in Python, fitted, stored, and discovered on a simulated SCARA."""

from collections.abc import Iterable, Sequence

import numpy as np
from numpy.typing import ArrayLike

import truepose as tp


class EncoderGain(tp.Effect):
    """An encoder that reads a constant fraction too little: δq = g q."""

    family = "acme/encoder_gain"

    def __init__(self, joint: str) -> None:
        self.joint = joint

    def columns(self, robot: tp.Robot) -> Sequence[tp.Column]:
        return [tp.Column(f"gain {self.joint}", size=1e-3, along=self.joint)]

    def evaluate(self, at: tp.Postures) -> ArrayLike:
        return at.joint(self.joint)[:, None]


class EncoderGains(tp.Hypothesis):
    """Some joint's encoder reads a constant fraction off."""

    family = "acme/encoder_gain"

    def variants(self, setting: tp.Setting) -> Iterable[tp.Variant]:
        return [tp.Variant(EncoderGain(joint), joint=joint) for joint in setting.moved]

    def meaning(self, joint: str) -> str:
        return f"The encoder of {joint} reads a constant fraction off. Check its line count and gear ratio."


def main() -> None:
    robot = tp.Robot.from_dh(
        [{"a": 0.4, "limits": (-2.5, 2.5)}, {"a": 0.3, "limits": (-2.2, 2.2)}, {"type": "prismatic", "limits": (0, 0.3)}, {}],
        name="scara",
    )
    # The real robot, by plain arithmetic: its second joint moves 1.001 times as far as it says.
    q = robot.spread(200)
    one, two = q[:, 0], q[:, 0] + 1.001 * q[:, 1]
    position = np.stack([0.4 * np.cos(one) + 0.3 * np.cos(two), 0.4 * np.sin(one) + 0.3 * np.sin(two), q[:, 2]], axis=1)
    position += np.random.default_rng(7).normal(scale=2e-5, size=position.shape)

    declared = tp.identify(robot, q=q, position=position)
    enlarged = tp.identify(robot, q=q, position=position, model=[tp.Geometric(), EncoderGain("j2")])
    print(f"held-out RMS: {1e6 * declared.held_out.rms:.0f} µm, with the effect {1e6 * enlarged.held_out.rms:.0f} µm")

    enlarged.save("fit.json")
    again = tp.load("fit.json", effects=[EncoderGain])
    assert np.array_equal(again.predict(q).position, enlarged.predict(q).position)

    # A built-in hypothesis (transmission) has the same curve; without it the search has to find ours.
    found = tp.discover(robot, q=q, position=position, hypotheses=[EncoderGains()], without=["transmission"])
    for effect in found.effects:
        print(f"{effect.title}: {effect.entry['meaning']}")


if __name__ == "__main__":
    main()
