//! What the program says of columns under names of their own: one complete proposal, which makes the next try work.

use std::fmt::Write;
use truepose_io::{ColumnMap, MeasurementsOptions, OrientationConvention, read_measurements};
use truepose_kinematics::{Chain, Pose, samples};

/// Joints (degrees), position (mm) and rotation of some rows, seen from an instrument.
fn rows(chain: &Chain, count: usize) -> Vec<(Vec<f64>, [f64; 3], Pose)> {
    let instrument = Pose::from_xyz_rpy([1.5, 0.4, -0.3], [0.01, 0.02, 1.1]);
    let tool = Pose::from_xyz_rpy([0.06, 0.01, 0.03], [0.1, 0.2, 0.3]);
    (0..count)
        .map(|row| {
            let joint = |k: usize| ((row * (k + 3) * 7 + 13 * k) % 97) as f64 / 48.5 - 1.0;
            let joints: Vec<f64> = (0..chain.movable().len()).map(joint).collect();
            let pose = instrument * chain.forward(&joints) * tool;
            let at = pose.translation * 1e3;
            (joints.iter().map(|q| q.to_degrees()).collect(), [at.x, at.y, at.z], pose)
        })
        .collect()
}

/// A table of such rows: cells by the row's number, joints, position and rotation.
fn table(header: &str, row: impl Fn(usize, &[f64], [f64; 3], &Pose) -> String) -> String {
    let mut text = format!("{header}\n");
    for (k, (joints, at, pose)) in rows(&samples::ur10(), 40).iter().enumerate() {
        writeln!(text, "{}", row(k, joints, *at, pose)).unwrap();
    }
    text
}

fn list(values: &[f64]) -> String {
    values.iter().map(|value| format!("{value:.5}")).collect::<Vec<_>>().join(",")
}

type Read = Result<(truepose_errormodel::Dataset, truepose_io::CsvInfo, String), String>;

fn read(text: &str, columns: ColumnMap) -> Read {
    let folder = tempfile::tempdir().unwrap();
    let path = folder.path().join("d.csv");
    std::fs::write(&path, text).unwrap();
    let options = MeasurementsOptions { columns, ..MeasurementsOptions::default() };
    let here = |text: String| text.replace(&format!("{}/", folder.path().display()), "");
    read_measurements(&path, &samples::ur10(), &options)
        .map(|(data, info, warnings)| {
            let said: Vec<String> = warnings.iter().map(ToString::to_string).collect();
            (data, info, here(said.join("\n")))
        })
        .map_err(|error| here(error.to_string()))
}

/// The `[columns]` of a message, as they are pasted.
fn pasted(message: &str) -> ColumnMap {
    let (_, block) = message.split_once("[columns]\n").unwrap_or_else(|| panic!("no proposal: {message}"));
    let mut map = ColumnMap::default();
    for line in block.lines().take_while(|line| line.contains(" = ")) {
        let (ours, theirs) = line.split_once(" = ").unwrap();
        match (ours, theirs.trim_matches('"')) {
            ("orientation", word) => map.orientation = OrientationConvention::named(word),
            ("ignore", _) => {
                let columns = theirs.trim_matches(['[', ']']).split(", ");
                map.ignore.extend(columns.map(|column| column.trim_matches('"').to_owned()));
            }
            (ours, theirs) => map.names.push((ours.trim_matches('"').to_owned(), theirs.to_owned())),
        }
    }
    map
}

/// Reads with what the refusal proposes, and holds the values against those of the rows.
fn second_try(text: &str, oriented: bool) -> (String, String) {
    let refused = read(text, ColumnMap::default()).map(|(_, _, said)| said);
    let said = refused.unwrap_or_else(|error| error);
    let (data, _, warnings) = read(text, pasted(&said)).unwrap_or_else(|error| panic!("{said}\n{error}"));
    let chain = samples::ur10();
    for (row, (joints, at, pose)) in rows(&chain, 40).iter().enumerate() {
        for (column, q) in data.joints.iter().zip(joints) {
            assert!((column[row].to_degrees() - q).abs() < 1e-3, "{said}");
        }
        for (found, at) in data.position[row].iter().zip(at.iter()) {
            assert!((1e3 * found - at).abs() < 1e-3, "{said}");
        }
        match data.measured_rotation(row) {
            Some(found) => assert!((found - pose.rotation).amax() < 1e-4, "{said}"),
            None => assert!(!oriented, "{said}"),
        }
    }
    (said, warnings)
}

#[test]
fn spatial_analyzer_in_degrees_without_a_unit() {
    let header = "Object Name,X (mm),Y (mm),Z (mm),Rx (Fixed XYZ deg),Ry (Fixed XYZ deg),Rz (Fixed XYZ deg),J1,J2,J3,J4,J5,J6";
    let text = table(header, |k, joints, at, pose| {
        let turned = pose.rpy().map(f64::to_degrees);
        format!("Tool_{k:03},{},{},{}", list(&at), list(&turned), list(joints))
    });
    let (said, warnings) = second_try(&text, true);
    assert!(said.contains("J1[deg]") && said.contains("orientation = \"fixed_xyz\""), "{said}");
    assert!(said.contains("id = \"Object Name\""), "{said}");
    assert!(warnings.contains("`X (mm)`, `Y (mm)`, `Z (mm)` are read as x, y, z"), "{warnings}");
    assert!(warnings.contains("is read in [deg], as its header says"), "{warnings}");
}

/// The state of joints and a pose as `rostopic echo -p` writes them: names in cells, in the order of the alphabet or any other, and nanoseconds.
#[test]
fn names_of_joints_in_cells_are_those_of_the_columns_beside_them() {
    let order = [4, 0, 2, 5, 1, 3];
    let of = |word: &str| (0..6).map(|k| format!("field.{word}{k}")).collect::<Vec<_>>().join(",");
    let places = "field.pose.position.x,field.pose.position.y,field.pose.position.z";
    let header = format!("%time,{},{},{},{places}", of("name"), of("position"), of("effort"));
    let text = table(&header, |k, joints, at, _| {
        let names = order.map(|joint| format!("j{}", joint + 1)).join(",");
        let values = order.map(|joint| format!("{:.7}", joints[joint].to_radians())).join(",");
        let time = 1_712_000_000_000_000_000_u64 + 5_000_000 * k as u64;
        let [x, y, z] = at.map(|v| format!("{:.8}", v / 1e3));
        format!("{time},{names},{values},1.5,2.5,0.25,3.5,1.75,0.5,{x},{y},{z}")
    });
    let (said, _) = second_try(&text, false);
    assert!(
        said.contains("j5 = \"field.position0[rad]\"") && said.contains("time = \"%time[ns]\""),
        "{said}"
    );
    let (data, ..) = read(&text, pasted(&said)).unwrap();
    let moved = data.time[39] - data.time[0];
    assert!((moved - 0.195).abs() < 1e-6, "{moved}");
}

#[test]
fn a_quaternion_is_no_run_of_joints_and_its_order_is_found() {
    for (last, word) in [(false, "scalar first 0.0"), (true, "scalar last 0.0")] {
        let text = table(
            "Name,rax_1,rax_2,rax_3,rax_4,rax_5,rax_6,X,Y,Z,quat_0,quat_1,quat_2,quat_3",
            |k, joints, at, pose| {
                let [w, x, y, z] = pose.quaternion();
                let turned = if last { [x, y, z, w] } else { [w, x, y, z] };
                format!("p{k},{},{},{}", list(joints), list(&at), list(&turned))
            },
        );
        let (said, _) = second_try(&text, true);
        assert!(said.contains(word), "{said}");
    }
}

#[test]
fn runs_are_whole_and_count_from_zero_or_one() {
    let numbered = |first: usize, count: usize| {
        let names: Vec<String> = (first..first + count).map(|k| format!("q_{k}")).collect();
        let text = table(&format!("{},px,py,pz", names.join(",")), |_, joints, at, _| {
            let mut joints = joints.to_vec();
            joints.resize(count, 0.5);
            format!("{},{}", list(&joints), list(&at))
        });
        read(&text, ColumnMap::default()).unwrap_err()
    };
    let (last, _) = samples::ur10()
        .movable()
        .iter()
        .map(|&k| samples::ur10().joint(k).name.clone())
        .fold((String::new(), 0), |_, name| (name, 0));
    assert!(numbered(0, 6).contains(&format!("{last} = \"q_5[deg]\"")), "{}", numbered(0, 6));
    assert!(numbered(1, 6).contains(&format!("{last} = \"q_6[deg]\"")));
    for (first, count) in [(2, 6), (0, 5), (0, 7), (1, 4)] {
        let said = numbered(first, count);
        assert!(!said.contains("= \"q_"), "{first} {count} {said}");
    }
}

#[test]
fn units_in_cells_and_the_letters_of_fanuc() {
    let text = table("PR#\tJ1\tJ2\tJ3\tJ4\tJ5\tJ6\tX\tY\tZ\tW\tP\tR", |k, joints, at, pose| {
        let deg =
            |values: &[f64]| values.iter().map(|v| format!("{v:.5} deg")).collect::<Vec<_>>().join("\t");
        let mm: Vec<String> = at.iter().map(|v| format!("{v:.5} mm")).collect();
        format!("PR[{k}]\t{}\t{}\t{}", deg(joints), mm.join("\t"), deg(&pose.rpy().map(f64::to_degrees)))
    });
    let (said, _) = second_try(&text, true);
    assert!(said.contains("orientation = \"wpr\"") && said.contains("id = \"PR#\""), "{said}");
}

#[test]
fn headers_of_several_rows() {
    let header = "Format Version,1.23,Length Units,Meters\n\n,,Body,Body,Body,Body,Body,Body,Body,Body,,,,,,\n\
                  ,,Rotation,Rotation,Rotation,Rotation,Position,Position,Position,Error,,,,,,\n\
                  Frame,Time (Seconds),X,Y,Z,W,X,Y,Z,,q1,q2,q3,q4,q5,q6";
    let text = table(header, |k, joints, at, pose| {
        let [w, x, y, z] = pose.quaternion();
        let rad: Vec<f64> = joints.iter().map(|q| q.to_radians()).collect();
        let at = at.map(|v| v / 1e3);
        let long = |values: &[f64]| values.iter().map(|v| format!("{v:.9}")).collect::<Vec<_>>().join(",");
        format!("{k},{}.5,{},{},0.0003,{}", 5 * k, long(&[x, y, z, w]), long(&at), long(&rad))
    });
    let (said, _) = second_try(&text, true);
    assert!(said.contains("time = \"Time (Seconds)\"") && said.contains("x = \"Position X[m]\""), "{said}");
}

#[test]
fn structures_of_krl() {
    let text = table("; a log", |k, joints, at, pose| {
        let axes: Vec<String> =
            joints.iter().enumerate().map(|(k, q)| format!("A{} {q:.5}", k + 1)).collect();
        let [c, b, a] = pose.rpy().map(f64::to_degrees);
        format!(
            "{k} {{E6AXIS: {}}} {{FRAME: X {:.5}, Y {:.5}, Z {:.5}, A {a:.5}, B {b:.5}, C {c:.5}}}",
            axes.join(", "),
            at[0],
            at[1],
            at[2]
        )
    });
    let (said, _) = second_try(&text, true);
    assert!(said.contains("orientation = \"abc\""), "{said}");
    let broken = text.replacen("E6AXIS: A1", "E6AXIS: A1 x", 5).replacen("E6AXIS: A1 x", "E6AXIS: A1", 4);
    let error = read(&broken, ColumnMap::default()).unwrap_err();
    assert!(error.starts_with("d.csv:6: has `x "), "{error}");
}

#[test]
fn columns_without_a_name_are_left_out() {
    let names: Vec<String> = samples::ur10()
        .movable()
        .iter()
        .map(|&k| format!("{}[deg]", samples::ur10().joint(k).name))
        .collect();
    let text = table(&format!(",{},x[mm],y[mm],z[mm],", names.join(",")), |k, joints, at, _| {
        format!("{k},{},{},{}", list(joints), list(&at), if k == 7 { "beam lost" } else { "" })
    });
    let (data, _, said) = read(&text, ColumnMap::default()).unwrap();
    assert_eq!(data.len(), 40);
    assert_eq!(said.matches("has no name, and is not read").count(), 2, "{said}");
}

#[test]
fn what_is_ambiguous_is_asked() {
    let names: Vec<String> = samples::ur10()
        .movable()
        .iter()
        .map(|&k| format!("{}[deg]", samples::ur10().joint(k).name))
        .collect();
    let header = format!("{},X [mm],Y [mm],Z [mm],TCP X [mm],TCP Y [mm],TCP Z [mm]", names.join(","));
    let text = table(&header, |_, joints, at, _| format!("{},{},{}", list(joints), list(&at), list(&at)));
    let said = read(&text, ColumnMap::default()).unwrap_err();
    assert!(
        said.contains("several columns may be the measured position: `X [mm]` …, `TCP X [mm]` …"),
        "{said}"
    );
}

#[test]
fn the_same_fault_is_told_once() {
    let names: Vec<String> = samples::ur10()
        .movable()
        .iter()
        .map(|&k| format!("{}[deg]", samples::ur10().joint(k).name))
        .collect();
    let header = format!("{},x[mm],y[mm],z[mm],target", names.join(","));
    let text = table(&header, |k, joints, at, _| format!("{},{},SMR{}", list(joints), list(&at), k % 3));
    let said = read(&text, ColumnMap::default()).unwrap_err();
    assert_eq!(said.lines().count(), 3, "{said}");
    assert!(said.contains("no target `SMR0`") && said.contains("; the same in 13 other rows"), "{said}");
}

#[test]
fn angles_that_no_one_means_in_radians_are_refused() {
    let names: Vec<String> = samples::ur10()
        .movable()
        .iter()
        .map(|&k| format!("{}[deg]", samples::ur10().joint(k).name))
        .collect();
    let header = format!("{},x[mm],y[mm],z[mm],rx,ry,rz", names.join(","));
    let text = table(&header, |_, joints, at, pose| {
        format!("{},{},{}", list(joints), list(&at), list(&pose.rpy().map(f64::to_degrees)))
    });
    let said = read(&text, ColumnMap::default()).unwrap_err();
    assert!(said.contains("looks like degrees; if so, call the column `rz[deg]`"), "{said}");
}
