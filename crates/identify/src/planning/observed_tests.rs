use super::*;
use crate::landmarks::tests::{Cell, campaign, cell, geometric};
use crate::{FitOptions, Within, fit, touched, unmeasured, within_reach};
use nalgebra::{DVector, Matrix3, Vector3};
use truepose_errormodel::observation::{Camera, Plane, Sphere};
use truepose_errormodel::{ErrorModel, KnownDistance, Landmark};
use truepose_kinematics::{Conditions, Pose};
use truepose_solvers::PivotedQr;

/// RMS error of a robot that was fitted to some rows, at postures of its whole workspace, m; the displacement of its base, which no socket shows,
/// is taken out.
fn error_of(of: &Cell, rows: &[usize], (data, surroundings): (&Dataset, &Surroundings)) -> f64 {
    let part = data.select(rows);
    let (solver, options) = (PivotedQr::default(), FitOptions::default());
    let made = touched(&of.chain, &geometric(), &part, surroundings, (&solver, &options)).unwrap();
    let model = ErrorModel::new(made.chain.clone(), made.effects.clone()).unwrap();
    let found = fit(&model, &made.data, &solver, &options).unwrap().fitted.without_landmarks().unwrap();
    let (mut truth, mut found) =
        (of.truth.bind(&Default::default()).unwrap(), found.bind(&Default::default()).unwrap());
    let (mut rows, mut right) = (Vec::new(), Vec::new());
    for k in 0..200 {
        let joints = (0..6).map(|j| 5.0 * ((k * 6 + j) as f64 * 0.618_034).fract() - 2.5).collect();
        let conditions = Conditions { joints, ..Conditions::default() };
        let (is, said) = (truth.predict(&conditions, None), found.predict(&conditions, None));
        let lever = truepose_kinematics::skew(&is.translation);
        for axis in 0..3 {
            let unit = Vector3::ith(axis, 1.0);
            rows.extend(unit.iter().copied().chain((-lever).row(axis).iter().copied()));
            right.push(is.translation[axis] - said.translation[axis]);
        }
    }
    let (a, b) = (DMatrix::from_row_slice(right.len(), 6, &rows), DVector::from_vec(right));
    let moved = a.clone().svd(true, true).solve(&b, 1e-12).unwrap();
    ((b - a * moved).norm_squared() / 200.0).sqrt()
}

#[test]
fn planned_touches_calibrate_an_arm_better_than_as_many_at_random_and_as_well_as_is_said() {
    let (mut chosen, mut drawn, mut said) = (0.0, 0.0, 0.0);
    const CELLS: u64 = 6;
    for seed in 0..CELLS {
        let of = cell(seed);
        let (data, mut surroundings) = campaign(&of, 12, 1e-4, 40 + seed);
        // Known distances from one pair to the next: the scale is not what is left.
        let apart = |k: usize| (of.sockets[2 * k] - of.sockets[2 * k + 2]).norm();
        let further = (0..5).map(|k| KnownDistance { between: [2 * k, 2 * k + 2], value: apart(k), sd: 0.0 });
        surroundings.distances.extend(further);
        let nothing = unmeasured(&of.chain, &geometric(), &surroundings).unwrap();
        let options = PlanOptions { count: 36, ..PlanOptions::default() };
        let plan = plan_observed(&nothing, (&data, &surroundings), None, &options).unwrap();
        assert!(plan.accuracy.1 < plan.at_random && plan.at_random < plan.accuracy.0, "{plan:?}");
        let rows: Vec<usize> = plan.visits.iter().flat_map(|visit| visit.rows.clone()).collect();
        // Postures of the campaign are drawn at random already.
        let as_many: Vec<usize> = (0..data.len()).filter(|row| row % 12 < 3).collect();
        assert_eq!((rows.len(), as_many.len()), (36, 36));
        let squared = |rows: &[usize]| error_of(&of, rows, (&data, &surroundings)).powi(2);
        chosen += squared(&rows);
        drawn += squared(&as_many);
        said += plan.accuracy.1.powi(2);
    }
    assert!(chosen < 0.8 * drawn, "{chosen:e} {drawn:e}");
    assert!((0.5..2.0).contains(&(chosen / said)), "{chosen:e} {said:e}");
}

#[test]
fn no_socket_is_touched_once_and_no_row_tells_where_the_base_is() {
    let of = cell(3);
    let (data, mut surroundings) = campaign(&of, 10, 1e-4, 5);
    let nothing = unmeasured(&of.chain, &geometric(), &surroundings).unwrap();
    let options = PlanOptions { count: 30, ..PlanOptions::default() };
    let plan = plan_observed(&nothing, (&data, &surroundings), None, &options).unwrap();
    let touches = |plan: &ObservedPlan, socket: usize| {
        plan.visits.iter().filter(|visit| data.landmark(visit.rows[0]) == Some(socket)).count()
    };
    assert!(plan.beyond > 0.0 && plan.visits.len() == 30);
    assert!((0..12).all(|socket| touches(&plan, socket) != 1));
    // Without distances a socket is known from its own rows alone.
    surroundings.distances.truncate(1);
    let plan = plan_observed(&nothing, (&data, &surroundings), None, &options).unwrap();
    let all: Vec<usize> = (0..12).map(|socket| touches(&plan, socket)).collect();
    assert!(all.iter().all(|touches| *touches != 1), "{all:?}");
    assert!(plan.visits.windows(2).all(|pair| pair[0].worth >= pair[1].worth));
}

fn thing(name: &str, observed: Option<Box<dyn truepose_errormodel::observation::Observation>>) -> Landmark {
    Landmark { name: name.into(), observed, ..Landmark::default() }
}

#[test]
fn postures_within_reach_touch_and_see_what_they_name() {
    let of = cell(1);
    let ball = Sphere {
        centre: Some(Vector3::new(0.5, 0.2, 0.3)),
        known: false,
        radius: Some(0.02),
        free_radius: false,
    };
    let table = Plane { normal: Some(Vector3::z()), point: Some(Vector3::new(0.0, 0.0, 0.1)), known: false };
    let lens = Camera {
        place: Some(Pose::new(Matrix3::identity(), Vector3::new(0.05, 0.0, 0.02))),
        known: false,
        intrinsics: [900.0, 900.0, 640.0, 360.0],
        distortion: [0.0; 5],
        free_intrinsics: false,
        size: Some([1280.0, 720.0]),
    };
    let socket = Landmark { position: Some(of.sockets[0]), ..thing("socket", None) };
    let somewhere = thing("somewhere", None);
    let things =
        vec![socket, somewhere, thing("ball", Some(Box::new(ball))), thing("table", Some(Box::new(table)))];
    let touching = Surroundings { landmarks: things, ..Surroundings::default() };
    let options = PlanOptions { pool: 40, ..PlanOptions::default() };
    let Within { rows, left_out } = within_reach(&of.truth, &touching, None, &options).unwrap();
    assert_eq!(left_out, [(1, "it is not said where it is".to_owned())]);
    assert_eq!(rows.len(), 3 * 14);
    let mut robot = of.truth.bind(&rows.schema).unwrap();
    for row in 0..rows.len() {
        let at = robot.predict(&rows.conditions(row), None).translation;
        let off = match rows.landmark(row) {
            Some(0) => (at - of.sockets[0]).norm(),
            Some(2) => (at - Vector3::new(0.5, 0.2, 0.3)).norm() - 0.02,
            Some(3) => at.z - 0.1,
            other => panic!("{other:?}"),
        };
        assert!(off.abs() < 2e-7, "{row}: {off}");
    }
    // A board of twelve points in front of the robot, for a camera on the flange.
    let corner = |k: usize| {
        let at = Vector3::new(0.6 + 0.03 * (k % 4) as f64, 0.03 * (k / 4) as f64, 0.05);
        Landmark { position: Some(at), known: true, ..thing(&format!("c{k}"), None) }
    };
    let eye = Landmark { mount: Some("tool".into()), ..thing("eye", Some(Box::new(lens.clone()))) };
    let board: Vec<Landmark> = [eye].into_iter().chain((0..12).map(corner)).collect();
    let around = Surroundings { landmarks: board, ..Surroundings::default() };
    let Within { rows, left_out } = within_reach(&of.truth, &around, None, &options).unwrap();
    assert!(left_out.is_empty(), "{left_out:?}");
    assert_eq!(rows.len() % 12, 0);
    assert!(rows.len() >= 20 * 12, "{}", rows.len());
    for row in 0..rows.len() {
        let tool = robot.predict(&Conditions { channels: Vec::new(), ..rows.conditions(row) }, None);
        let point = around.landmarks[rows.point(row).unwrap()].position.unwrap();
        let own = lens.place.unwrap().inverse().apply(&tool.inverse().apply(&point));
        let pixel = [640.0 + 900.0 * own.x / own.z, 360.0 + 900.0 * own.y / own.z];
        assert!(own.z > 0.0 && (0.0..1280.0).contains(&pixel[0]) && (0.0..720.0).contains(&pixel[1]));
    }
    let plan = plan_observed(
        &of_sizes(&of, &around),
        (&rows, &around),
        None,
        &PlanOptions { count: 8, ..options.clone() },
    );
    let plan = plan.unwrap();
    assert!(plan.visits.iter().all(|visit| visit.rows.len() == 12));
    assert!(plan.accuracy.1 < 0.8 * plan.accuracy.0, "{plan:?}");

    let unplaced = Landmark {
        mount: Some("tool".into()),
        ..thing("eye", Some(Box::new(Camera { place: None, ..lens })))
    };
    let board: Vec<Landmark> = [unplaced].into_iter().chain((0..12).map(corner)).collect();
    let around = Surroundings { landmarks: board, ..Surroundings::default() };
    let error = within_reach(&of.truth, &around, None, &options).unwrap_err().to_string();
    assert!(error.contains("eye: it is not said where it sits on the robot"), "{error}");
}

fn of_sizes(of: &Cell, surroundings: &Surroundings) -> FittedModel {
    unmeasured(&of.chain, &geometric(), surroundings).unwrap()
}
