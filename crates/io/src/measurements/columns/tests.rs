use super::*;
use truepose_kinematics::samples;

fn parse(header: &str) -> Result<(Column, Option<String>), String> {
    Column::parse(header, &samples::pps(), 0)
}

#[test]
fn headers_are_understood() {
    let (column, warning) = parse(" theta [ deg ] ").unwrap();
    assert_eq!((column.name.as_str(), column.unit.as_str(), column.role), ("theta", "deg", Role::Joint(3)));
    assert_eq!(warning, None);
    assert_eq!(parse("d1[mm]").unwrap().0.meaning, "value of prismatic joint 1");
    assert_eq!(parse("approach_roll").unwrap().0.role, Role::Approach(4));
    let (channel, warning) = parse("temperature[K]").unwrap();
    assert_eq!((channel.role, channel.unit.as_str(), warning), (Role::Channel(0), "K", None));
    assert_eq!(channel.meaning, "channel, a temperature");
    assert_eq!(parse("humidity[%]").unwrap().0.unit, "%");
    let say = |header: &str| parse(header).unwrap().1.unwrap();
    assert_eq!(say("x"), "has no unit and is taken as [m]; write `x[m]`");
    assert_eq!(say("paylod[kg]"), "is taken as a channel; did you mean `payload`?");
}

#[test]
fn bad_headers_are_reported() {
    for (header, message) in [
        ("", "has no name; name the column in the header, or remove it"),
        ("[mm]", "has no name; name the column in the header, or remove it"),
        ("x[mm", "a header is `name` or `name[unit]`; close the bracket at its end"),
        ("x mm]", "a header is `name` or `name[unit]`; open the bracket"),
        ("x[]", "the unit is empty; write `x[1]` for a plain number"),
        ("x[deg]", "[deg] is the unit of an angle, but `x` is a length; its unit can be: m, mm, um, in"),
        ("d1[rad]", "[rad] is the unit of an angle, but `d1` is a length; its unit can be: m, mm, um, in"),
        (
            "theta[dEg]",
            "unknown unit [dEg]; did you mean [deg]? (`theta` is an angle; its unit can be: rad, deg, mrad)",
        ),
        ("payload[t]", "unknown unit [t] (`payload` is a mass; its unit can be: kg, lb)"),
        (
            "d4[mm]",
            "the robot has no moving joint `d4` (its joints: d1, d2, d3, theta, roll, pitch); remove the column, or \
             give it another name if it is a channel",
        ),
        (
            "approach_rol",
            "the robot has no moving joint `rol`; did you mean `roll`? (its joints: d1, d2, d3, theta, roll, pitch)",
        ),
    ] {
        assert_eq!(parse(header).unwrap_err(), message);
    }
    assert_eq!(
        Column::parse("flange[rad]", &samples::skewed(), 0).unwrap_err(),
        "joint `flange` is fixed and has no values; remove the column"
    );
}
