//! A fleet of ten as prior of the eleventh: how many poses are its sisters worth?

use super::robots::{Robot, error, identified};
use crate::parts::Scope;
use crate::prelude::*;
use truepose_upkeep::{Fleet, Installation, TransferOptions, fleet, transfer};

const SISTERS: u64 = 10;
/// Errors of each robot's own, in parts of those of the type (0.4 mm, 0.4 mrad a component).
const OWN: [f64; 4] = [0.0125, 0.025, 0.05, 0.1];
const POSES: [usize; 5] = [25, 40, 60, 90, 150];
/// Next robots of each fleet.
const NEXT: u64 = 4;

struct Type {
    /// Errors with the fleet from 25 poses, m.
    with: Vec<f64>,
    /// With the true mean and scatter of the type.
    informed: Vec<f64>,
    /// Alone from so many.
    alone: Vec<[f64; POSES.len()]>,
}

/// The table.
pub fn table(scope: &Scope) -> Outcome<String> {
    let all = scope.each(|number| one(number, scope.locked))?;
    let mut text =
        String::from("RMS error at new poses, um; one target, ten sisters of 100 poses each\nown errors   ");
    POSES.iter().try_for_each(|poses| write!(text, "{:>9}", format!("{poses} alone")))?;
    writeln!(text, "  25 with fleet  25 with the truth of the type  worth, poses")?;
    for (k, own) in OWN.iter().enumerate() {
        let of: Vec<&Type> = all.iter().filter_map(|fleets| fleets.get(k)).collect();
        let alone_of = |n: usize| rms(of.iter().flat_map(|one| one.alone.iter().map(move |a| a[n])));
        let alone: Vec<f64> = (0..POSES.len()).map(alone_of).collect();
        let with = rms(of.iter().flat_map(|one| one.with.iter().copied()));
        let truth = 1e6 * rms(of.iter().flat_map(|one| one.informed.iter().copied()));
        write!(text, "{:13}", format!("{} um", 400.0 * own))?;
        alone.iter().try_for_each(|error| write!(text, "{:9.1}", 1e6 * error))?;
        writeln!(text, "{:15.1}{truth:31.1}{:>14}", 1e6 * with, worth(&alone, with))?;
    }
    Ok(text)
}

/// Poses alone that reach an error; between those of the table in proportion of logarithms.
fn worth(alone: &[f64], error: f64) -> String {
    for k in 1..alone.len() {
        if error >= alone[k] {
            let part = ((alone[k - 1] / error).ln() / (alone[k - 1] / alone[k]).ln()).max(0.0);
            let (from, to) = (POSES[k - 1] as f64, POSES[k] as f64);
            return format!("{:.0}", from * (to / from).powf(part));
        }
    }
    format!("> {}", POSES[POSES.len() - 1])
}

/// Errors of one design and of each robot its own.
fn sister(robot: &Robot, chain: &Chain, own: f64, number: u64) -> Outcome<Plant> {
    let design = robot.plant(chain, Flaws::default())?;
    let other = Robot { seed: robot.seed + ((5000 + number) << 24), ..robot.clone() };
    let other = other.plant(chain, Flaws::default())?;
    let mut truth = design.truth().clone();
    for (frame, of_own) in truth.frames.iter_mut().zip(&other.truth().frames) {
        frame.iter_mut().zip(of_own).for_each(|(all, one)| *all += own * one);
    }
    truth.targets.clone_from(&other.truth().targets);
    Ok(design.with_truth(truth)?)
}

fn one(number: u64, locked: bool) -> Outcome<Vec<Type>> {
    let robot = Robot::of(number, locked, 1)?;
    let chain = &robot.chain;
    let measured = |own: f64, which: u64, poses: usize, campaign: u64| -> Outcome<Observation> {
        robot.observed(&sister(&robot, chain, own, which)?, poses, 1000 * campaign + which)
    };
    let mut kinds = Vec::new();
    for own in OWN {
        let fleet_of = |robots: u64, poses: usize, first: u64| -> Outcome<Fleet> {
            let arms = (0..robots)
                .map(|which| Ok(identified(chain, &measured(own, first + which, poses, 1)?.data)?.fitted))
                .collect::<Outcome<Vec<_>>>()?;
            Ok(fleet(&arms)?)
        };
        let prior = fleet_of(SISTERS, 100, 0)?;
        // Sixty sisters of 400 poses: as good as the truth.
        let truth = fleet_of(60, 400, 1000)?;
        let mut of = Type { with: Vec::new(), informed: Vec::new(), alone: Vec::new() };
        for which in 100..100 + NEXT {
            let fresh = measured(own, which, 100, 2)?;
            let few = measured(own, which, POSES[0], 3)?.data;
            let installation = Installation::SAME;
            let with = |prior: &Fleet| -> Outcome<f64> {
                let made = transfer(&prior.prior, &few, TransferOptions { installation, update: true })?;
                error(&made.fitted, &fresh)
            };
            of.with.push(with(&prior)?);
            of.informed.push(with(&truth)?);
            let mut alone = [f64::NAN; POSES.len()];
            for (k, poses) in POSES.into_iter().enumerate() {
                alone[k] = error(&identified(chain, &measured(own, which, poses, 3)?.data)?.fitted, &fresh)?;
            }
            of.alone.push(alone);
        }
        kinds.push(of);
    }
    Ok(kinds)
}
