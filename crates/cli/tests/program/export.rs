//! From a fit to a corrected URDF and back, and the map of the accuracy.

use crate::folder::Folder;
use truepose_io::{RobotOptions, read_robot};
use truepose_kinematics::{Chain, Pose};

/// A small arm as a URDF with things in it that are nobody's business here.
const URDF: &str = r#"<?xml version="1.0"?>
<robot name="small">
  <!-- made by hand -->
  <link name="base"/><link name="l1"/><link name="l2"/><link name="l3"/><link name="tip"/>
  <joint name='j1' type='revolute'><origin rpy='0 0 0' xyz='0 0 .3'/><parent link='base'/><child link='l1'/><axis xyz='0 0 1'/>
    <limit lower='-2.9' upper='2.9' effort='1' velocity='1'/></joint>
  <joint name="j2" type="revolute"><origin xyz="0.15 0 0" rpy="1.5707963267948966 0 0"/><parent link="l1"/><child link="l2"/>
    <axis xyz="0 0 1"/><limit lower="-2" upper="2" effort="1" velocity="1"/></joint>
  <joint name="d3" type="prismatic"><origin xyz="0.4 0 0.02" rpy="0 1.3 0"/><parent link="l2"/><child link="l3"/><axis xyz="0 0 1"/>
    <limit lower="0" upper="0.25" effort="1" velocity="1"/></joint>
  FIXED
  <gazebo reference="l1"><material>Gazebo/Grey</material></gazebo>
</robot>
"#;

const FLANGE: &str = r#"<joint name="flange" type="fixed"><origin xyz="0 0 0.1"/><parent link="l3"/><child link="tip"/></joint>"#;

const PLANT: &str = "robot = \"arm.toml\"\nseed = 3\n[errors.geometric]\nposition_mm = 0.4\nangle_mrad = 0.5\n\
                     [instrument]\nsd_um = 20\norientation_urad = 40\n[campaign]\npostures = \"random\"\nvisits = 60\n";

/// With a fit of a robot that was described by a URDF, whose last joint is fixed or moves.
fn fitted(fixed: bool) -> Folder {
    let folder = Folder::empty();
    let tip = if fixed { "tip" } else { "l3" };
    let urdf = if fixed {
        URDF.replace("FIXED", FLANGE)
    } else {
        URDF.replace("FIXED", "").replace("<link name=\"tip\"/>", "")
    };
    folder.write("arm.urdf", &urdf);
    folder.write("arm.toml", &format!("urdf = \"arm.urdf\"\ntip = \"{tip}\"\n"));
    folder.write("plant.toml", PLANT);
    folder.run("simulate --plant plant.toml --out data.csv").ended(0);
    folder.run("identify --robot arm.toml --data data.csv --out fit.json").ended(0);
    folder.run("predict --fit fit.json --data data.csv --out p.csv").ended(0);
    folder
}

/// Column values of a CSV file, by the beginning of their names, converted from mm and degrees to m and rad.
fn columns(folder: &Folder, file: &str, names: &[&str]) -> Vec<Vec<f64>> {
    let text = folder.read(file);
    let mut lines = text.lines().map(|line| line.split(',').collect::<Vec<_>>());
    let header = lines.next().unwrap();
    let places: Vec<(usize, f64)> = names
        .iter()
        .map(|name| {
            let k = header.iter().position(|h| h == name || h.starts_with(&format!("{name}["))).unwrap();
            let unit = header[k].split_once('[').map_or("", |(_, unit)| unit);
            (
                k,
                if unit == "mm]" {
                    1e-3
                } else if unit == "deg]" {
                    1f64.to_radians()
                } else {
                    1.0
                },
            )
        })
        .collect();
    lines.map(|row| places.iter().map(|(k, by)| row[*k].parse::<f64>().unwrap() * by).collect()).collect()
}

/// The robot of a file is where the fit says: to a nanometre and a nanoradian.
#[track_caller]
fn predicts(folder: &Folder, chain: &Chain, base: &Pose) {
    let joints = columns(folder, "data.csv", &["j1", "j2", "d3"]);
    let said = columns(folder, "p.csv", &["x", "y", "z", "qw", "qx", "qy", "qz"]);
    assert_eq!((joints.len(), said.len()), (60, 60));
    for (q, said) in joints.iter().zip(&said) {
        let at = *base * chain.forward(q);
        for (ours, said) in at.translation.iter().zip(said) {
            assert!((ours - said).abs() < 1e-9, "{ours} {said}");
        }
        let rotation = Pose::rotation_from_quaternion([said[3], said[4], said[5], said[6]]);
        assert!((rotation - at.rotation).amax() < 1e-9);
    }
}

/// Where the base link is in the measurement frame, as the comment of a file has it.
fn installed(urdf: &str) -> Pose {
    let Some((_, at)) = urdf.split_once("the base link is in the measurement frame at xyz ") else {
        return Pose::IDENTITY;
    };
    let numbers: Vec<f64> = at.split([' ', ',']).filter_map(|word| word.parse().ok()).take(6).collect();
    Pose::from_xyz_rpy([numbers[0], numbers[1], numbers[2]], [numbers[3], numbers[4], numbers[5]])
}

#[test]
fn the_installation_moves_neither_the_base_nor_the_flange_of_a_urdf() {
    let folder = fitted(true);
    let export = "export --fit fit.json --format urdf --urdf arm.urdf --out n.urdf";
    folder.run(export).ended(0);
    let new = folder.read("n.urdf");
    // The base is fitted away from the measurement frame, and the tool from the flange.
    assert!(installed(&new) != Pose::IDENTITY && new.contains("truepose_tip"), "{new}");
    let (chain, _) =
        read_robot(folder.file("n.urdf"), &RobotOptions { tip: Some("tip".into()), ..Default::default() })
            .unwrap();
    let (nominal, _) = read_robot(folder.file("arm.urdf"), &RobotOptions::default()).unwrap();
    let first = |chain: &Chain| chain.joints()[0].transform(0.0);
    assert_eq!(first(&chain).translation, first(&nominal).translation);
}

#[test]
fn a_corrected_urdf_predicts_as_the_fit_does() {
    for fixed in [true, false] {
        let folder = fitted(fixed);
        let export = ["export", "--fit", "fit.json", "--format", "urdf", "--out", "new.urdf"];
        let said = folder.run(&[&export[..], &["--urdf", "arm.urdf"]].concat()).ended(0).out;
        assert!(
            said.contains("carries every effect of the fit") && said.contains("RMS below 1 nm"),
            "{said}"
        );
        let (chain, _) = read_robot(folder.file("new.urdf"), &RobotOptions::default()).unwrap();
        predicts(&folder, &chain, &installed(&folder.read("new.urdf")));
        // Line by line the same but for origins, the comment, and what was added at the end.
        let (old, new) = (folder.read("arm.urdf"), folder.read("new.urdf"));
        let rest = |text: &str| -> Vec<String> {
            let comment = text.find("\n<!--\n").map(|at| at..text.find("-->").unwrap() + 3);
            let text = comment.map_or(text.to_string(), |c| text.replace(&text[c], ""));
            text.lines()
                .filter(|l| !l.contains("<origin") && !l.contains("truepose_tip"))
                .map(String::from)
                .collect()
        };
        assert_eq!(rest(&old), rest(&new));
        assert_ne!(old, new);
        // Without the original, a URDF of its own.
        folder.run(&export).ended(0);
        let (chain, _) = read_robot(folder.file("new.urdf"), &RobotOptions::default()).unwrap();
        predicts(&folder, &chain, &installed(&folder.read("new.urdf")));
        // Another robot's URDF is refused, and nothing is written.
        folder.write("other.urdf", &old.replace("0.15 0 0", "0.16 0 0"));
        let refused =
            folder.run("export --fit fit.json --format urdf --out x.urdf --urdf other.urdf").ended(2);
        assert!(refused.log.contains("other.urdf:7:3: joint `j2` has another origin"), "{}", refused.log);
        assert!(!folder.file("x.urdf").exists());
    }
}

#[test]
fn every_format_says_what_it_lacks() {
    let folder = fitted(true);
    folder.write(
        "model.toml",
        "[[effects]]\nfamily = \"geometric\"\n[[effects]]\nfamily = \"transmission\"\njoint = \"j1\"\n",
    );
    folder.run("identify --robot arm.toml --data data.csv --model model.toml --out fit.json").ended(0);
    for format in ["urdf", "dh", "mdh", "ros", "iso230"] {
        let run = folder.run(&["export", "--fit", "fit.json", "--format", format, "--out", "o"]).ended(0);
        let carries = format == "iso230";
        let line = if carries { "carries every effect of the fit" } else { "cannot carry: transmission" };
        for text in [&run.out, &folder.read("o")] {
            assert!(
                text.contains(line) && text.contains("remaining error over the range of the fit: RMS "),
                "{text}"
            );
        }
        let json = ["export", "--fit", "fit.json", "--format", format, "--out", "o", "--json"];
        let said = folder.run(&json).ended(0).json();
        let rms = said["error_left"]["rms_mm"].as_f64().unwrap();
        assert!(if carries { rms < 1e-3 } else { rms > 1e-6 }, "{format}: {rms}");
    }
    let refused = folder.run("export --fit fit.json --format dh --out o --urdf arm.urdf").ended(2);
    assert!(refused.log.contains("only `--format urdf` corrects a URDF"), "{}", refused.log);
}

#[test]
fn a_map_is_written_place_by_place() {
    let folder = fitted(true);
    let run = folder.run("map --fit fit.json --out m.csv --points 4").ended(0);
    assert!(run.out.starts_with("64 places, 100 % of them reachable; written to m.csv\n"), "{}", run.out);
    let places = columns(&folder, "m.csv", &["before", "after_95"]);
    let mean = |k: usize| (places.iter().map(|row| row[k].powi(2)).sum::<f64>() / 64.0).sqrt();
    assert!(mean(1) < 0.2 * mean(0) && mean(1) > 1e-5, "{} {}", mean(0), mean(1));
    let box_map = "map --fit fit.json --out m.csv --points 7 --json";
    let said = folder.run(&format!("{box_map} --from -900mm,-100mm,200mm --to=0.9m,0.1m,0.6m")).ended(0).out;
    let said: serde_json::Value = serde_json::from_str(&said).unwrap();
    assert_eq!(said["places"], 343);
    assert!((0.02..0.5).contains(&said["reachable"].as_f64().unwrap()), "{said}");
    assert_eq!(folder.read("m.csv").lines().count(), 344);
    for (wrong, message) in [
        (vec!["--from", "1,2,3", "--to", "1m,2m,3m"], "needs a unit"),
        (vec!["--from", "1m,2m", "--to", "1m,2m,3m"], "three values"),
        (vec!["--target", "P9"], "has no target `P9`"),
        (vec!["--payload=-3"], "is no mass"),
    ] {
        let wrong =
            folder.run(&[&["map", "--fit", "fit.json", "--out", "x.csv"][..], &wrong].concat()).ended(2);
        assert!(wrong.log.contains(message), "{}", wrong.log);
        assert!(!folder.file("x.csv").exists());
    }
}
