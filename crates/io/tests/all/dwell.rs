//! Rows of one dwell, whose joint values flicker, are one pose measurement: read whole and in blocks.

#![allow(
    clippy::unwrap_used,
    clippy::float_cmp,
    reason = "a test fails by panicking, and what is exact is tested as such"
)]

use truepose_errormodel::{Dataset, DwellTolerance, configurations};
use truepose_io::{MeasurementsOptions, MeasurementsReader, read_measurements};
use truepose_kinematics::samples;

/// Flicker of a row, rad: the last digits that encoders at rest show, up to 1e-4°.
fn flicker(row: usize) -> f64 {
    (((row * 7919) % 41) as f64 - 20.0) / 20.0 * 1e-4f64.to_radians()
}

/// Every pose twice (all of them, and then again), three rows a dwell, no column `visit`.
fn table(poses: usize) -> String {
    let mut text = String::from("r1[rad],r2[rad],slide[m],r4[rad],x[m],y[m],z[m]\n");
    for round in 0..2 {
        for pose in 0..poses {
            for row in 0..3 {
                let off = flicker(3 * (poses * round + pose) + row);
                let q = [0.02 * pose as f64, 0.9 - 0.01 * pose as f64, 0.1, 0.4];
                text += &format!("{:.9},{:.9},{:.9},{:.9},", q[0] + off, q[1] - off, q[2], q[3] + off);
                text += &format!("1,{:.6},{:.6}\n", 0.001 * pose as f64, 1e-5 * row as f64);
            }
        }
    }
    text
}

fn written(text: &str) -> (tempfile::TempDir, std::path::PathBuf) {
    let folder = tempfile::tempdir().unwrap();
    let path = folder.path().join("d.csv");
    std::fs::write(&path, text).unwrap();
    (folder, path)
}

#[test]
fn rows_of_one_dwell_are_one_visit_and_visits_of_one_pose_one_configuration() {
    let poses = 50;
    let (_folder, path) = written(&table(poses));
    let chain = samples::scara();
    let (data, info, _) = read_measurements(&path, &chain, &MeasurementsOptions::default()).unwrap();
    assert_eq!(data.visit, (0..6 * poses).map(|row| row / 3).collect::<Vec<_>>());
    let of_visit = configurations(&data);
    assert_eq!(of_visit[poses..], of_visit[..poses]);
    assert_eq!((info.visits, info.configurations), (2 * poses, poses));
    let grouping = info.grouping.unwrap();
    assert!(!grouping.numbered && grouping.parted == 0 && grouping.flickering == 4 * poses, "{grouping:?}");
    let most = 2e-4f64.to_radians();
    assert!(grouping.flicker_angle > 0.5 * most && grouping.flicker_angle <= 1.01 * most, "{grouping:?}");
    assert_eq!((grouping.repeated, grouping.repeats), (poses, poses));
    assert!(grouping.repeat_angle > 0.0 && grouping.repeat_angle < grouping.repeat_tolerance_angle);
    // The slide moves nowhere; the flicker of the joints is no move, and the second round begins with one back.
    assert!(data.approach[2].iter().all(|&a| a == 0.0));
    assert!(data.approach[0][3..3 * poses].iter().all(|&a| a == 1.0));
    assert_eq!(data.approach[0][3 * poses], -1.0);
}

#[test]
fn a_tolerance_of_zero_is_exact() {
    let (_folder, path) = written(&table(20));
    let dwell = DwellTolerance { angle: 0.0, length: Some(0.0) };
    let options = MeasurementsOptions { dwell, ..MeasurementsOptions::default() };
    let (data, info, _) = read_measurements(&path, &samples::scara(), &options).unwrap();
    assert_eq!(info.visits, data.len());
}

#[test]
fn blocks_of_any_size_have_the_groups_of_the_whole_file() {
    // A slow sweep, dwells with flicker, a row far off in a dwell, and joints that are equal to the bit.
    let mut text = table(30);
    for step in 0..60 {
        text +=
            &format!("{:.9},0.2,0.1,0.3,1,{:.6},0\n", 1.0 + 2.4e-6 * f64::from(step), 2e-6 * f64::from(step));
    }
    text += "1.2,0.2,0.1,0.3,1,0,0\n1.2,0.2,0.1,0.3,1,0.5,0\n1.2,0.2,0.1,0.3,1,0,0\n1.2,0.2,0.1,0.3,1,0,0\n";
    let (_folder, path) = written(&text);
    let chain = samples::scara();
    let options = MeasurementsOptions::default();
    let (whole, info, _) = read_measurements(&path, &chain, &options).unwrap();
    assert_eq!(info.visits, 60 + 12 + 3, "five steps of the sweep a visit, and the row far off apart");
    assert_eq!(info.grouping.unwrap().parted, 2);
    for rows in [1, 2, 3, 7, 16, 1000] {
        let mut reader = MeasurementsReader::open(&path, &chain, &options).unwrap();
        let (mut block, mut visits) = (Dataset::default(), Vec::new());
        while reader.read_block(rows, &mut block).unwrap() > 0 {
            let next = visits.last().map_or(0, |last| last + 1);
            visits.extend(block.visit.iter().map(|visit| next + visit));
        }
        assert_eq!(visits, whole.visit, "blocks of {rows} rows");
    }
}

#[test]
fn flicker_beyond_the_tolerance_is_reported() {
    let text: String = table(20)
        .lines()
        .enumerate()
        .map(|(k, line)| match line.split_once(',') {
            Some((first, rest)) if k > 0 => {
                format!("{:.9},{rest}\n", first.parse::<f64>().unwrap() + 4e-5 * (k % 3) as f64)
            }
            _ => format!("{line}\n"),
        })
        .collect();
    let (_folder, path) = written(&text);
    let read = |dwell| {
        let options = MeasurementsOptions { dwell, ..MeasurementsOptions::default() };
        let (_, info, warnings) = read_measurements(&path, &samples::scara(), &options).unwrap();
        (info.visits, warnings.iter().map(ToString::to_string).collect::<Vec<_>>())
    };
    let (visits, warnings) = read(DwellTolerance::default());
    assert_eq!(visits, 120);
    assert!(warnings[1].contains("no column `visit`, and 80 neighbouring rows differ by"), "{warnings:?}");
    let (visits, warnings) = read(DwellTolerance { angle: 1e-4, length: None });
    assert_eq!((visits, warnings.len()), (40, 1), "{warnings:?}");
}

#[test]
fn a_target_that_was_lost_was_not_measured() {
    let text = "r1[rad],r2[rad],slide[m],r4[rad],x[m],y[m],z[m],rx[rad],ry[rad],rz[rad]\n\
                0.1,0.2,0.1,0.3,1,0,0,0,0,0.1\n0.2,0.3,0.12,0.4,0,0,0,0,0,0\n0.3,0.2,0.1,0.3,0.000,-0,0,0,0,0\n\
                0.4,0.2,0.1,0.3,0,0,,0,0,0.1\n0.5,0.2,0.1,0.3,0,0,1e-9,0,0,0.1\n";
    let (_folder, path) = written(text);
    let chain = samples::scara();
    let (data, _, warnings) = read_measurements(&path, &chain, &MeasurementsOptions::default()).unwrap();
    let seen: Vec<usize> = (0..5).map(|row| data.seen(row).count()).collect();
    assert_eq!(seen, [6, 0, 0, 5, 6]);
    let words: Vec<String> = warnings.iter().map(|w| w.message.clone()).collect();
    assert_eq!(
        words,
        [
            "x, y and z are all 0 and in line 4: read as not measured: instruments write this when the target is lost; leave the cells empty"
        ]
    );
    assert_eq!(warnings[0].line, Some(3));
    let mut reader = MeasurementsReader::open(&path, &chain, &MeasurementsOptions::default()).unwrap();
    let mut block = Dataset::default();
    reader.read_block(100, &mut block).unwrap();
    assert_eq!((0..5).map(|row| block.seen(row).count()).collect::<Vec<_>>(), seen);
    assert_eq!(reader.warnings(&chain), warnings);
}
