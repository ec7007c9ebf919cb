//! What is wrong is wrong with what observed the arm: a socket that moved, a table that is not flat, a lens that is not the stated one.

use super::tests::{Cell, Shot, campaign, cell, fitted, geometric, seen_by, shots, touching_with};
use super::*;
use crate::fit;
use rand::{RngExt, SeedableRng};
use rand_chacha::ChaCha8Rng;
use truepose_errormodel::observation::{Camera, Observation, Plane, Reading};
use truepose_errormodel::{DatasetBuilder, KnownDistance, Landmark, Measurement};
use truepose_kinematics::Conditions;
use truepose_solvers::PivotedQr;

fn tested(of: &Cell, data: &Dataset, surroundings: &Surroundings) -> Vec<Suspect> {
    let (solver, options) = (PivotedQr::default(), FitOptions::default());
    let made = touched(&of.chain, &geometric(), data, surroundings, (&solver, &options)).unwrap();
    let model = ErrorModel::new(made.chain.clone(), made.effects.clone()).unwrap();
    let found = fit(&model, &made.data, &solver, &options).unwrap();
    suspects(&found, &made.data, &made).unwrap()
}

/// What is still suspected with a suspicion allowed for, and the landmarks there are then.
fn with_it_allowed(of: &Cell, data: &Dataset, surroundings: &Surroundings) -> (Vec<Suspect>, usize, Dataset) {
    let (solver, options) = (PivotedQr::default(), FitOptions::default());
    // As rows of a file.
    let data = Dataset { line: (2..).take(data.len()).collect(), ..data.clone() };
    let made = touched(&of.chain, &geometric(), &data, surroundings, (&solver, &options)).unwrap();
    let found = tested(of, &data, surroundings);
    let (data, surroundings) = allowed_for(&found[0], &made, &data, surroundings).unwrap();
    (tested(of, &data, &surroundings), surroundings.landmarks.len(), data)
}

/// The landmarks of a cell touched in rounds, all in each: of a round and a landmark how far the tip sits from where it is said to be, in the axes
/// of the tool, and how far the landmark lies from where it was.
fn in_rounds(
    of: &Cell,
    rounds: usize,
    seed: u64,
    off: impl Fn(usize, usize) -> (Vector3<f64>, Vector3<f64>),
) -> Dataset {
    let mut rng = ChaCha8Rng::seed_from_u64(seed);
    let mut builder = DatasetBuilder::new(&of.chain);
    let mut at = Vec::new();
    for round in 0..rounds {
        for (k, socket) in of.sockets.iter().enumerate() {
            let scatter = Vector3::from_fn(|_, _| 2e-5 * rng.random_range(-1.7..1.7));
            let (tip, moved) = off(round, k);
            let q = touching_with(of, &tip, &(socket + scatter + moved), &mut rng);
            builder.push(Measurement::at(q).visit(at.len() as u64)).unwrap();
            at.push(Some(k));
        }
    }
    let mut data = builder.finish();
    data.set_landmarks(Some(&at));
    data
}

#[test]
fn a_socket_that_moved_is_named_with_the_row_and_the_way() {
    let of = cell(4);
    // From the tenth round on the fourth is elsewhere.
    let (way, still) = (Vector3::new(3e-4, 0.0, -1e-4), Vector3::zeros());
    let data = in_rounds(&of, 18, 8, |round, k| (still, if k == 3 && round >= 9 { way } else { still }));
    let landmark = |k: usize| Landmark { name: format!("L{k}"), ..Landmark::default() };
    let distance = |k: usize| KnownDistance { between: [2 * k, 2 * k + 1], value: 0.05, sd: 0.0 };
    let landmarks = (0..12).map(landmark).collect();
    // The pair of the socket that moves has no distance: it would pull the other one along.
    let distances = [0, 2, 3, 4, 5].map(distance).to_vec();
    let surroundings = Surroundings { landmarks, distances, open: false };
    let found = tested(&of, &data, &surroundings);
    assert_eq!(found.len(), 1, "{found:?}");
    assert_eq!((found[0].name.as_str(), found[0].what), ("L3", "moved"));
    let round = found[0].from.unwrap() / 12;
    assert!((8..=10).contains(&round), "{round}");
    for ((_, value, sd, _), way) in found[0].values.iter().zip(way.iter()) {
        assert!((value - way).abs() < 3e-5 + 2.0 * sd, "{value} ± {sd}, {way}");
    }
    let (left, landmarks, data) = with_it_allowed(&of, &data, &surroundings);
    assert_eq!((left, landmarks), (Vec::new(), 13));
    let of_last = (0..data.len()).filter(|&row| data.landmark(row) == Some(12));
    assert!(of_last.eq((round..18).map(|round| 12 * round + 3)));
}

#[test]
fn a_row_that_names_another_socket_is_told_with_the_one_it_touched() {
    let of = cell(40);
    let (mut data, surroundings) = campaign(&of, 14, 2e-5, 3);
    let mut at: Vec<Option<usize>> = (0..data.len()).map(|row| data.landmark(row)).collect();
    let row = at.iter().position(|at| *at == Some(2)).unwrap() + 4;
    at[row] = Some(5);
    data.set_landmarks(Some(&at));
    let found = tested(&of, &data, &surroundings);
    let told: Vec<_> =
        found.iter().map(|s| (s.name.as_str(), s.what, s.from, s.instead.as_deref())).collect();
    assert_eq!(told, [("L5", "row", Some(row), Some("L2"))]);
    let (left, _, rest) = with_it_allowed(&of, &data, &surroundings);
    assert_eq!((left, rest.len()), (Vec::new(), data.len() - 1));
}

#[test]
fn the_partner_of_a_socket_that_moved_is_not_blamed() {
    let of = cell(41);
    let (way, still) = (Vector3::new(3e-4, 0.0, -1e-4), Vector3::zeros());
    let data = in_rounds(&of, 18, 9, |round, k| (still, if k == 3 && round >= 9 { way } else { still }));
    // The pair of the socket that moves has its distance, too.
    let (_, surroundings) = campaign(&of, 3, 2e-5, 1);
    let found = tested(&of, &data, &surroundings);
    let told: Vec<_> = found.iter().map(|s| (s.name.as_str(), s.what, s.from.map(|row| row / 12))).collect();
    assert_eq!(told, [("L3", "moved", Some(9))], "{found:?}");
}

#[test]
fn a_tool_that_was_mounted_again_is_told_and_no_socket_is_blamed() {
    let of = cell(43);
    let (aside, still) = (Vector3::new(4e-4, 0.0, -1e-4), Vector3::zeros());
    let data = in_rounds(&of, 12, 10, |round, _| (if round >= 6 { aside } else { still }, still));
    let (_, surroundings) = campaign(&of, 3, 2e-5, 1);
    let found = tested(&of, &data, &surroundings);
    let told: Vec<_> = found.iter().map(|s| (s.name.as_str(), s.what, s.from.map(|row| row / 12))).collect();
    assert_eq!(told, [("tool", "mounted", Some(6))], "{found:?}");
}

#[test]
fn a_known_plane_is_told_where_it_lies_elsewhere_and_where_it_is_bent() {
    let of = cell(42);
    for (lift, bend, what) in [(2e-4, 0.0, Some("place")), (0.0, 1.5e-3, Some("flatness")), (0.0, 0.0, None)]
    {
        let mut rng = ChaCha8Rng::seed_from_u64(4);
        let mut rows = Vec::new();
        for _ in 0..60 {
            let (x, y): (f64, f64) = (rng.random_range(-0.4..0.4), rng.random_range(-0.4..0.4));
            // Bent upwards in the middle, where nobody touched it when its place was measured.
            let z = 0.1 + lift + bend * (0.1 - x * x - y * y);
            rows.push(Shot {
                landmark: 0,
                at: Some(Vector3::new(0.5 + x, y, z)),
                reads: Box::new(|_| 0.0),
                sd: 2e-5,
            });
            rows.push(Shot { landmark: 1, at: None, reads: Box::new(|_| 0.0), sd: 3e-5 });
        }
        let data = shots(&of, 1, &rows, 6);
        let point = Some(Vector3::new(0.5, 0.0, 0.1));
        let plane = Plane { normal: Some(Vector3::z()), point, known: true };
        let (made, found) = fitted(&of, &data, vec![seen_by("table", plane)]);
        let all = suspects(&found, &made.data, &made).unwrap();
        let told: Vec<&str> = all.iter().map(|suspect| suspect.what).collect();
        assert_eq!(told, what.into_iter().collect::<Vec<_>>(), "{all:?}");
    }
}

#[test]
fn landmarks_that_stay_are_not_suspected() {
    for seed in 0..8 {
        let of = cell(30 + seed);
        let (data, surroundings) = campaign(&of, 14, 2e-5, seed);
        let found = tested(&of, &data, &surroundings);
        assert!(found.is_empty(), "{seed}: {found:?}");
    }
}

#[test]
fn a_table_that_is_not_flat_is_told_from_an_arm_with_errors() {
    let of = cell(12);
    for (bend, named) in [(1.5e-3, true), (0.0, false)] {
        let mut rng = ChaCha8Rng::seed_from_u64(3);
        let mut rows = Vec::new();
        for _ in 0..70 {
            let (x, y): (f64, f64) = (rng.random_range(-0.4..0.4), rng.random_range(-0.4..0.4));
            // A tenth of a millimetre and more in the corners; a saddle with a ridge.
            let z = 0.1 + bend * (x * x - 0.6 * x * y) + 0.4 * bend * x.powi(3);
            let at = Vector3::new(0.5 + x, y, z);
            rows.push(Shot { landmark: 0, at: Some(at), reads: Box::new(|_| 0.0), sd: 2e-5 });
            rows.push(Shot { landmark: 1, at: None, reads: Box::new(|_| 0.0), sd: 3e-5 });
        }
        let data = shots(&of, 1, &rows, 5);
        let (made, found) = fitted(&of, &data, vec![seen_by("table", Plane::default())]);
        let all = suspects(&found, &made.data, &made).unwrap();
        let told: Vec<(&str, &str)> = all.iter().map(|s| (s.name.as_str(), s.what)).collect();
        assert_eq!(told.contains(&("table", "flatness")), named, "{all:?}");
        assert!(named || all.is_empty(), "{all:?}");
    }
}

#[test]
fn a_lens_with_exchanged_focal_lengths_is_named_with_the_right_ones() {
    let of = cell(13);
    let turn = nalgebra::Rotation3::from_euler_angles(-2.0, 0.1, 1.2).into_inner();
    let place = Pose::new(turn, Vector3::new(1.6, 0.9, 0.9));
    let eye = Camera {
        place: None,
        known: false,
        intrinsics: [812.0, 800.0, 640.0, 480.0],
        distortion: [0.0; 5],
        free_intrinsics: false,
        size: None,
    };
    let (exchanged, right) = ([800.0, 812.0, 640.0, 480.0], [812.0, 800.0, 640.0, 480.0]);
    for (stated, known, named) in [(exchanged, false, true), (right, false, false), (exchanged, true, true)] {
        let mut rng = ChaCha8Rng::seed_from_u64(5);
        let truth = Camera { place: Some(place), ..eye.clone() };
        let mut builder = DatasetBuilder::new(&of.chain);
        let mut predictor = of.truth.bind(&Default::default()).unwrap();
        let (mut at, mut pixels, mut reading) = (Vec::new(), [Vec::new(), Vec::new()], Reading::default());
        let mut noise = |sd: f64| sd * (0..12).map(|_| rng.random_range(-0.5..0.5)).sum::<f64>();
        let mut joints = ChaCha8Rng::seed_from_u64(6);
        while at.len() < 160 {
            let q: Vec<f64> = (0..6).map(|_| joints.random_range(-2.0..2.0)).collect();
            let here = predictor.predict(&Conditions { joints: q.clone(), ..Conditions::default() }, None);
            if !truth.read(&here, &mut reading) || !(0.0..1280.0).contains(&reading.value[0]) {
                continue;
            }
            let position = here.translation + Vector3::new(noise(3e-5), noise(3e-5), noise(3e-5));
            let row = Measurement::at(q).visit(at.len() as u64);
            let sees = at.len() % 2 == 0;
            builder.push(if sees { row } else { row.position(position) }).unwrap();
            at.push(sees.then_some(0));
            (0..2).for_each(|k| pixels[k].push(reading.value[k] + noise(0.1)));
        }
        let mut data = builder.finish();
        data.set_landmarks(Some(&at));
        let [u, v] = pixels;
        data.set_kinds(Some(at.iter().map(|at| at.map_or(0.0, |_| 5.0)).collect()), [Some(u), Some(v), None]);
        let place = known.then_some(place);
        let camera = Camera { intrinsics: stated, place, known, ..eye.clone() };
        let (made, found) = fitted(&of, &data, vec![seen_by("eye", camera)]);
        let all = suspects(&found, &made.data, &made).unwrap();
        assert_eq!(all.iter().any(|s| s.what == "lens"), named, "{all:?}");
        // A camera that stands where it is said to stand is not said to stand elsewhere.
        assert!(all.iter().all(|s| s.what == "lens"), "{all:?}");
        if named {
            let lens = all.iter().find(|s| s.what == "lens").unwrap();
            let [fx, fy] = [lens.values[0].1, lens.values[1].1];
            assert!((fx - 12.0).abs() < 3.0 && (fy + 12.0).abs() < 3.0, "{lens:?}");
        }
    }
}
