//! An arm in another installation, from few poses of one target: error at new poses against an identification with all data there.

use super::robots::{Robot, error, identified, noise};
use crate::parts::Scope;
use crate::prelude::*;
use truepose_upkeep::{Installation, TransferOptions, transfer, transfer_poses};

/// Poses, and how they are chosen.
const WAYS: [(usize, bool); 8] =
    [(6, false), (6, true), (8, false), (8, true), (12, false), (12, true), (20, false), (20, true)];

struct Carried {
    /// Error of each way, frozen and updated, m.
    errors: Vec<[f64; 2]>,
    /// Of a frozen arm in standard deviations that the band states.
    stated: Vec<f64>,
    /// Of an identification with 150 poses there.
    all: f64,
    /// Of the arm where it was identified.
    here: f64,
}

/// The table.
pub fn table(scope: &Scope) -> Outcome<String> {
    let all = scope.each(|number| one(number, scope.locked))?;
    let whole = rms(all.iter().map(|one| one.all));
    let noisy = |error: f64| error.hypot(noise());
    let mut text = format!(
        "one target, base and target new, arm of 150 poses; identified there with 150 poses: {:.1} um ({:.1} with noise), the arm where it was identified {:.1} um\n{:28} error um  x all  with noise: RMS  median   90 %   in stated SD\n",
        1e6 * whole,
        1e6 * rms(all.iter().map(|one| noisy(one.all))),
        1e6 * rms(all.iter().map(|one| one.here)),
        "poses"
    );
    for (k, (poses, planned)) in WAYS.iter().enumerate() {
        for (which, word) in ["frozen", "updated"].iter().enumerate() {
            let errors = || all.iter().map(|one| one.errors[k][which]);
            let ratios = || all.iter().map(|one| noisy(one.errors[k][which]) / noisy(one.all));
            let together = rms(errors().map(noisy)) / rms(all.iter().map(|one| noisy(one.all)));
            let stated = if which == 0 { rms(all.iter().map(|one| one.stated[k])) } else { f64::NAN };
            let words = format!("{poses} {}, {word}", if *planned { "planned" } else { "random" });
            let [middle, most] = [0.5, 0.9].map(|part| nearest_quantile(ratios(), part));
            let (um, times) = (1e6 * rms(errors()), rms(errors()) / whole);
            write!(text, "{words:28} {um:8.1} {times:6.2} {together:16.3} {middle:7.3} {most:6.3}")?;
            writeln!(text, " {stated:14.2}")?;
        }
    }
    Ok(text)
}

/// Elsewhere in the shop, with the reflector mounted anew.
fn elsewhere(chain: &Chain) -> Outcome<Chain> {
    let base = Pose::from_xyz_rpy([2.1, -3.4, 0.2], [0.0, 0.0, 1.9]);
    let offset = Vector3::new(0.03, -0.05, 0.08);
    let targets = chain.targets().iter().map(|t| Target { position: t.position + offset, ..t.clone() });
    let targets = targets.collect();
    Ok(chain.clone().with_base(known(base))?.with_targets(targets)?)
}

fn one(number: u64, locked: bool) -> Outcome<Carried> {
    let robot = Robot::of(number, locked, 1)?;
    let there = elsewhere(&robot.chain)?;
    let (before, after) =
        (robot.plant(&robot.chain, Flaws::default())?, robot.plant(&there, Flaws::default())?);
    let arm = identified(&robot.chain, &robot.observed(&before, 150, 1)?.data)?.fitted;
    let fresh = robot.observed(&after, 200, 2)?;
    let whole = identified(&there, &robot.observed(&after, 150, 3)?.data)?.fitted;
    let mut record = Carried {
        errors: Vec::new(),
        stated: Vec::new(),
        all: error(&whole, &fresh)?,
        here: error(&arm, &robot.observed(&before, 200, 4)?)?,
    };
    let installation = Installation { base: true, tool: false, targets: true };
    for (k, (poses, planned)) in WAYS.iter().enumerate() {
        let campaign = 10 + k as u64;
        let data = match planned {
            false => robot.observed(&after, *poses, campaign)?.data,
            true => {
                let made = transfer_poses(&arm, *poses, installation)?;
                let visits = made.poses.iter();
                let joints = visits.map(|at| at.joints.clone()).collect();
                after.measure(&Campaign::of(joints), robot.seed + (campaign << 32))?
            }
        };
        let mut errors = [f64::NAN; 2];
        for (which, update) in [false, true].into_iter().enumerate() {
            let made = transfer(&arm, &data, TransferOptions { installation, update })?;
            errors[which] = error(&made.fitted, &fresh)?;
            if let (false, Some((_, band))) = (update, made.bands) {
                record.stated.push(errors[0] / band.rms);
            }
        }
        record.errors.push(errors);
    }
    Ok(record)
}
