//! The null space of the constant errors in closed form gives the same groups as the numerical one.
//!
//! | symbol | here | unit |
//! | --- | --- | --- |
//! | η = (v, ω) | a twist: a small error of one frame, in its axes | m, rad |
//! | Ad(X) η | the same displacement seen from the frame in front of X: (R v + p × R ω, R ω) | m, rad |
//!
//! An error η behind joint i that commutes with its motion M(q) can stand in front of it as well, at the frame before:
//! for a turn the rotation about and the translation along the axis, for a slide the three translations and
//! the rotation about the axis, for a fixed joint all six; and all six between frame n and the tool. So
//! `η at one, −Ad(A(0)) η at the other` moves nothing. Targets take part where they are declared.

use crate::plants::{bounded, with_three_targets};
use nalgebra::{DMatrix, SVector, Vector3};
use truepose_errormodel::effects::Geometric;
use truepose_errormodel::{Dataset, ErrorModel, Visits};
use truepose_identify::NoiseModel;
use truepose_identify::engine::factorise;
use truepose_identify::reduction::{Cause, Reduction, echelon, preference, reduce};
use truepose_kinematics::{Axis, Chain, FrameId, JointId, JointKind, Pose, Site, TargetId, samples};
use truepose_simulate::{Campaign, Instrument, Plant};
use truepose_solvers::RankRule;

type Twist6 = SVector<f64, 6>;

fn adjoint(pose: &Pose, twist: &Twist6) -> Twist6 {
    let v: Vector3<f64> = pose.rotation * twist.fixed_rows::<3>(0);
    let w: Vector3<f64> = pose.rotation * twist.fixed_rows::<3>(3);
    let moved = v + pose.translation.cross(&w);
    Twist6::from_iterator(moved.iter().chain(w.iter()).copied())
}

fn along(axis: Vector3<f64>) -> Twist6 {
    Twist6::from_iterator(axis.iter().copied().chain([0.0; 3]))
}

fn about(axis: Vector3<f64>) -> Twist6 {
    Twist6::from_iterator([0.0; 3].into_iter().chain(axis.iter().copied()))
}

fn all_six() -> Vec<Twist6> {
    (0..6).map(|k| Twist6::from_fn(|i, _| if i == k { 1.0 } else { 0.0 })).collect()
}

/// What the instrument sees.
#[derive(Debug, Clone)]
struct Seen {
    /// Targets, none being the tool's origin.
    targets: Vec<Option<TargetId>>,
    oriented: bool,
}

/// A null vector in the making, over all sites of the robot.
struct Relation<'a> {
    chain: &'a Chain,
    values: Vec<f64>,
}

impl<'a> Relation<'a> {
    fn new(chain: &'a Chain) -> Self {
        Relation { chain, values: vec![0.0; chain.site_count()] }
    }

    fn at(mut self, frame: FrameId, twist: &Twist6) -> Self {
        for axis in Axis::ALL {
            self.values[self.chain.site_index(Site::Frame(frame, axis))] += twist[axis.index()];
        }
        self
    }

    /// The opposite of what a twist at the tool does to a target.
    fn against_target(mut self, target: TargetId, twist: &Twist6) -> Self {
        let (v, w) = (twist.fixed_rows::<3>(0), twist.fixed_rows::<3>(3));
        let w: Vector3<f64> = w.into();
        let moved = v + w.cross(&self.chain.targets()[target.0].position);
        for axis in Axis::TRANSLATIONS {
            self.values[self.chain.site_index(Site::Target(target, axis))] -= moved[axis.direction()];
        }
        self
    }
}

/// The null space of all constant errors of a robot, one vector each, in closed form.
fn closed_form(chain: &Chain, seen: &Seen) -> Vec<Vec<f64>> {
    let mut null = Vec::new();
    for (index, joint) in chain.joints().iter().enumerate() {
        let motion = chain.joint_motion(JointId(index + 1));
        let (before, after) = (FrameId(index), FrameId(index + 1));
        let free: Vec<Twist6> = match (joint.kind, &motion) {
            (JointKind::Revolute, Some(m)) => vec![along(m.axis), about(m.axis)],
            (JointKind::Prismatic, Some(m)) => {
                let mut free: Vec<Twist6> = all_six()[..3].to_vec();
                free.push(about(m.axis));
                free
            }
            _ => all_six(),
        };
        let step = joint.transform(0.0);
        for twist in free {
            let relation = Relation::new(chain);
            // With standard DH the axis lies in front of the transform, else behind it.
            let in_front = motion.is_some_and(|m| m.frame == before);
            null.push(if in_front {
                relation.at(before, &twist).at(after, &-adjoint(&step.inverse(), &twist)).values
            } else {
                relation.at(after, &twist).at(before, &-adjoint(&step, &twist)).values
            });
        }
    }
    let (last, tool) = (FrameId(chain.joints().len()), chain.tool_frame());
    for twist in all_six() {
        null.push(
            Relation::new(chain).at(tool, &twist).at(last, &-adjoint(&chain.tool().pose, &twist)).values,
        );
    }
    // What the tool does to everything that is seen, the targets' own positions can undo.
    let declared: Vec<TargetId> = seen.targets.iter().flatten().copied().collect();
    let origin_seen = seen.targets.contains(&None);
    for (k, twist) in all_six().into_iter().enumerate() {
        let undone = match (origin_seen, k < 3) {
            (true, true) => false,
            (true, false) | (false, false) => !seen.oriented,
            (false, true) => true,
        };
        if undone {
            let relation = Relation::new(chain).at(tool, &twist);
            null.push(declared.iter().fold(relation, |r, &t| r.against_target(t, &twist)).values);
        }
    }
    // A target that nobody looks at.
    for target in (0..chain.targets().len()).map(TargetId).filter(|t| !declared.contains(t)) {
        for axis in Axis::TRANSLATIONS {
            let mut values = vec![0.0; chain.site_count()];
            values[chain.site_index(Site::Target(target, axis))] = 1.0;
            null.push(values);
        }
    }
    null
}

fn data(chain: &Chain, seen: &Seen) -> Dataset {
    let mut plant = Plant::perfect(chain).unwrap();
    plant.instrument = Instrument { orientation_sd: seen.oriented.then_some(0.0), ..Instrument::default() };
    let mut campaign = Campaign::random(chain, 70, 4).unwrap();
    campaign.targets.clone_from(&seen.targets);
    plant.measure(&campaign, 4).unwrap()
}

fn numerical(model: &ErrorModel, data: &Dataset) -> Reduction {
    let zero = vec![0.0; model.columns().len()];
    let factor = factorise(model, data, &Visits::of(data), NoiseModel::default(), &zero, None).unwrap();
    reduce(model, data, &factor, RankRule::Default, &zero).unwrap()
}

fn check(chain: &Chain, seen: &Seen) {
    let case = format!("{}, {seen:?}", chain.name());
    let model = ErrorModel::new(chain.clone(), vec![Box::new(Geometric::default())]).unwrap();
    let columns = model.columns();
    for (k, column) in columns.iter().enumerate() {
        assert_eq!(column.site, Some(chain.site_at(k)), "one column a site, in order");
    }
    let data = data(chain, seen);
    let reduction = numerical(&model, &data);

    let null = closed_form(chain, seen);
    let scaled = DMatrix::from_fn(columns.len(), null.len(), |i, j| null[j][i] / columns[i].scale);
    let svd = scaled.svd(true, false);
    let (largest, smallest) = (svd.singular_values.max(), svd.singular_values.min());
    assert!(smallest > 1e-6 * largest, "{case}: the closed form contradicts itself");
    let form = echelon(&svd.u.unwrap(), &preference(&model));

    assert_eq!(reduction.structural.rank, columns.len() - null.len(), "{case}");
    assert!(reduction.structural.is_clear(), "{case}: {:?}", reduction.structural);
    assert!(reduction.dropped.iter().all(|d| d.cause == Cause::Structural), "{case}");
    let mut dropped = form.dropped.clone();
    dropped.sort_unstable();
    let numerically: Vec<usize> = reduction.dropped.iter().map(|d| d.column).collect();
    assert_eq!(dropped, numerically, "{case}");
    let mut worst = 0.0f64;
    for (row, &column) in form.dropped.iter().enumerate() {
        let other = reduction.dropped.iter().find(|d| d.column == column).unwrap();
        for j in (0..columns.len()).filter(|&j| j != column) {
            // In scaled columns, where everything is of order one.
            let numerically = other.relation.iter().find(|r| r.0 == j).map_or(0.0, |r| r.1);
            let numerically = numerically * columns[column].scale / columns[j].scale;
            worst = worst.max((form.relations[(row, j)] - numerically).abs());
        }
    }
    println!("{case}: rank {}, relations agree to {worst:.1e}", reduction.structural.rank);
    assert!(worst < 1e-8, "{case}: {worst}");
}

fn three() -> Vec<Option<TargetId>> {
    (0..3).map(|k| Some(TargetId(k))).collect()
}

#[test]
fn three_targets() {
    for chain in samples::all() {
        let chain = if chain.targets().is_empty() { with_three_targets(&chain) } else { chain };
        check(&chain, &Seen { targets: three(), oriented: false });
    }
}

#[test]
fn full_poses() {
    for chain in samples::all() {
        check(&bounded(&chain), &Seen { targets: vec![None], oriented: true });
    }
}

#[test]
fn one_target_hides_the_rotations_about_it() {
    for chain in
        [with_three_targets(&samples::ur10()), samples::heavy(), with_three_targets(&samples::seven())]
    {
        check(&chain, &Seen { targets: vec![Some(TargetId(1))], oriented: false });
    }
}

#[test]
fn poses_of_targets_and_the_tools_origin_beside_a_target() {
    let chain = with_three_targets(&samples::ur10());
    check(&chain, &Seen { targets: three(), oriented: true });
    let heavy = samples::heavy();
    check(&heavy, &Seen { targets: vec![None, Some(TargetId(0)), Some(TargetId(2))], oriented: false });
}
