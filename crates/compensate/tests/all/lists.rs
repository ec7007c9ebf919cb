//! Lists of commands: what is computed side by side is what one after the other says, and the exact model agrees.

use crate::fits::{Draw, beside, elastic, fitted, load, target_at};
use truepose_compensate::{
    Approach, Command, CommandRequest, Compensator, CompensatorOptions, Status, Target,
};
use truepose_errormodel::effects::{Geometric, JointCompliance, OwnWeight};
use truepose_errormodel::{FittedModel, Schema};
use truepose_kinematics::nalgebra::Vector3;
use truepose_kinematics::{
    Chain, Conditions, Gravity, GravityFrame, Joint, JointKind, Load, Placement, TargetId, Wrench,
    rotation_log, samples,
};

fn schema() -> Schema {
    Schema { channels: vec![], time: true, load: true, approach: true }
}

/// A standard DH table whose links weigh something, one joint that does not move, and gravity that goes with the base.
fn weighty() -> Chain {
    let mut joints: Vec<Joint> = samples::ur10().joints().to_vec();
    for (k, joint) in joints.iter_mut().enumerate() {
        *joint = joint.clone().with_link(9.0 - k as f64, [0.02, -0.05, 0.03 * k as f64]);
    }
    let flange = Placement::Dh { theta: 0.2, d: 0.05, a: 0.0, alpha: 0.1 };
    joints.push(Joint::new("flange", JointKind::Fixed, flange).with_link(1.2, [0.0, 0.01, 0.02]));
    let gravity = Gravity { vector: Vector3::new(0.4, -0.7, -9.75), frame: GravityFrame::Base };
    Chain::new("weighty", joints).and_then(|chain| chain.with_gravity(gravity)).expect("a robot")
}

fn robots() -> Vec<Chain> {
    let mut robots = samples::all();
    robots.push(weighty());
    robots
}

struct Jobs {
    conditions: Vec<Conditions>,
    targets: Vec<Target>,
    seeds: Vec<Option<Vec<f64>>>,
}

impl Jobs {
    fn list(&self) -> Vec<CommandRequest<'_>> {
        let each = self.targets.iter().zip(&self.conditions).zip(&self.seeds);
        each.map(|((target, conditions), seed)| CommandRequest {
            target: *target,
            conditions,
            seed: seed.as_deref(),
        })
        .collect()
    }
}

/// Poses of every kind: loaded and not, points of the tool, seeds beside and far, beyond reach, and what cannot be asked.
fn mixed(chain: &Chain, fit: &FittedModel, count: usize) -> Jobs {
    let mut draw = Draw(17);
    let mut predictor = fit.bind(&schema()).expect("a predictor");
    let mut jobs = Jobs { conditions: vec![], targets: vec![], seeds: vec![] };
    for k in 0..count {
        let mut conditions = Conditions::at(chain, &draw.joints(chain, 0.97));
        if k % 3 == 1 {
            conditions.load = load(chain);
        }
        if k % 17 == 5 {
            let (force, moment) = (Vector3::new(3.0, -5.0, 20.0), Vector3::new(0.5, 0.1, -0.2));
            conditions.load = Load::Wrench(Wrench { force, moment });
        }
        let id = if chain.targets().is_empty() || k % 4 == 0 { None } else { Some(TargetId(k % 3)) };
        let mut target = target_at(&predictor.predict(&conditions, id)).of(id);
        let mut seed = Some(beside(&conditions, if k % 11 == 3 { 1.0 } else { 0.02 }, &mut draw));
        match k % 23 {
            7 => target.position += Vector3::new(30.0, 0.0, 0.0),
            9 => target.orientation = None,
            13 => target.position.x = f64::NAN,
            19 => seed = None,
            21 => seed = Some(conditions.joints.iter().map(|q| q + 50.0).collect()),
            _ => {}
        }
        jobs.conditions.push(conditions);
        jobs.targets.push(target);
        jobs.seeds.push(seed);
    }
    jobs
}

fn one_by_one(compensator: &mut Compensator<'_>, list: &[CommandRequest<'_>]) -> Vec<Command> {
    list.iter().map(|one| compensator.command(&one.target, one.conditions, one.seed)).collect()
}

/// The same bits: also where an error is no number or infinite.
fn same(a: &Command, b: &Command) -> bool {
    a.joints.iter().zip(&*b.joints).all(|(a, b)| a.to_bits() == b.to_bits())
        && a.position_error.to_bits() == b.position_error.to_bits()
        && a.orientation_error.to_bits() == b.orientation_error.to_bits()
        && (a.status, a.approach_holds) == (b.status, b.approach_holds)
        && a.approach == b.approach
        && a.extrapolation == b.extrapolation
}

#[test]
fn a_list_is_what_its_lines_are_to_the_last_bit() {
    for chain in robots() {
        for fit in [elastic(&chain, 5), fitted(&chain, 5)] {
            let jobs = mixed(&chain, &fit, 300);
            for approach in [Approach::Stated, Approach::FromSeed] {
                let options = CompensatorOptions { approach, ..CompensatorOptions::default() };
                let mut compensator = Compensator::bind(&fit, &schema(), options).expect("bound");
                let list = jobs.list();
                let single = one_by_one(&mut compensator, &list);
                // Cut differently, neighbours are others.
                for size in [300, 7, 1] {
                    let mut together = Vec::new();
                    list.chunks(size).for_each(|part| compensator.commands(part, &mut together));
                    assert_eq!(together.len(), single.len());
                    for (k, (a, b)) in together.iter().zip(&single).enumerate() {
                        assert!(same(a, b), "{} {k} of {size}: {a:?} {b:?}", chain.name());
                    }
                }
            }
        }
    }
}

/// Registers of another width round other digits, and no more: to 1e-9 of a radian or metre.
#[test]
fn every_level_of_the_processor_gives_the_same_commands() {
    for chain in robots() {
        let fit = elastic(&chain, 5);
        let jobs = mixed(&chain, &fit, 200);
        let of = |arch| {
            let compensator =
                Compensator::bind(&fit, &schema(), CompensatorOptions::default()).expect("bound");
            let mut commands = Vec::new();
            compensator.on(arch).commands(&jobs.list(), &mut commands);
            commands
        };
        let levels = truepose_kinematics::lanes::levels();
        let scalar = of(levels[0]);
        for &arch in &levels[1..] {
            for (k, (a, b)) in scalar.iter().zip(of(arch)).enumerate() {
                assert_eq!(a.status, b.status, "{} {k} {arch:?}", chain.name());
                // Where nothing was reached a search ends at one of many places that are as near.
                if a.status == Status::Ok {
                    let off = a.joints.iter().zip(&*b.joints).map(|(a, b)| (a - b).abs()).fold(0.0, f64::max);
                    assert!(off < 1e-9, "{} {k} {arch:?}: {off:e}", chain.name());
                }
            }
        }
    }
}

#[test]
fn ok_means_that_the_model_is_there() {
    for chain in robots() {
        let fit = elastic(&chain, 9);
        let jobs = mixed(&chain, &fit, 3000);
        let mut predictor = fit.bind(&schema()).expect("a predictor");
        let mut compensator =
            Compensator::bind(&fit, &schema(), CompensatorOptions::default()).expect("bound");
        let mut commands = Vec::new();
        compensator.commands(&jobs.list(), &mut commands);
        let mut ok = 0;
        for (k, command) in commands.iter().enumerate() {
            let (target, conditions) = (&jobs.targets[k], &jobs.conditions[k]);
            for (q, &joint) in command.joints.iter().zip(chain.movable()) {
                let (lower, upper) = chain.joint(joint).limits.unwrap_or((f64::NEG_INFINITY, f64::INFINITY));
                assert!(*q >= lower && *q <= upper, "{}: {q} beyond {lower} … {upper}", chain.name());
            }
            if command.status != Status::Ok {
                assert!(
                    matches!(k % 23, 7 | 13 | 19 | 21) || k % 11 == 3,
                    "{} {k}: {:?}",
                    chain.name(),
                    command.status
                );
                continue;
            }
            ok += 1;
            assert_ne!(k % 23, 13);
            let at = Conditions { joints: command.joints.to_vec(), ..conditions.clone() };
            let pose = predictor.predict(&at, target.target);
            let away = (pose.translation - target.position).norm();
            assert!(away < 1e-9, "{} {k}: {away:e} m", chain.name());
            if let Some(wanted) = target.orientation {
                let turned = rotation_log(&(pose.rotation * wanted.transpose())).norm();
                assert!(turned < 1e-9, "{} {k}: {turned:e} rad", chain.name());
            }
        }
        assert!(ok > 2400, "{}: {ok} of 3000", chain.name());
    }
}

/// Springs whose weights are unknowns are asked posture by posture; the answer is as exact.
#[test]
fn models_without_batch_evaluation_give_commands_as_well() {
    let chain = samples::heavy();
    let free = JointCompliance { own_weight: OwnWeight::Free, ..JointCompliance::default() };
    let fit = crate::fits::of(&chain, vec![Box::new(Geometric::default()), Box::new(free)], 3);
    let jobs = mixed(&chain, &fit, 60);
    let mut compensator = Compensator::bind(&fit, &schema(), CompensatorOptions::default()).expect("bound");
    let mut commands = Vec::new();
    compensator.commands(&jobs.list(), &mut commands);
    assert!(commands.iter().filter(|command| command.status == Status::Ok).count() > 40);
}
