use super::*;
use truepose_kinematics::samples;

const NEEDS: Needs = Needs { joints: true, measured: true, position: false };

fn parse(text: &str) -> Result<(Header, Vec<String>), String> {
    let mut warnings = Vec::new();
    let (chain, map) = (samples::scara(), crate::ColumnMap::default());
    let names = Names { chain: &chain, map: &map };
    Header::parse(Path::new("d.csv"), 1, text.as_bytes(), &names, &Sample::default(), NEEDS, &mut warnings)
        .map(|header| (header, warnings.iter().map(Warning::to_string).collect()))
        .map_err(|error| error.to_string())
}

#[test]
fn columns_that_belong_together() {
    let joints = "r1[rad],r2[deg],slide[mm],r4[rad]";
    let with = |rest: &str| parse(&format!("{joints},{rest}"));
    let (header, warnings) = with("x[mm],y[mm],z[mm],temp[K],payload[kg]").unwrap();
    assert_eq!(header.slots.joints, Some(vec![0, 1, 2, 3]));
    assert_eq!(header.schema(&samples::scara()).channels[0].unit, "degC");
    assert_eq!(
        warnings,
        [
            "d.csv:1: column `payload[kg]` (9): has no centre of gravity: the tool's origin is assumed (the point that is measured, where tool \
             and targets are not known); give it with `--map \"cz=120mm\"` for all rows, in the tool frame, or in columns `cx[mm]`, `cy[mm]`, `cz[mm]`"
        ]
    );
    for (rest, message) in [
        (
            "x[mm],y[mm]",
            "d.csv:1: column `x[mm]` (5): column `z` is missing; x y z belong together (a cell may be empty where \
             nothing was measured)",
        ),
        (
            "x[mm],y[mm],z[mm],x[m]",
            "d.csv:1: column `x[m]` (8): column 5 is called `x`, too; remove one of them",
        ),
        (
            "qw,qx,qy,qz,rx[rad],ry[rad],rz[rad]",
            "d.csv:1: column `rx[rad]` (9): the orientation is given twice, as a quaternion and as a rotation vector; \
             remove one of them",
        ),
        (
            "x[mm],y[mm],z[mm],cx[mm],cy[mm],cz[mm]",
            "d.csv:1: column `cx[mm]` (8): a centre of gravity needs a mass; add `payload[kg]`",
        ),
        (
            "temp[K]",
            "d.csv:1: no columns hold anything measured; add `x[mm]`, `y[mm]`, `z[mm]` (columns here: r1[rad], \
             r2[deg], slide[mm], r4[rad], temp[K])",
        ),
    ] {
        assert_eq!(with(rest).unwrap_err(), message);
    }
}

#[test]
fn a_missing_joint_is_reported() {
    assert_eq!(
        parse("r1[rad],r2[deg],slyde[mm],r4[rad],x[m],y[m],z[m]").unwrap_err(),
        "d.csv:1: joint `slide` has no column; add `slide[m]` or `slide[mm]` (columns here: r1[rad], r2[deg], slyde[mm], \
         r4[rad], x[m], y[m], z[m])\nperhaps they are meant by: --map \"slide=slyde[mm]\"\nor in the robot's TOML:\n\
         [columns]\nslide = \"slyde[mm]\""
    );
}

#[test]
fn other_separators_are_reported() {
    assert_eq!(
        parse("r1[rad];r2[deg]").unwrap_err(),
        "d.csv:1: columns are separated by `;`; separate them by commas and write decimals with a point"
    );
    assert!(parse("r1\tr2").unwrap_err().contains("separated by tabs"));
    assert!(parse("r1,r2\rx").unwrap_err().contains("lone carriage return"));
    assert!(parse("r1,\"r2").unwrap_err().contains("a quote in the header does not end"));
}
