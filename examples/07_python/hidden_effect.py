"""A hidden effect: the search finds what the declared model lacks, and says how sure it is."""

from pathlib import Path

import truepose as tp

FOLDER = Path(__file__).resolve().parents[1] / "01_identify"


def main() -> None:
    robot = tp.Robot.from_toml(FOLDER / "robot.toml")
    found = tp.discover(robot, FOLDER / "measurements.csv", model=FOLDER / "model.toml", progress=print)
    print(found.verdict)
    for effect in found.effects:
        before, after = effect.held_out_mm
        print(f"{effect.title}: p = {effect.p_value:.1g}, probability of the name {effect.probability:.2f}, held out {before:.3f} → {after:.3f} mm")
        for name, value, unit, low, high in zip(*effect.parameters.values()):
            print(f"  {name} = {value:.3g} {unit} ({low:.3g} to {high:.3g})")
    found.report("report")
    found.fit.save("fit.json")


if __name__ == "__main__":
    main()
