use super::*;
use crate::{Residuals, fit};
use rand::{RngExt, SeedableRng};
use rand_chacha::ChaCha8Rng;
use truepose_errormodel::observation::{Distance, Linear, Observation, Plane, Sphere};
use truepose_errormodel::{DatasetBuilder, KnownDistance, Landmark, Measurement};
use truepose_kinematics::{Conditions, samples};
use truepose_solvers::PivotedQr;

/// The arm of a light robot with errors, which touches sockets with its tool's origin: joints of touching postures are solved for here, by
/// Newton's method on the true robot, so that the law is not that of the fit.
pub(crate) struct Cell {
    pub(crate) chain: Chain,
    pub(crate) truth: FittedModel,
    pub(crate) sockets: Vec<Vector3<f64>>,
}

pub(crate) fn cell(seed: u64) -> Cell {
    let mut rng = ChaCha8Rng::seed_from_u64(seed);
    let chain = samples::ur10();
    let frames: Vec<_> = chain.frames().collect();
    let arm = Geometric {
        frames: Some(frames[1..].iter().map(|&frame| Where::Frame(frame)).collect()),
        components: None,
    };
    let model = ErrorModel::new(chain.clone(), vec![Box::new(arm)]).unwrap();
    let coefficients: Vec<f64> =
        model.columns().iter().map(|c| c.scale * rng.random_range(-3.0..3.0)).collect();
    let count = coefficients.len();
    let truth = FittedModel::new(model, coefficients, DMatrix::zeros(count, count)).unwrap();
    let mut sockets = Vec::new();
    for _ in 0..6 {
        let at = Vector3::new(
            rng.random_range(0.35..0.8),
            rng.random_range(-0.5..0.5),
            rng.random_range(0.0..0.5),
        );
        let way = Vector3::from_fn(|_, _| rng.random_range(-1.0..1.0)).normalize();
        sockets.push(at);
        sockets.push(at + 0.05 * way);
    }
    Cell { chain, truth, sockets }
}

/// Joints with which the true robot touches a point.
pub(super) fn touching(of: &Cell, at: &Vector3<f64>, rng: &mut ChaCha8Rng) -> Vec<f64> {
    touching_with(of, &Vector3::zeros(), at, rng)
}

/// The same with a tip that sits so far from where it is said to be, in the axes of the tool.
pub(super) fn touching_with(
    of: &Cell,
    tip: &Vector3<f64>,
    at: &Vector3<f64>,
    rng: &mut ChaCha8Rng,
) -> Vec<f64> {
    let mut predictor = of.truth.bind(&Default::default()).unwrap();
    loop {
        let mut q: Vec<f64> = (0..6).map(|_| rng.random_range(-2.5..2.5)).collect();
        for _ in 0..30 {
            let mut at_joints = |q: &[f64]| {
                predictor
                    .predict(&Conditions { joints: q.to_vec(), ..Conditions::default() }, None)
                    .apply(tip)
            };
            let here = at_joints(&q);
            if (here - at).norm() < 1e-10 {
                return q;
            }
            let jacobian = DMatrix::from_fn(3, 6, |row, k| {
                let mut moved = q.clone();
                moved[k] += 1e-6;
                (at_joints(&moved)[row] - here[row]) / 1e-6
            });
            let Ok(inverse) = jacobian.pseudo_inverse(1e-6) else { break };
            let step = inverse * DMatrix::from_column_slice(3, 1, (at - here).as_slice());
            q.iter_mut().zip(step.iter()).for_each(|(q, s)| *q += s.clamp(-0.5, 0.5));
        }
    }
}

pub(crate) fn campaign(of: &Cell, touches: usize, scatter: f64, seed: u64) -> (Dataset, Surroundings) {
    let mut rng = ChaCha8Rng::seed_from_u64(seed);
    let mut builder = DatasetBuilder::new(&of.chain);
    let mut at = Vec::new();
    for (k, socket) in of.sockets.iter().enumerate() {
        for _ in 0..touches {
            let off = Vector3::from_fn(|_, _| scatter * rng.random_range(-1.7..1.7));
            let q = touching(of, &(socket + off), &mut rng);
            builder.push(Measurement::at(q).visit(at.len() as u64)).unwrap();
            at.push(Some(k));
        }
    }
    let mut data = builder.finish();
    data.set_landmarks(Some(&at));
    let landmark = |k: usize| Landmark { name: format!("L{k}"), ..Landmark::default() };
    let landmarks = (0..of.sockets.len()).map(landmark).collect();
    let distance = |k: usize| KnownDistance { between: [2 * k, 2 * k + 1], value: 0.05, sd: 0.0 };
    (data, Surroundings { landmarks, distances: (0..6).map(distance).collect(), open: false })
}

pub(crate) fn geometric() -> Vec<Box<dyn AnyEffect>> {
    vec![Box::new(Geometric::default())]
}

#[test]
fn an_arm_is_calibrated_with_nothing_but_sockets_at_known_distances() {
    let of = cell(4);
    let (data, surroundings) = campaign(&of, 25, 2e-5, 9);
    let solver = PivotedQr::default();
    let options = FitOptions::default();
    let made = touched(&of.chain, &geometric(), &data, &surroundings, (&solver, &options)).unwrap();
    let groups = landmark_groups(&made.effects).unwrap();
    assert_eq!((made.distances.len(), groups[2], groups[11]), (6, Some(1), Some(5)));
    let model = ErrorModel::new(made.chain.clone(), made.effects.clone()).unwrap();
    let found = fit(&model, &made.data, &solver, &options).unwrap();
    let spread = Residuals::of(&found.fitted, &made.data).unwrap().positions().rms;
    assert!(spread < 1.1 * 2e-5 * 1.7, "{spread}");
    // Distances between sockets that nothing told, up to 0.9 m: the scale is right, at sockets that the fit has not seen as well.
    let (held, places) =
        landmark_cross_validation(&found, &made.data, &groups, (&solver, &options)).unwrap().unwrap();
    let rms = held.residuals.positions().rms;
    assert!(rms < 2.0 * 2e-5 * 1.7, "{rms}");
    let robot = found.fitted.without_landmarks().unwrap();
    assert!(robot.channels.is_empty());
    for fold in &places {
        let apart = (fold.positions[0] - fold.positions[1]).norm();
        assert!((apart - 0.05).abs() < 3e-5, "{apart}");
    }
    for k in (0..10).step_by(2) {
        let (found, truth) = (made.positions[k + 2] - made.positions[k], of.sockets[k + 2] - of.sockets[k]);
        assert!((found.norm() - truth.norm()).abs() < 1.5e-4, "{} m", found.norm() - truth.norm());
    }
}

#[test]
fn how_well_known_distances_determine_the_scale_is_stated() {
    let of = cell(5);
    let (data, mut surroundings) = campaign(&of, 8, 2e-5, 3);
    for distance in &mut surroundings.distances {
        (distance.value, distance.sd) = (0.05, 1e-4);
    }
    let (solver, options) = (PivotedQr::default(), FitOptions::default());
    let told = |surroundings: &Surroundings| {
        let made = touched(&of.chain, &geometric(), &data, surroundings, (&solver, &options)).unwrap();
        made.remarks.join("; ")
    };
    // 1.96 standard deviations of 0.2 %, of six of them less where they are independent.
    assert_eq!(surroundings.distances.len(), 6);
    let remark = told(&surroundings);
    assert!(remark.contains("±0.16 % if their errors are independent, to ±0.39 % if"), "{remark}");
    // A distance to a landmark that no row touches adds nothing.
    surroundings.landmarks.push(Landmark { name: "far".into(), ..surroundings.landmarks[0].clone() });
    let between = [0, surroundings.landmarks.len() - 1];
    surroundings.distances.push(KnownDistance { between, value: 1.0, sd: 1e-6 });
    let remark = told(&surroundings);
    assert!(remark.contains("±0.16 % if their errors are independent"), "{remark}");
    surroundings.distances.iter_mut().for_each(|distance| distance.sd = 0.0);
    let remark = told(&surroundings);
    assert!(!remark.contains("alone determine"), "{remark}");
}

#[test]
fn without_a_distance_the_scale_is_said_to_be_unknown() {
    let of = cell(5);
    let (data, mut surroundings) = campaign(&of, 8, 2e-5, 3);
    surroundings.distances.clear();
    let (solver, options) = (PivotedQr::default(), FitOptions::default());
    let made = touched(&of.chain, &geometric(), &data, &surroundings, (&solver, &options)).unwrap();
    let told = made.remarks.join("; ");
    assert!(
        told.contains("the base is not determined") && told.contains("the scale is not determined"),
        "{told}"
    );
    let groups = landmark_groups(&made.effects).unwrap();
    assert_eq!(groups.iter().max(), Some(&Some(11)));
    // The scale of the robot as described is kept: with nothing to hold it the whole arm would shrink to a point.
    assert!(told.contains("the fit keeps the scale of the robot as described"), "{told}");
    let model = ErrorModel::new(made.chain.clone(), made.effects.clone()).unwrap();
    let found = fit(&model, &made.data, &solver, &options).unwrap();
    let (held, places) =
        landmark_cross_validation(&found, &made.data, &groups, (&solver, &options)).unwrap().unwrap();
    let rms = held.residuals.positions().rms;
    assert!((2e-5..4e-4).contains(&rms), "{rms}");
    let size = |at: &[Vector3<f64>]| (0..12).map(|k| (at[k] - at[(k + 5) % 12]).norm()).sum::<f64>();
    let relative = size(&made.positions) / size(&of.sockets);
    assert!((relative - 1.0).abs() < 0.02, "{relative}");
    // In every fold, whichever landmarks it lacks: an arm that shrinks has no spread.
    assert_eq!(places.len(), 12);
    assert!(held.fold_rms.iter().all(|&rms| rms > 1e-5), "{:?}", held.fold_rms);
}

#[test]
fn one_landmark_without_any_distance_is_refused() {
    let of = cell(5);
    let (data, mut surroundings) = campaign(&of, 8, 2e-5, 3);
    surroundings.distances.clear();
    let one = data.select(&(0..8).collect::<Vec<_>>());
    let (solver, options) = (PivotedQr::default(), FitOptions::default());
    let error = touched(&of.chain, &geometric(), &one, &surroundings, (&solver, &options)).unwrap_err();
    let said = error.to_string();
    assert!(said.contains("landmark L0: a robot as small as a point would agree with every row"), "{said}");
}

#[test]
fn a_landmark_that_was_touched_once_is_refused_and_one_that_was_not_is_told() {
    let of = cell(6);
    let (data, mut surroundings) = campaign(&of, 4, 2e-5, 3);
    surroundings.landmarks.push(Landmark { name: "spare".into(), ..Landmark::default() });
    surroundings.distances.push(KnownDistance { between: [0, 2], value: 0.3, sd: 0.0 });
    surroundings.distances.push(KnownDistance { between: [1, 2], value: 0.3, sd: 0.0 });
    let (solver, options) = (PivotedQr::default(), FitOptions::default());
    let made = touched(&of.chain, &geometric(), &data, &surroundings, (&solver, &options)).unwrap();
    let told = made.remarks.join("; ");
    assert!(told.contains("no row touched landmark spare"), "{told}");
    assert!(told.contains("the distance from L") && told.contains("close a ring"), "{told}");
    let few = data.select(&(0..5).collect::<Vec<_>>());
    let error = touched(&of.chain, &geometric(), &few, &surroundings, (&solver, &options)).unwrap_err();
    assert!(error.to_string().contains("landmark L1: one row touched it"), "{error}");
}

/// What an instrument reads of a target at a point.
pub(super) type Reads = Box<dyn Fn(&Vector3<f64>) -> f64>;

/// What one row of a mixed campaign is: where the target shall be, none: anywhere; and what the instrument of a landmark then reads.
pub(super) struct Shot {
    pub(super) landmark: usize,
    pub(super) at: Option<Vector3<f64>>,
    pub(super) reads: Reads,
    pub(super) sd: f64,
}

/// Rows of these shots; positions with noise where the landmark is none of `landmarks`.
pub(super) fn shots(of: &Cell, landmarks: usize, shots: &[Shot], seed: u64) -> Dataset {
    let mut rng = ChaCha8Rng::seed_from_u64(seed);
    let mut predictor = of.truth.bind(&Default::default()).unwrap();
    let mut builder = DatasetBuilder::new(&of.chain);
    let (mut at, mut values) = (Vec::new(), Vec::new());
    for (k, shot) in shots.iter().enumerate() {
        let mut noise = || shot.sd * (0..12).map(|_| rng.random_range(-0.5..0.5)).sum::<f64>();
        let off = Vector3::new(noise(), noise(), noise());
        let scalar = noise();
        let q = match shot.at {
            Some(place) => touching(of, &(place + off), &mut rng),
            None => (0..6).map(|_| rng.random_range(-2.0..2.0)).collect(),
        };
        let here =
            predictor.predict(&Conditions { joints: q.clone(), ..Conditions::default() }, None).translation;
        let row = Measurement::at(q).visit(k as u64);
        let measured = shot.landmark >= landmarks;
        builder.push(if measured { row.position(here + off) } else { row }).unwrap();
        at.push((!measured).then_some(shot.landmark));
        values.push((shot.reads)(&here) + scalar);
    }
    let mut data = builder.finish();
    data.set_landmarks(Some(&at));
    data.set_kinds(Some(at.iter().map(|at| at.map_or(0.0, |_| 1.0)).collect()), [Some(values), None, None]);
    data
}

/// RMS of the distance between where the fitted robot and the true one are, without the place of the base, m.
pub(super) fn accuracy(of: &Cell, fitted: &FittedModel) -> f64 {
    let mut rng = ChaCha8Rng::seed_from_u64(77);
    let robot = fitted.without_landmarks().unwrap();
    let (mut a, mut b) =
        (of.truth.bind(&Default::default()).unwrap(), robot.bind(&Default::default()).unwrap());
    let pairs: Vec<[Vector3<f64>; 2]> = (0..200)
        .map(|_| {
            let joints = (0..6).map(|_| rng.random_range(-2.0..2.0)).collect();
            let at = Conditions { joints, ..Conditions::default() };
            [a.predict(&at, None).translation, b.predict(&at, None).translation]
        })
        .collect();
    let mean = |k: usize| pairs.iter().map(|pair| pair[k]).sum::<Vector3<f64>>() / pairs.len() as f64;
    let (ma, mb) = (mean(0), mean(1));
    let cross: nalgebra::Matrix3<f64> = pairs.iter().map(|[a, b]| (a - ma) * (b - mb).transpose()).sum();
    let svd = cross.svd(true, true);
    let turn = svd.u.unwrap() * svd.v_t.unwrap();
    let squares: f64 = pairs.iter().map(|[a, b]| (a - ma - turn * (b - mb)).norm_squared()).sum();
    (squares / pairs.len() as f64).sqrt()
}

pub(super) fn fitted(of: &Cell, data: &Dataset, landmarks: Vec<Landmark>) -> (Touched, crate::Fit) {
    let (solver, options) = (PivotedQr::default(), FitOptions::default());
    let surroundings = Surroundings { landmarks, ..Surroundings::default() };
    let made = touched(&of.chain, &geometric(), data, &surroundings, (&solver, &options)).unwrap();
    let model = ErrorModel::new(made.chain.clone(), made.effects.clone()).unwrap();
    let found = fit(&model, &made.data, &solver, &options).unwrap();
    (made, found)
}

pub(super) fn seen_by(name: &str, observation: impl Observation + 'static) -> Landmark {
    Landmark { name: name.into(), observed: Some(Box::new(observation)), ..Landmark::default() }
}

fn wire(landmark: usize, anchor: Vector3<f64>) -> Shot {
    Shot { landmark, at: None, reads: Box::new(move |p| (p - anchor).norm()), sd: 3e-5 }
}

#[test]
fn draw_wires_alone_calibrate_an_arm() {
    let of = cell(11);
    let anchors = [Vector3::new(1.5, 0.3, -0.5), Vector3::new(-0.9, 1.2, 0.1), Vector3::new(0.2, -1.6, 1.4)];
    let rows: Vec<Shot> = (0..240).map(|k| wire(k % 3, anchors[k % 3])).collect();
    let data = shots(&of, 3, &rows, 5);
    let landmarks = ["W1", "W2", "W3"].map(|name| seen_by(name, Distance::default())).to_vec();
    let (made, found) = fitted(&of, &data, landmarks);
    // Noise of 0.03 mm in each row, about 30 unknowns from 240 rows.
    let left = accuracy(&of, &found.fitted);
    assert!(left < 6e-5, "{left} m");
    let residual = Residuals::of(&found.fitted, &made.data).unwrap().positions().rms;
    assert!((residual / 3e-5 - 1.0).abs() < 0.2, "{residual}");
    assert!(made.remarks.join(" ").contains("the base is not determined"), "{:?}", made.remarks);
    assert!(!made.remarks.join(" ").contains("scale"), "{:?}", made.remarks);
    // Whole anchors are left out in turn.
    let groups = landmark_groups(&made.effects).unwrap();
    assert_eq!(groups, [0, 1, 2].map(Some));
    let of_fit: (&dyn Solver, &FitOptions) = (&PivotedQr::default(), &FitOptions::default());
    let (held, _) = landmark_cross_validation(&found, &made.data, &groups, of_fit).unwrap().unwrap();
    let rms = held.residuals.positions().rms;
    assert!(rms < 2.5 * 3e-5, "{rms}");
}

#[test]
fn all_kinds_are_one_fit_and_each_counts_as_it_should() {
    let of = cell(12);
    let normal = Vector3::new(0.1, -0.2, 1.0).normalize();
    let mut rng = ChaCha8Rng::seed_from_u64(3);
    let mut anywhere = || Vector3::from_fn(|_, _| rng.random_range(-1.0..1.0));
    let mut rows = Vec::new();
    for k in 0..60 {
        let anchor = Vector3::new(1.5, 0.3, -0.5);
        let gauge = Vector3::new(0.6, 0.8, 0.0);
        let table = Vector3::new(0.5, 0.0, 0.1) + anywhere() * 0.3;
        let table = table - normal * normal.dot(&(table - Vector3::new(0.5, 0.0, 0.1)));
        let ball = Vector3::new(0.5, 0.4, 0.3) + anywhere().normalize() * 0.05;
        rows.push(wire(0, anchor));
        rows.push(Shot { landmark: 1, at: Some(table), reads: Box::new(|_| 0.0), sd: 2e-4 });
        rows.push(Shot { landmark: 2, at: Some(ball), reads: Box::new(|_| 0.0), sd: 2e-5 });
        rows.push(Shot { landmark: 3, at: None, reads: Box::new(move |p| 0.2 + gauge.dot(p)), sd: 5e-5 });
        if k % 2 == 0 {
            rows.push(Shot { landmark: 9, at: None, reads: Box::new(|_| 0.0), sd: 1e-4 });
        }
    }
    let zero = |k: usize, rows: &mut Vec<Shot>| rows.retain(|shot| shot.landmark != k);
    let landmarks = || {
        vec![
            seen_by("wire", Distance::default()),
            seen_by("table", Plane::default()),
            seen_by("ball", Sphere::of_radius(0.05)),
            seen_by("gauge", Linear::default()),
        ]
    };
    let data = shots(&of, 4, &rows, 8);
    let mut exact = data.clone();
    // A probe on a plane or a ball measures nothing but that it is there.
    for row in 0..data.len() {
        if matches!(data.landmark(row), Some(1 | 2)) {
            let k = exact.schema.channel(truepose_errormodel::VALUE[0]).unwrap();
            exact.channels[k][row] = 0.0;
        }
    }
    let (made, found) = fitted(&of, &exact, landmarks());
    let sd: Vec<f64> = made.sensors.iter().map(|sensor| sensor.sd).collect();
    for (sd, truth) in sd.iter().zip([3e-5, 2e-4, 2e-5, 5e-5]) {
        assert!((sd / truth).ln().abs() < 0.4, "{sd} for {truth}");
    }
    assert!(made.remarks.is_empty(), "{:?}", made.remarks);
    let together = accuracy(&of, &found.fitted);
    // Positions alone are worse.
    (0..4).for_each(|k| zero(k, &mut rows));
    let (_, alone) = fitted(&of, &shots(&of, 0, &rows, 8), Vec::new());
    let positions = accuracy(&of, &alone.fitted);
    assert!(together < 0.6 * positions && together < 4e-5, "{together} m, of positions alone {positions} m");
}

#[test]
fn an_unknown_tool_is_found_though_no_declared_effect_has_it() {
    let of = cell(4);
    let (data, surroundings) = campaign(&of, 8, 2e-5, 9);
    let unknown = Placed { known: false, ..*of.chain.tool() };
    let chain = of.chain.clone().with_tool(unknown).unwrap();
    let springs: Vec<Box<dyn AnyEffect>> =
        vec![Box::new(truepose_errormodel::effects::JointCompliance::default())];
    let options = FitOptions::default();
    let made = |chain: &Chain| {
        touched(chain, &springs, &data, &surroundings, (&PivotedQr::default(), &options)).unwrap().effects
    };
    let at_tool = |effects: &[Box<dyn AnyEffect>]| {
        let model = ErrorModel::new(of.chain.clone(), effects.to_vec()).unwrap();
        let tool = of.chain.tool_frame();
        let sites = model.columns().iter().filter_map(|column| column.site);
        sites
            .filter(|site| matches!(site, truepose_kinematics::Site::Frame(frame, _) if *frame == tool))
            .count()
    };
    assert_eq!(at_tool(&made(&chain)), 6);
    assert_eq!(at_tool(&made(&of.chain)), 0, "a tool that is known stays as it is");
}
