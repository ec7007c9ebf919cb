"""First calibration: a robot, a table of measured poses, a fit, and commands that bring the real robot where it should be."""

from pathlib import Path

import truepose as tp

FOLDER = Path(__file__).resolve().parents[1] / "01_identify"


def main() -> None:
    # The maker's dimensions, and 120 measured poses of three reflectors (CSV; a frame of pandas or polars, or arrays, do as well).
    robot = tp.Robot.from_toml(FOLDER / "robot.toml")
    measured = tp.read(robot, FOLDER / "measurements.csv")
    print(measured)

    # What is declared: constant errors everywhere, and joints that yield.
    fit = tp.identify(robot, measured, model=FOLDER / "model.toml")
    print(fit.verdict)
    print(f"held-out RMS: {1e3 * fit.held_out.rms:.3f} mm")
    for group, unit, value, half in list(zip(*fit.groups.values()))[:5]:
        print(f"  {group}: {value:.3g} ± {half:.2g} {unit}")

    # Where is the tool really, and which joint values bring it where it should be?
    q = robot.spread(3)
    wanted = robot.fk(q)[:, :3, 3]
    print("error without compensation, mm:", (1e3 * (fit.predict(q).position - wanted)).round(2).tolist())
    commands = fit.compensate(wanted, seed=q)
    left = fit.predict(commands.q).position - wanted
    print("status:", commands.status, "left, mm:", float(1e3 * abs(left).max()).__round__(6))

    fit.save("fit.json")
    fit.report("report")


if __name__ == "__main__":
    main()
