//! Two arms of one robot that touch each other: planar arms, whose angles at a contact this test works out by the law of cosines.

use crate::folder::Folder;

/// Exit code of what is wrong with an input.
const INPUT: i32 = 2;

/// Two arms of two links, 0.6 m apart, as their description has them.
const ROBOT: &str = r#"
name = "pair"
units = { length = "mm", angle = "deg" }

[[joints]]
name = "l1"
type = "revolute"
origin = { xyz = [0, 0, 0], rpy = [0, 0, 0], axis = [0, 0, 1] }
[[joints]]
name = "l2"
type = "revolute"
origin = { xyz = [400, 0, 0], rpy = [0, 0, 0], axis = [0, 0, 1] }
[[joints]]
name = "r1"
type = "revolute"
parent = "base"
origin = { xyz = [600, 0, 0], rpy = [0, 0, 0], axis = [0, 0, 1] }
[[joints]]
name = "r2"
type = "revolute"
origin = { xyz = [400, 0, 0], rpy = [0, 0, 0], axis = [0, 0, 1] }

[[tools]]
name = "left"
joint = "l2"
xyz = [300, 0, 0]
[[tools]]
name = "right"
joint = "r2"
xyz = [300, 0, 0]
"#;

/// What the description has wrong, mm and rad: second links, and zeros of the second joints.
const LINKS: [f64; 2] = [401.0, 399.2];
const ZEROS: [f64; 2] = [0.004, -0.003];

/// Rows in which the hands are so far apart, mm; their noise is 0.02 mm and follows no law of the fit.
fn table(distances: impl Iterator<Item = f64>) -> String {
    let mut text = String::from("kind,landmark,tool,distance[mm],visit,l1[rad],l2[rad],r1[rad],r2[rad]\n");
    let mut state = 12345u64;
    let mut random = move || {
        state = state.wrapping_mul(6364136223846793005).wrapping_add(1442695040888963407);
        (state >> 33) as f64 / (1u64 << 31) as f64 - 0.5
    };
    let mut visit = 0;
    for distance in distances {
        loop {
            let (l1, l2) = (1.5 * random() + 0.8, 2.4 * random() + 1.0);
            let bent = l1 + l2 + ZEROS[0];
            let (x, y) = (LINKS[0] * l1.cos() + 300.0 * bent.cos(), LINKS[0] * l1.sin() + 300.0 * bent.sin());
            let turn = 6.3 * random();
            let (x, y) = (x + distance * turn.cos() - 600.0, y + distance * turn.sin());
            let (x, y) = (x + 0.07 * random(), y + 0.07 * random());
            let cosine = (x * x + y * y - LINKS[1].powi(2) - 300f64.powi(2)) / (2.0 * LINKS[1] * 300.0);
            if cosine.abs() > 0.95 {
                continue;
            }
            let bend = cosine.acos() * if random() > 0.0 { 1.0 } else { -1.0 };
            let r1 = y.atan2(x) - (300.0 * bend.sin()).atan2(LINKS[1] + 300.0 * bend.cos());
            let stated = if distance > 0.0 { distance.to_string() } else { String::new() };
            text += &format!("frames,right,left,{stated},{visit},{l1},{l2},{r1},{}\n", bend - ZEROS[1]);
            visit += 1;
            break;
        }
    }
    text
}

#[test]
fn two_arms_that_meet_are_calibrated_against_each_other() {
    let folder = Folder::empty();
    folder.write("robot.toml", ROBOT);
    folder.write("data.csv", &table((0..40).map(|k| if k % 4 == 3 { 120.0 } else { 0.0 })));
    let words = ["identify", "--robot", "robot.toml", "--data", "data.csv", "--out", "fit.json"];
    let text = folder.run(&words).ended(0);
    assert!(
        text.out.contains("Gap between points that meet (3-D RMS), each predicted without its row"),
        "{}",
        text.out
    );
    assert!(text.out.contains("left – right"), "{}", text.out);
    assert!(text.log.contains("where l1 and r1 stand to each other is taken as described"), "{}", text.log);
    assert!(!text.log.contains("scale is not determined"), "{}", text.log);
    assert!(!text.out.contains("No distance is known"), "{}", text.out);
    let found = folder.run(&[&words[..5], &["--json"]].concat()).ended(0).out;
    let found: serde_json::Value = serde_json::from_str(&found).unwrap();
    let contact = &found["landmarks"]["contacts"][0];
    assert_eq!(contact["rows"], 40, "{contact}");
    // 0.02 mm an axis; nominally some millimetres.
    let gap = contact["held_out"]["rms_mm"].as_f64().unwrap();
    assert!((0.02..0.05).contains(&gap), "{gap}");
    assert!(found["landmarks"]["points"].as_array().unwrap().is_empty());
    // A row of a contact is predicted where its own target is.
    folder.run("predict --fit fit.json --data data.csv --out p.csv").ended(0);
    assert_eq!(folder.read("p.csv").lines().filter(|line| !line.starts_with('#')).count(), 41);
}

#[test]
fn one_hand_is_brought_to_the_other() {
    let folder = Folder::empty();
    folder.write("robot.toml", ROBOT);
    folder.write("data.csv", &table((0..40).map(|k| if k % 4 == 3 { 120.0 } else { 0.0 })));
    folder.run("identify --robot robot.toml --data data.csv --out fit.json").ended(0);
    let poses = "tool,x[mm],y[mm],z[mm],l1[rad],l2[rad],r1[rad],r2[rad]\n\
                 left,0,0,0,0.7,1.2,2.6,0.3\nleft,-10,30,0,0.9,0.8,2.4,0.5\n";
    folder.write("poses.csv", poses);
    let words =
        ["compensate", "--fit", "fit.json", "--poses", "poses.csv", "--out", "q.csv", "--relative-to"];
    let told = folder.run(&[&words[..], &["right"]].concat()).ended(0).log;
    assert!(told.contains("how `right` is turned, in whose axes the poses are, is as declared"), "{told}");
    let table = folder.read("q.csv");
    let mut lines = table.lines().filter(|line| !line.starts_with('#'));
    let names: Vec<&str> = lines.next().unwrap().split(',').collect();
    for (line, wanted, other) in
        [(lines.next().unwrap(), [0.0, 0.0], [2.6, 0.3]), (lines.next().unwrap(), [-10.0, 30.0], [2.4, 0.5])]
    {
        let cells: Vec<&str> = line.split(',').collect();
        let cell = |name: &str| cells[names.iter().position(|n| *n == name).unwrap()];
        let joint = |name: &str| cell(name).parse::<f64>().unwrap();
        let [l1, l2, r1, r2] = ["l1[rad]", "l2[rad]", "r1[rad]", "r2[rad]"].map(joint);
        assert!([r1, r2].iter().zip(other).all(|(joint, given)| joint.to_bits() == f64::to_bits(given)));
        // Where the hands of the true robot are.
        let at = |x: f64, link: f64, (a, b): (f64, f64)| {
            [x + link * a.cos() + 300.0 * b.cos(), link * a.sin() + 300.0 * b.sin()]
        };
        let (left, right) =
            (at(0.0, LINKS[0], (l1, l1 + l2 + ZEROS[0])), at(600.0, LINKS[1], (r1, r1 + r2 + ZEROS[1])));
        let turn = r1 + r2 + ZEROS[1];
        let (x, y) = (left[0] - right[0], left[1] - right[1]);
        let own = [x * turn.cos() + y * turn.sin(), y * turn.cos() - x * turn.sin()];
        let off = (own[0] - wanted[0]).hypot(own[1] - wanted[1]);
        // How the right hand is turned no contact tells: 4 mrad.
        assert!(off < 0.05 + 4e-3 * wanted[0].hypot(wanted[1]), "{off} mm: {line}");
        let within: f64 = joint("within_95[m]");
        assert!((1e-5..2e-4).contains(&within), "{within}");
    }
    let refused = |tool: &str| folder.run(&[&words[..], &[tool]].concat()).ended(INPUT).log;
    assert!(refused("left").contains("poses.csv:2: the pose is one of `left` itself"), "{}", refused("left"));
    assert!(refused("middle").contains("the robot has no tool `middle` (its tools: left, right)"));
    folder.write("poses.csv", "tool,x[mm],y[mm],z[mm]\nleft,20,15,0\n");
    assert!(refused("right").contains("joint columns are needed: they say where the other hand is"));
}

#[test]
fn what_is_wrong_with_a_contact_is_told_where_it_stands() {
    let table = table([0.0; 12].into_iter());
    let third = table.lines().nth(2).unwrap();
    let broken = |from: &str, to: &str| table.replacen(third, &third.replacen(from, to, 1), 1);
    for (table, words) in [
        (broken(",right,", ",middle,"), "data.csv:3: `middle` is no point of the robot"),
        (broken(",right,", ",,"), "data.csv:3: column `landmark` (2): is empty"),
        (broken(",right,", ",left,"), "line 3: left and left are on one tool"),
        (broken(",left,,", ",left,-5,"), "data.csv:3: column `distance[mm]` (4): a distance is not negative"),
        (table.replacen("landmark", "why", 1), "`frames` needs a column `landmark`"),
    ] {
        let folder = Folder::empty();
        folder.write("robot.toml", ROBOT);
        folder.write("data.csv", &table);
        let run = folder.run("identify --robot robot.toml --data data.csv --out fit.json");
        assert!(!folder.file("fit.json").exists());
        let log = run.ended(INPUT).log;
        assert!(log.contains(words), "{words}\n{log}");
    }
}
