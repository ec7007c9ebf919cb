//! A robot whose fifth joint follows its second one: measured by formulas of the test's own, in which the fifth joint has no value.

use crate::folder::Folder;
use crate::observations::cell::{Arm, Draw, NOMINAL, dot, minus, positions, robot};
use std::fmt::Write as _;

const INPUT: i32 = 2;
const RATIO: f64 = -0.6;
const OFFSET_DEG: f64 = 40.0;
const HEADER: &str = "j1[rad],j2[rad],j3[rad],j4[rad],j6[rad]";

/// The real arm: lengths, twists and offsets that the description does not have, of the following joint as well.
struct Real(Arm, [f64; 6]);

impl Real {
    fn tip(&self, u: &[f64; 5]) -> [f64; 3] {
        let [a, b, c, d, e] = *u;
        self.0.tip(&[a, b, c, d, RATIO * b + OFFSET_DEG.to_radians(), e], &self.1)
    }
}

fn described() -> String {
    let joint = "name = \"j5\"\ntype = \"revolute\"\nlimits = [-175, 175]\n";
    let text = robot("");
    assert!(text.contains(joint));
    let mimic = format!("mimic = {{ joint = \"j2\", ratio = {RATIO}, offset = {OFFSET_DEG} }}\n");
    text.replace(joint, &[joint, &mimic].concat())
}

fn rows(real: &Real, draw: &mut Draw, count: usize, noise: f64) -> (String, Vec<[f64; 3]>) {
    let (mut text, mut truth) = (format!("{HEADER},x[mm],y[mm],z[mm]\n"), Vec::new());
    for _ in 0..count {
        let u: [f64; 5] = std::array::from_fn(|_| 1.5 * draw.next());
        let p = real.tip(&u);
        let [x, y, z] = p.map(|v| 1e3 * (v + noise * draw.noise()));
        let cells = u.map(|u| format!("{u:.9}")).join(",");
        writeln!(text, "{cells},{x:.5},{y:.5},{z:.5}").unwrap();
        truth.push(p);
    }
    (text, truth)
}

fn rms(a: &[[f64; 3]], b: &[[f64; 3]]) -> f64 {
    let squares = a.iter().zip(b).map(|(a, b)| {
        let away = minus(*a, *b);
        dot(away, away)
    });
    1e3 * (squares.sum::<f64>() / a.len() as f64).sqrt()
}

#[test]
fn a_joint_that_follows_another_one_is_calibrated_and_commanded() {
    let (arm, offsets) = Arm::real(21);
    let real = Real(arm, offsets);
    let mut draw = Draw::new(5);
    let folder = Folder::empty();
    folder.write("robot.toml", &described());
    folder.write("data.csv", &rows(&real, &mut draw, 80, 2e-5).0);
    let (new, truth) = rows(&real, &mut draw, 60, 0.0);
    folder.write("new.csv", &new);
    let check = folder.run("check --robot robot.toml --data data.csv").ended(0).out;
    assert!(check.contains("j5 follows j2: value = -0.6 × value of j2"), "{check}");
    folder.run("identify --robot robot.toml --data data.csv --out fit.json").ended(0);
    folder.run("predict --fit fit.json --data new.csv --out p.csv").ended(0);
    let text = folder.read("p.csv");
    assert!(text.starts_with(HEADER), "{text}");
    let off = rms(&positions(&text), &truth);
    assert!(off < 0.03, "{off} mm");

    // Places that the real arm can be brought to: other joints than the seeds'.
    let mut poses = format!("x[m],y[m],z[m],{HEADER}\n");
    for p in &truth {
        writeln!(poses, "{:.9},{:.9},{:.9},0.1,-0.5,0.8,0.2,0.1", p[0], p[1], p[2]).unwrap();
    }
    folder.write("poses.csv", &poses);
    folder.run("compensate --fit fit.json --poses poses.csv --out q.csv").ended(0);
    let commands = folder.read("q.csv");
    assert!(commands.starts_with(HEADER), "{commands}");
    let mut there = Vec::new();
    let mut wanted = Vec::new();
    for (line, p) in commands.lines().skip(1).zip(&truth) {
        let cells: Vec<&str> = line.split(',').collect();
        if cells[5] == "ok" {
            there.push(real.tip(&std::array::from_fn(|k| cells[k].parse().unwrap())));
            wanted.push(*p);
        }
    }
    assert!(there.len() > 55, "{commands}");
    let off = rms(&there, &wanted);
    assert!(off < 0.03, "{off} mm");

    // In a URDF the joint still follows, and the numbers say where it does.
    folder.run("export --fit fit.json --format urdf --out arm.urdf").ended(0);
    let urdf = folder.read("arm.urdf");
    assert!(urdf.contains("<mimic joint=\"j2\" multiplier=\"-0.6\""), "{urdf}");
    folder.run("predict --robot arm.urdf --data new.csv --out u.csv");
    folder.run("identify --robot arm.urdf --data data.csv --out again.json").ended(0);
    // The search for what is missing finds nothing beyond the noise.
    folder.run("discover --robot robot.toml --data data.csv --out d.json --report r").ended(0);
    folder.run("plan --fit fit.json --count 6 --out plan.csv").ended(0);
    assert!(!folder.read("plan.csv").lines().next().unwrap().contains("j5"));
}

#[test]
fn a_column_of_a_following_joint_is_refused() {
    let folder = Folder::empty();
    folder.write("robot.toml", &described());
    folder.write("data.csv", "j1,j2,j3,j4,j5[rad],j6,x[mm],y[mm],z[mm]\n0,0,0,0,0,0,1,2,3\n");
    let run = folder.run("check --robot robot.toml --data data.csv").ended(INPUT);
    let words = "data.csv:1: column `j5[rad]` (5): joint `j5` mimics `j2` and has no value of its own; remove the column";
    assert!(run.log.contains(words), "{}", run.log);
}

#[test]
fn a_joint_that_stands_still_is_told_once_with_those_that_follow_it() {
    let folder = Folder::empty();
    folder.write("robot.toml", &described());
    let row = |k: u32| {
        let q = f64::from(k);
        format!("{},0.5,0.7,{},{},{},{},3\n", 0.1 * q, 0.2 * q, 0.3 * q, 1.0 + q, 2.0 - q)
    };
    let rows: String = (0..8).map(row).collect();
    folder.write("data.csv", &format!("j1[rad],j2[rad],j3[rad],j4[rad],j6[rad],x[mm],y[mm],z[mm]\n{rows}"));
    let told = folder.run("identify --robot robot.toml --data data.csv").log;
    assert!(told.contains(": j2, j3 never change"), "{told}");
    // No column could be mistaken for that of a joint that has none.
    let told = folder.run("check --robot robot.toml --data data.csv").log;
    assert!(!told.contains("j5"), "{told}");
}

#[test]
fn the_flange_at_zeros_has_the_offset_of_a_joint_that_follows() {
    let folder = Folder::empty();
    folder.write("robot.toml", &described());
    let out = folder.run("check --robot robot.toml").ended(0).out;
    let follows = [0.0, 0.0, 0.0, 0.0, OFFSET_DEG.to_radians(), 0.0];
    let [x, y, z] = NOMINAL.point(&follows, &[0.0; 6], [0.0; 3]).map(|v| 1e3 * v);
    let words = format!("flange at all zeros: xyz {x:.2} {y:.2} {z:.2} mm");
    assert!(out.contains(&words), "{words}\n{out}");
}
