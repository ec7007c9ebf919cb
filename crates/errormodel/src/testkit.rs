//! The conformance kit for effects and kinds of observation, ours and a stranger's: `check_effect(&effect, &robot)`,
//! `check_observation(&observation)`.

use crate::batch::Lanes;
use crate::observation::{Observation, Reading};
use crate::{Channel, Dataset, Effect, EffectRegistry, Emission, Entry, ErrorModel, Schema};
use std::collections::BTreeMap;
use truepose_kinematics::nalgebra::Vector3;
use truepose_kinematics::{Chain, Conditions, Load, Payload, Pose, PostureBuffer, rotation_vector};

/// Checks what every effect promises, on this robot.
///
/// * as many columns are emitted to as are declared, with finite values at sites that the robot has;
/// * expected sizes are positive, names differ;
/// * evaluation is pure: the same posture gives the same emission;
/// * it comes back from a file as itself;
/// * shape parameters read back what was set;
/// * where it says that it is springs, it emits what springs would.
///
/// # Panics
/// When one of these does not hold: it is meant for tests.
#[track_caller]
pub fn check_effect<E: Effect>(effect: &E, chain: &Chain) {
    effect.validate(chain).unwrap_or_else(|error| panic!("refused by its own validate: {error}"));
    let columns = Effect::columns(effect, chain);
    for (k, column) in columns.iter().enumerate() {
        assert!(column.scale.is_finite() && column.scale > 0.0, "expected size of `{}`", column.name);
        assert!(!column.unit.is_empty(), "`{}` has no unit", column.name);
        let same = columns[..k].iter().any(|other| other.name == column.name);
        assert!(!same, "two columns are called `{}`", column.name);
    }

    let first = emissions(effect, chain);
    assert_eq!(first, emissions(effect, chain), "evaluation is not pure");
    for entry in first.iter().flatten() {
        assert!(entry.column < columns.len(), "emits to column {} of {}", entry.column, columns.len());
        assert!(entry.value.is_finite(), "emits {} for `{}`", entry.value, columns[entry.column].name);
        assert!(chain.site_index(entry.site) < chain.site_count(), "emits at {:?}", entry.site);
    }

    check_lanes(effect, chain, &first);

    let json = serde_json::to_value(effect).unwrap_or_else(|error| panic!("cannot be written: {error}"));
    let registry = EffectRegistry::empty().with::<E>();
    let back = registry
        .build(E::FAMILY, json.clone(), chain)
        .unwrap_or_else(|error| panic!("cannot be read back: {error}"));
    assert_eq!(back.parameters(), json, "comes back from a file as something else");

    let shape = effect.shape();
    let values: Vec<f64> = shape.iter().map(|s| 0.5 * (s.lower + s.upper)).collect();
    let moved = effect.with_nonlinear(&values).shape();
    assert_eq!(moved.len(), shape.len());
    for (now, value) in moved.iter().zip(&values) {
        assert!((now.value - value).abs() <= 1e-12 * value.abs(), "shape `{}` does not read back", now.name);
    }

    if let Some(joints) = effect.compliances(chain) {
        assert_eq!(joints.len(), columns.len(), "springs: one joint for each column");
        assert!(effect.needs().is_empty(), "springs read no signals");
        let mut buffer = PostureBuffer::new(chain);
        for (k, said) in first.iter().enumerate() {
            let conditions = tried(chain, k, 0);
            let posture = buffer.update(chain, &conditions);
            let mut springs = Emission::new();
            for (column, &joint) in joints.iter().enumerate() {
                if let Some(motion) = chain.joint_motion(joint) {
                    springs.along(column, &motion, posture.joint_load(joint));
                }
            }
            assert_eq!(springs.entries(), said, "emits other than springs would");
        }
    }
}

/// A block of rows says what each of them does.
fn check_lanes<E: Effect>(effect: &E, chain: &Chain, first: &[Vec<Entry>]) {
    let (model, schema) = (model(effect, chain), everything(effect));
    let conditions: Vec<Conditions> =
        (0..first.len()).map(|k| tried(chain, k, schema.channels.len())).collect();
    let column = |of: &dyn Fn(&Conditions) -> f64| conditions.iter().map(of).collect::<Vec<f64>>();
    let count = conditions.len();
    let movable = 0..chain.movable().len();
    let data = Dataset {
        joints: movable.clone().map(|k| column(&|at| at.joints[k])).collect(),
        approach: movable.map(|k| column(&|at| at.approach[k])).collect(),
        channels: (0..schema.channels.len()).map(|k| column(&|at| at.channels[k])).collect(),
        time: column(&|at| at.time),
        load: conditions.iter().map(|at| at.load).collect(),
        position: vec![[f64::NAN; 3]; count],
        position_sd: vec![[f64::NAN; 3]; count],
        orientation: vec![None; count],
        orientation_sd: vec![[f64::NAN; 3]; count],
        target: vec![None; count],
        visit: (0..count).collect(),
        schema: schema.clone(),
        ..Dataset::default()
    };
    let bound = model.bind(&schema).unwrap_or_else(|error| panic!("cannot be bound: {error}"));
    let mut lanes = Lanes::new(bound);
    lanes.gather(&data, &(0..count).collect::<Vec<usize>>());
    lanes.settle(&data, &vec![0.0; model.columns().len()]);
    for (row, entries) in first.iter().enumerate() {
        let mut said: BTreeMap<(usize, usize), f64> = BTreeMap::new();
        for entry in entries {
            *said.entry((entry.column, chain.site_index(entry.site))).or_default() += entry.value;
        }
        let mut in_block: BTreeMap<(usize, usize), f64> = BTreeMap::new();
        for phi in lanes.phi() {
            *in_block.entry((phi.column, chain.site_index(phi.site))).or_default() +=
                phi.factor * phi.values[row];
        }
        for (place, value) in said.iter().chain(&in_block) {
            let [one, many] = [&said, &in_block].map(|map| map.get(place).copied().unwrap_or(0.0));
            let close = (one - many).abs() <= 1e-11 * (1.0 + value.abs());
            assert!(close, "a block says {many} where a row says {one} ({:?})", model.columns()[place.0]);
        }
    }
}

/// What an effect emits under these conditions; channels stand in the order in which it asks for them.
///
/// # Panics
/// When it makes no model on this robot.
#[track_caller]
pub fn emitted<E: Effect>(effect: &E, chain: &Chain, conditions: &Conditions) -> Vec<Entry> {
    let model = model(effect, chain);
    let schema = everything(effect);
    let bound = model.bind(&schema).unwrap_or_else(|error| panic!("cannot be bound: {error}"));
    let mut out = Emission::new();
    bound.emit(&PostureBuffer::new(chain).update(chain, conditions), &mut out);
    out.entries().to_vec()
}

fn model<E: Effect>(effect: &E, chain: &Chain) -> ErrorModel {
    ErrorModel::new(chain.clone(), vec![Box::new(effect.clone())])
        .unwrap_or_else(|error| panic!("makes no model: {error}"))
}

/// A schema with every signal that the effect asks for.
fn everything<E: Effect>(effect: &E) -> Schema {
    let needed = Effect::needs(effect).into_iter().filter_map(|signal| match signal {
        crate::Signal::Channel(name) => Some(Channel { name, unit: "1".into(), temperature: false }),
        _ => None,
    });
    Schema { channels: needed.collect(), time: true, load: true, approach: true }
}

/// Emissions at three postures: unloaded, loaded, and with every signal that it asks for.
fn emissions<E: Effect>(effect: &E, chain: &Chain) -> Vec<Vec<Entry>> {
    let (model, schema) = (model(effect, chain), everything(effect));
    let bound = model.bind(&schema).unwrap_or_else(|error| panic!("cannot be bound: {error}"));
    let mut buffer = PostureBuffer::new(chain);
    let mut out = Emission::new();
    (0..3)
        .map(|k| {
            let conditions = tried(chain, k, schema.channels.len());
            bound.emit(&buffer.update(chain, &conditions), &mut out);
            out.entries().to_vec()
        })
        .collect()
}

/// The k-th of those postures.
fn tried(chain: &Chain, k: usize, channels: usize) -> Conditions {
    let n = chain.movable().len();
    let joints: Vec<f64> = (0..n).map(|j| 0.1 + 0.13 * (j * k) as f64 - 0.05 * k as f64).collect();
    let mut conditions = Conditions::at(chain, &joints);
    if k > 0 {
        let com = Vector3::new(0.02, 0.03, 0.1);
        conditions.load = Load::Payload(Payload { mass: 20.0 * k as f64, com });
    }
    conditions.time = 100.0 * k as f64;
    conditions.channels = vec![20.0 + k as f64; channels];
    conditions.approach = (0..n).map(|j| if (j + k).is_multiple_of(2) { 1.0 } else { -1.0 }).collect();
    conditions
}

/// Checks what every kind of observation promises, at poses around it.
///
/// * as many numbers and derivatives as it declares, all finite;
/// * expected sizes are positive, names differ;
/// * H and K are the derivatives of h, against central differences;
/// * a step of zero leaves it as it is.
///
/// # Panics
/// When one of these does not hold: it is meant for tests.
#[track_caller]
pub fn check_observation(of: &dyn Observation) {
    let unknowns = of.unknowns("it", 1.0);
    for (k, column) in unknowns.iter().enumerate() {
        assert!(column.scale.is_finite() && column.scale > 0.0, "expected size of `{}`", column.name);
        assert!(!column.unit.is_empty() && column.name.contains("it"), "`{}`", column.name);
        assert!(
            unknowns[..k].iter().all(|other| other.name != column.name),
            "two are called `{}`",
            column.name
        );
    }
    assert!((1..=3).contains(&of.numbers()), "one number a row, two or three");
    let read = |of: &dyn Observation, at: &Pose| {
        let mut reading = Reading::default();
        of.read(at, &mut reading).then_some(reading)
    };
    let mut tried = 0;
    for at in scattered(12) {
        let Some(here) = read(of, &at) else { continue };
        tried += 1;
        assert_eq!(
            (here.value.len(), here.by_pose.len(), here.by_own.len()),
            (of.numbers(), of.numbers(), of.numbers())
        );
        assert!(here.by_own.iter().all(|own| own.len() == unknowns.len()), "K has a column for each unknown");
        let same = read(&*of.moved(&vec![0.0; unknowns.len()]), &at);
        assert!(same.is_some_and(|same| (same.value[0] - here.value[0]).abs() < 1e-9), "no step moves it");
        const STEP: f64 = 1e-5;
        let close =
            |plus: Option<Reading>, minus: Option<Reading>, what: &str, has: &dyn Fn(usize) -> f64| {
                let (Some(plus), Some(minus)) = (plus, minus) else { panic!("cannot see {what}") };
                for k in 0..of.numbers() {
                    let difference = (plus.value[k] - minus.value[k]) / (2.0 * STEP);
                    let size = 1.0 + difference.abs();
                    assert!((has(k) - difference).abs() < 1e-6 * size, "{what}: {} for {difference}", has(k));
                }
            };
        for axis in 0..6 {
            let moved = |by: f64| {
                let mut to = at;
                match axis {
                    0..3 => to.translation[axis] += by,
                    _ => to.rotation = rotation_vector(&(Vector3::ith(axis - 3, by))) * at.rotation,
                }
                read(of, &to)
            };
            close(moved(STEP), moved(-STEP), &format!("pose {axis}"), &|k| here.by_pose[k][axis]);
        }
        for own in 0..unknowns.len() {
            let moved = |by: f64| {
                let mut step = vec![0.0; unknowns.len()];
                step[own] = by;
                read(&*of.moved(&step), &at)
            };
            close(moved(STEP), moved(-STEP), &unknowns[own].name, &|k| here.by_own[k][own]);
        }
    }
    assert!(tried > 0, "nothing can be observed at any pose");
}

/// Poses about the origin, a metre around it, for tests of observations: always the same.
pub fn scattered(count: usize) -> Vec<Pose> {
    let wave = |k: usize, seed: f64| (seed * (k as f64 + 1.0) * 12.9898).sin();
    let pose = |k: usize| {
        let turn = Vector3::new(wave(k, 1.1), wave(k, 2.3), wave(k, 3.7));
        Pose::new(rotation_vector(&turn), Vector3::new(wave(k, 0.7), wave(k, 1.9), 0.8 * wave(k, 3.1)))
    };
    (0..count).map(pose).collect()
}
