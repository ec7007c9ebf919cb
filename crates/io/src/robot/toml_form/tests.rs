use crate::{RobotOptions, read_robot};
use std::f64::consts::FRAC_PI_2;
use truepose_kinematics::{Chain, GravityFrame, JointKind, Placement};

fn read(toml: &str) -> Result<Chain, String> {
    let folder = tempfile::tempdir().unwrap();
    let path = folder.path().join("r.toml");
    std::fs::write(&path, toml).unwrap();
    read_robot(&path, &RobotOptions::default())
        .map(|(chain, warnings)| {
            assert_eq!(warnings, []);
            chain
        })
        .map_err(|error| error.to_string().replace(&format!("{}/", folder.path().display()), ""))
}

const GOOD: &str = r#"
name = "pps"
gravity = [0.0, -9.81, 0.0]
gravity_frame = "base"
[units]
length = "mm"
angle = "deg"
[base]
xyz = [1000, 0, 0]
rpy = [0, 0, 90]
known = false
[[joints]]
name = "d1"
type = "prismatic"
limits = [0, 2250]
dh = { theta = 0, d = 0, a = 0, alpha = -90 }
mass = 120.0
com = [0, 0, 350]
[[joints]]
name = "theta"
type = "revolute"
limits = [-90, 90]
mdh = { alpha = 90, a = 10, theta = 0, d = 5 }
[[joints]]
name = "flange"
type = "fixed"
origin = { xyz = [0, 0, 100] }
[[joints]]
name = "roll"
type = "revolute"
origin = { xyz = [0, 0, 100], rpy = [0, 0, 0], axis = [0, 0, -2] }
[tool]
xyz = [0, 0, 50]
[[targets]]
name = "P1"
xyz = [250, 100, -840]
[[targets]]
name = "P2"
known = false
"#;

#[test]
fn units_reach_every_number() {
    let chain = read(GOOD).unwrap();
    assert_eq!(chain.name(), "pps");
    assert_eq!(chain.gravity().frame, GravityFrame::Base);
    assert!(!chain.base().known && chain.tool().known);
    assert_eq!(chain.base().pose.translation.x.to_bits(), 1.0f64.to_bits());
    assert!((chain.base().pose.rpy()[2] - FRAC_PI_2).abs() < 1e-15);
    let [slide, turn, flange, roll] = chain.joints() else { panic!("four joints") };
    assert_eq!(slide.limits, Some((0.0, 2.25)));
    assert_eq!(slide.link.unwrap().com.z.to_bits(), 0.35f64.to_bits());
    assert_eq!(slide.placement, Placement::Dh { theta: 0.0, d: 0.0, a: 0.0, alpha: -FRAC_PI_2 });
    assert_eq!(turn.limits, Some((-FRAC_PI_2, FRAC_PI_2)));
    assert_eq!(turn.placement, Placement::Mdh { alpha: FRAC_PI_2, a: 0.01, theta: 0.0, d: 0.005 });
    assert_eq!(flange.kind, JointKind::Fixed);
    assert!(matches!(roll.placement, Placement::Origin { axis, .. } if (axis.z + 1.0).abs() < 1e-15));
    assert!(!chain.targets()[1].known);
    assert_eq!(chain.targets()[0].position.z.to_bits(), (-0.84f64).to_bits());
}

#[test]
fn what_is_wrong_is_reported() {
    let change = |from: &str, to: &str| {
        assert!(GOOD.contains(from), "{from}");
        read(&GOOD.replacen(from, to, 1)).unwrap_err()
    };
    let cases = [
        (
            change("limits = [0, 2250]", "limit = [0, 2250]"),
            "r.toml:15:1: unknown key `limit` in [[joints]] 1; did you mean `limits`? \
             (known: name, type, limits, dh, mdh, origin, mass, com, parent, mimic)",
        ),
        (
            change("length = \"mm\"", "length = \"cm\""),
            "r.toml:6:10: `length` of [units] cannot be `cm` (known: m, mm, in)",
        ),
        (
            change("type = \"revolute\"", "type = \"rotary\""),
            "r.toml:21:8: `type` of [[joints]] 2 cannot be `rotary` (known: revolute, prismatic, fixed)",
        ),
        (
            change("name = \"theta\"", "name = \"d1\""),
            "r.toml:20:8: two joints have the name `d1`; names must be different",
        ),
        (
            change("name = \"theta\"", "name = \"rx\""),
            "r.toml:20:8: a joint cannot be called `rx`, which is a column of measurements with another meaning; \
             rename it",
        ),
        (
            change("mdh = {", "origin = {}\nmdh = {"),
            "r.toml:23:10: [[joints]] 2 has `mdh` and `origin`; keep exactly one of them",
        ),
        (
            change("mdh = { alpha = 90, a = 10, theta = 0, d = 5 }\n", ""),
            "r.toml:19:1: [[joints]] 2 needs one of `dh`, `mdh` and `origin`",
        ),
        (
            change("theta = 0, d = 0, a = 0, alpha", "theta = 0, d = 0, alpha"),
            "r.toml:16:6: `dh` of [[joints]] 1 lacks `a`; add it",
        ),
        (
            change("com = [0, 0, 350]\n", ""),
            "r.toml:17:8: `mass` needs `com`, the link's centre of mass in the frame after the joint; add it",
        ),
        (change("mass = 120.0", "mass = -1.0"), "r.toml:17:8: a mass cannot be negative: -1 kg"),
        (change("[0, 2250]", "[9, 2]"), "r.toml:15:10: the limits are the wrong way round: 9 > 2"),
        (
            change("[0, 2250]", "[0, inf]"),
            "r.toml:15:14: element 2 of `limits` of [[joints]] 1 has to be a finite number",
        ),
        (
            change("axis = [0, 0, -2]", "axis = [0, 0, 0]"),
            "r.toml:31:55: the axis has length zero; give a direction such as [0, 0, 1]",
        ),
        (
            change("known = false\n", "known = 0\n"),
            "r.toml:11:9: `known` of [base] has to be true or false, not an integer",
        ),
        (
            change("xyz = [250, 100, -840]\n", ""),
            "r.toml:34:1: [[targets]] 1 lacks `xyz`; add it, or `known = false`",
        ),
        (
            change("[[joints]]", "tip = \"t\"\n[[joints]]"),
            "r.toml:12:1: unknown key `tip` in [base] (known: xyz, rpy, known)",
        ),
        (
            change("name = \"pps\"", "urdf = \"a.urdf\""),
            "r.toml:2:8: `urdf` and [[joints]] exclude each other; keep one of them",
        ),
    ];
    for (message, expected) in cases {
        assert_eq!(message, expected);
    }
    assert_eq!(
        read("name = \"a\"").unwrap_err(),
        "r.toml: has neither [[joints]] nor `urdf`; a robot needs one of them"
    );
    assert_eq!(
        read(" \n").unwrap_err(),
        "r.toml: is empty; a robot description begins with its name and its joints"
    );
    assert_eq!(
        read("joints = 3").unwrap_err(),
        "r.toml:1:10: `joints` of the robot has to be an array of tables, each headed by [[joints]], not an integer"
    );
    assert!(read("name = ").unwrap_err().starts_with("r.toml:1:8: is not TOML: "));
    assert_eq!(
        read("urdf = \"none.urdf\"").unwrap_err(),
        "r.toml:1:8: there is no file `none.urdf`; the path counts from this file's folder"
    );
}

#[test]
fn defaults_of_a_joint() {
    let short = GOOD
        .replace("type = \"revolute\"\n", "")
        .replace("dh = { theta = 0, d = 0, a = 0, alpha = -90 }", "dh = { a = 0, alpha = -90 }");
    assert_ne!(short, GOOD);
    assert_eq!(read(&short).unwrap(), read(GOOD).unwrap());
}

#[test]
fn every_error_in_one_run() {
    let bad = GOOD
        .replace("type = \"prismatic\"", "type = \"linear\"")
        .replace("mdh = {", "origin = {}\nmdh = {")
        .replace("xyz = [250, 100, -840]\n", "");
    let error = read(&bad).unwrap_err();
    assert_eq!(
        error.lines().map(|line| line.split(": ").next().unwrap()).collect::<Vec<_>>(),
        ["r.toml:14:8", "r.toml:23:10", "r.toml:35:1"],
        "{error}"
    );
}

#[test]
fn columns_of_tables() {
    let folder = tempfile::tempdir().unwrap();
    let path = folder.path().join("r.toml");
    let with = |columns: &str| {
        std::fs::write(&path, format!("{GOOD}\n[columns]\n{columns}")).unwrap();
        let robot = crate::read_robot(&path, &RobotOptions::default());
        crate::robot_columns(&path).and_then(|map| robot.map(|_| map))
    };
    let map = with("d1 = \"Axis 1[mm]\"\norientation = \"abc\"\nignore = [\"Operator\"]\n").unwrap();
    assert_eq!(map.names, [("d1".to_string(), "Axis 1[mm]".to_string())]);
    assert_eq!(map.ignore, ["Operator"]);
    assert_eq!(map.orientation, Some(crate::OrientationConvention::KukaAbc));
    // A centre of gravity of all rows is a number.
    let map = with("payload = \"Load[kg]\"\ncz = 120\n").unwrap();
    let unit = if GOOD.contains("length = \"mm\"") { "mm" } else { "m" };
    assert_eq!(map.names[0], ("cz".to_string(), format!("120[{unit}]")));
    for (bad, words) in [("d1 = 3", "has to be a text in quotes"), ("orientation = \"kuka\"", "known: rpy")] {
        let error = with(bad).unwrap_err().to_string();
        assert!(error.contains(words), "{error}");
    }
}

#[test]
fn a_joint_may_be_called_base() {
    let chain = read(&GOOD.replace("name = \"d1\"", "name = \"base\"")).unwrap();
    assert_eq!(chain.joints()[0].name, "base_joint");
    let folder = tempfile::tempdir().unwrap();
    let path = folder.path().join("d.csv");
    let names: Vec<String> = chain.movable()[1..].iter().map(|&j| chain.joint(j).name.clone()).collect();
    for called in ["base", "base_joint"] {
        let rest = vec!["0"; names.len()].join(",");
        let text =
            format!("{called}[mm],{},x[m],y[m],z[m],approach_{called}\n7,{rest},1,2,3,1\n", names.join(","));
        std::fs::write(&path, text).unwrap();
        let (data, ..) =
            crate::read_measurements(&path, &chain, &crate::MeasurementsOptions::default()).unwrap();
        assert_eq!((data.joints[0][0], data.approach[0][0]), (0.007, 1.0));
    }
}
