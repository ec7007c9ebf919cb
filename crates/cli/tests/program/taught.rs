//! `compensate --program --taught`: frames that were taught with the uncorrected robot.

use crate::folder::Folder;
use truepose_io::{RobotOptions, read_robot};
use truepose_kinematics::nalgebra::{Matrix3, Vector3};
use truepose_kinematics::{Chain, Pose, rotation_vector};

fn flange(chain: &Chain, joints: &[f64]) -> Pose {
    chain.base().pose.inverse() * chain.forward(joints) * chain.tool().pose.inverse()
}

/// A job in `BASE_DATA[3]`, the option of its value, and the points at which it was touched.
fn job(folder: &Folder) -> String {
    let robot =
        std::path::Path::new(env!("CARGO_MANIFEST_DIR")).join("../../examples/01_identify/robot.toml");
    let (chain, _) = read_robot(robot, &RobotOptions::default()).unwrap();
    let degrees = [
        [50.668, -106.651, 81.014, -25.176, -53.698, 72.074],
        [46.0, -104.0, 79.0, -25.0, -52.0, 72.0],
        [52.0, -99.0, 78.0, -24.0, -55.0, 70.0],
    ];
    let mut rows = String::from("point,a1[deg],a2[deg],a3[deg],a4[deg],a5[deg],a6[deg]\n");
    for (word, joints) in ["xy", "origin", "x"].into_iter().zip(degrees) {
        let joints: Vec<String> = joints.iter().map(ToString::to_string).collect();
        rows += &format!("{word},{}\n", joints.join(","));
    }
    folder.write("points.csv", &rows);
    let at: Vec<Vector3<f64>> =
        degrees.iter().map(|joints| flange(&chain, &joints.map(f64::to_radians)).translation).collect();
    let x = (at[2] - at[1]).normalize();
    let z = x.cross(&(at[0] - at[1])).normalize();
    let frame = Pose::new(Matrix3::from_columns(&[x, z.cross(&x), z]), at[1]);
    let start = degrees[0].map(f64::to_radians);
    let near = flange(&chain, &start);
    let place = |k: f64| {
        let turn = rotation_vector(&Vector3::new(0.02 * k, 0.0, 0.0));
        let pose = frame.inverse() * Pose::new(near.rotation * turn, near.translation + 0.03 * k * x);
        let ([x, y, z], [c, b, a]) =
            ([0, 1, 2].map(|k| 1e3 * pose.translation[k]), pose.rpy().map(f64::to_degrees));
        format!("LIN {{X {x:.4},Y {y:.4},Z {z:.4},A {a:.5},B {b:.5},C {c:.5}}}\n")
    };
    let joints: Vec<String> = degrees[0].iter().enumerate().map(|(k, q)| format!("A{} {q}", k + 1)).collect();
    folder.write(
        "job.src",
        &format!(
            "DEF job()\n$BASE=BASE_DATA[3]\n$TOOL=$NULLFRAME\nPTP {{{}}}\n{}{}END\n",
            joints.join(","),
            place(1.0),
            place(2.0)
        ),
    );
    let ([x, y, z], [roll, pitch, yaw]) =
        ([0, 1, 2].map(|k| 1e3 * frame.translation[k]), frame.rpy().map(f64::to_degrees));
    format!("BASE_DATA[3]={x}mm,{y}mm,{z}mm,{roll},{pitch},{yaw}")
}

#[test]
fn how_a_frame_was_made_is_stated_or_the_program_and_the_page_ask_for_it() {
    let folder = Folder::with_heavy_fit();
    let frame = job(&folder);
    let run = |more: &[&str], code: i32| {
        let first = ["compensate", "--fit", "fit.json", "--program", "job.src", "--out", "new.src"];
        folder.run(&[&first[..], &["--frame", &frame], more].concat()).ended(code)
    };
    let log = run(&["--report", "page"], 0).log;
    assert!(log.contains("frames are taken as they are (BASE_DATA[3])") && log.contains("--taught"), "{log}");
    let page = folder.read("page/index.html");
    assert!(page.contains("How these frames were made is not stated: BASE_DATA[3]."), "{page}");
    let as_measured = folder.read("new.src");
    for word in ["--measured", "--cad"] {
        let log = run(&[word, "base_data[3]", "--report", "page"], 0).log;
        assert!(!log.contains("frames are taken"), "{log}");
        assert!(!folder.read("page/index.html").contains("How these frames"));
        assert_eq!(folder.read("new.src"), as_measured);
    }
    let log = run(&["--taught", "BASE_DATA[3]=points.csv"], 0).log;
    assert!(!log.contains("frames are taken"), "{log}");
    assert!(folder.read("new.src") != as_measured);
    // Joints alone are no points of the frame.
    let new = folder.read("new.src");
    assert_eq!(new.lines().nth(3), as_measured.lines().nth(3));

    let log = run(&["--taught", "BASE_DATA[3]=points.csv,TOOL_DATA[9]"], 2).log;
    assert!(log.contains("--taught BASE_DATA[3]: points.csv: its tool TOOL_DATA[9] has no value"), "{log}");
    let log = run(&["--taught", "BASE_DATA[3]=points.csv", "--cad", "BASE_DATA[3]"], 2).log;
    assert!(log.contains("is stated twice"), "{log}");
    let log = run(&["--taught", "BASE_DATA[4]=points.csv", "--measured", "X"], 0).log;
    assert!(log.contains("no point of the program uses the frame or tool `BASE_DATA[4]`"), "{log}");
    assert!(log.contains("no point of the program uses the frame or tool `X`"), "{log}");
    assert!(run(&["--taught", "BASE_DATA[3]"], 2).log.contains("a frame and a file are needed"));
    folder.write("points.csv", &folder.read("points.csv").replace("46,", "46.4,"));
    let log = run(&["--taught", "BASE_DATA[3]=points.csv"], 2).log;
    assert!(log.contains("points.csv: line 3: the controller has this point (its origin) at"), "{log}");
}
