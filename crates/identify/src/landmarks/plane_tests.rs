//! Planes of known place: what they tell of the scale.

use super::tests::{Cell, Shot, accuracy, cell, fitted, geometric, seen_by, shots};
use super::*;
use crate::fit;
use rand::{RngExt, SeedableRng};
use rand_chacha::ChaCha8Rng;
use truepose_errormodel::Landmark;
use truepose_errormodel::observation::Plane;
use truepose_solvers::PivotedQr;

/// Normals and a point of each: three faces of a cube, and one that is parallel to the first.
const FACES: [([f64; 3], [f64; 3]); 4] = [
    ([0.0, 0.0, 1.0], [0.55, 0.1, 0.05]),
    ([-1.0, 0.0, 0.0], [0.75, 0.0, 0.45]),
    ([0.0, -1.0, 0.0], [0.1, 0.7, 0.4]),
    ([0.0, 0.0, -1.0], [0.5, -0.2, 0.55]),
];

/// So many probed points on each of the first of them, with this noise.
fn probed(of: &Cell, (points, faces): (usize, usize), sd: f64) -> (Dataset, Vec<Landmark>) {
    let mut rng = ChaCha8Rng::seed_from_u64(3);
    let mut rows = Vec::new();
    for k in 0..points * faces {
        let (normal, point) = (Vector3::from(FACES[k % faces].0), Vector3::from(FACES[k % faces].1));
        let beside = Vector3::from_fn(|_, _| rng.random_range(-0.25..0.25));
        let at = Some(point + beside - normal * normal.dot(&beside));
        rows.push(Shot { landmark: k % faces, at, reads: Box::new(move |p| normal.dot(&(p - point))), sd });
    }
    let landmark = |k: usize| {
        let (normal, point) = (Some(Vector3::from(FACES[k].0)), Some(Vector3::from(FACES[k].1)));
        let plane = Plane { normal, point, known: true };
        Landmark { known: true, position: point, ..seen_by(&format!("P{k}"), plane) }
    };
    (shots(of, faces, &rows, 8), (0..faces).map(landmark).collect())
}

#[test]
fn known_planes_tell_the_scale_where_they_do_not_meet_in_one_point() {
    let of = cell(6);
    let (data, landmarks) = probed(&of, (40, 4), 2e-5);
    let (made, found) = fitted(&of, &data, landmarks);
    assert!(made.has_scale && !made.remarks.join(" ").contains("scale"), "{:?}", made.remarks);
    let left = accuracy(&of, &found.fitted);
    assert!(left < 3e-4, "{left}");
    let (data, landmarks) = probed(&of, (40, 3), 2e-5);
    let (made, _) = fitted(&of, &data, landmarks);
    let told = made.remarks.join(" ");
    assert!(!made.has_scale && told.contains("known planes that do not all meet in one point"), "{told}");
}

#[test]
fn a_robot_that_shrinks_into_the_corner_of_three_planes_is_refused() {
    let of = cell(6);
    // With next to no noise the corner, in which every row agrees exactly, is more likely than any robot. Whether the iteration ends there, as
    // with 40 points a plane, or at the robot with its errors held, as with these, hangs on the points: it has to be one of the two, and said.
    let (data, landmarks) = probed(&of, (20, 3), 1e-9);
    let surroundings = Surroundings { landmarks, ..Surroundings::default() };
    let (solver, options) = (PivotedQr::default(), FitOptions::default());
    match touched(&of.chain, &geometric(), &data, &surroundings, (&solver, &options)) {
        Err(error) => assert!(error.to_string().contains("times as large as it is described"), "{error}"),
        Ok(made) => {
            assert!(!made.has_scale);
            let model = ErrorModel::new(made.chain.clone(), made.effects.clone()).unwrap();
            let found = fit(&model, &made.data, &solver, &made.options(&options)).unwrap();
            let left = accuracy(&of, &found.fitted);
            assert!(left < 1e-3, "{left}");
        }
    }
}

#[test]
fn a_robot_of_another_size_is_refused() {
    let of = cell(6);
    let (data, _) = probed(&of, (20, 3), 2e-5);
    let poses = sensors::poses(&bare(&of.chain).unwrap(), &data).unwrap();
    let sized = |by: f64| -> Vec<Pose> {
        poses.iter().map(|pose| Pose { translation: pose.translation * by, ..*pose }).collect()
    };
    for within in [0.92, 1.0, 1.08] {
        same_size(&poses, &sized(within)).unwrap();
    }
    for beyond in [0.0, 1e-6, 0.85, 1.15] {
        let told = same_size(&poses, &sized(beyond)).unwrap_err().to_string();
        assert!(told.contains(&format!("{beyond:.2} times as large as it is described")), "{told}");
    }
}
