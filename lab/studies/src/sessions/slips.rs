//! A joint that is not where it was: is it found at the first look, with twelve planned poses, and named?

use super::robots::{Robot, identified, noise};
use crate::parts::Scope;
use crate::prelude::*;
use truepose_simulate::Task;
use truepose_upkeep::{MonitorOptions, check_poses, monitor};

const CHECKS: usize = 12;
/// Sizes: RMS by which the joint moves the measured points, in the 3-D RMS of the noise of a row.
const SIZES: [f64; 4] = [0.5, 1.0, 2.0, 3.0];

/// What a look says of a slip.
struct Look {
    found: bool,
    /// Whether the joint is named first, or among those that the poses do not tell apart, and how many these are.
    first: bool,
    among: bool,
    tied: usize,
}

struct Slipped {
    word: &'static str,
    joint: usize,
    /// Of each size.
    seen: Vec<Look>,
    /// Alarm before the slip.
    before: bool,
    /// What was named in its place at the largest size.
    instead: Option<String>,
}

/// The table.
pub fn table(scope: &Scope) -> Outcome<String> {
    let all = scope.each(|number| one(number, scope.locked))?;
    let mut text = format!(
        "{:24} robots   found  named first  among tied  tied, mean   ({CHECKS} planned poses, 3 targets, 100 poses of the fit)\n",
        "moves points by"
    );
    let count = |part: &dyn Fn(&Slipped) -> bool| all.iter().filter(|s| part(s)).count();
    let percent = |part: usize| 100.0 * part as f64 / all.len().max(1) as f64;
    for (k, size) in SIZES.iter().enumerate() {
        let of = |part: &dyn Fn(&Look) -> bool| percent(count(&|slipped| part(&slipped.seen[k])));
        let tied: usize = all.iter().map(|slipped| slipped.seen[k].tied).sum();
        let (found, first) = (of(&|s| s.found), of(&|s| s.found && s.first));
        let (among, mean) = (of(&|s| s.found && s.among), tied as f64 / all.len().max(1) as f64);
        let (words, robots) = (format!("{size} x the noise"), all.len());
        writeln!(text, "{words:24} {robots:6} {found:6.1}% {first:11.1}% {among:10.1}% {mean:11.2}")?;
    }
    let before = percent(count(&|s| s.before));
    writeln!(text, "nothing moved            {:6} {before:6.1}%", all.len())?;
    for slipped in &all {
        if let Some(instead) = &slipped.instead {
            let (joint, word) = (slipped.joint + 1, slipped.word);
            writeln!(text, "  at {} x not named first: joint {joint} of {word}: {instead}", SIZES[3])?;
        }
    }
    Ok(text)
}

fn one(number: u64, locked: bool) -> Outcome<Slipped> {
    let robot = Robot::of(number, locked, 3)?;
    let chain = &robot.chain;
    let joint = (number / 3) as usize % chain.movable().len();
    let name = name_of(chain, chain.movable()[joint]);
    let plant = robot.plant(chain, Flaws::default())?;
    let arm = identified(chain, &robot.observed(&plant, 100, 1)?.data)?.fitted;
    let planned = check_poses(&arm, CHECKS, MonitorOptions::default().alpha)?;
    let mut poses = Campaign::of(Vec::new());
    poses.visits = planned
        .poses
        .iter()
        .map(|at| Visit { joints: at.joints.clone(), load: at.load, approach: None, task: Task::Positions })
        .collect();
    let seed = robot.seed + (9 << 32);
    let look = |mrad: f64| -> Outcome<_> {
        let shift = flaws::Shift { at: name.clone(), when_s: -1e9, size_mm: 0.0, size_mrad: mrad };
        let shift = if mrad == 0.0 { Vec::new() } else { vec![shift] };
        let plant = robot.plant(chain, Flaws { shift, ..Flaws::default() })?;
        Ok(plant.observe(&poses, seed)?)
    };
    let (still, unit) = (look(0.0)?, look(1.0)?);
    let moved = rms(still.true_positions.iter().zip(&unit.true_positions).map(|(a, b)| (a - b).norm()));
    let before = monitor(&arm, &still.data, MonitorOptions::default())?.changed;
    let mut slipped = Slipped { word: robot.word, joint, seen: Vec::new(), before, instead: None };
    let wanted = format!("zero of {name} ");
    for size in SIZES {
        let sign = if number.is_multiple_of(2) { 1.0 } else { -1.0 };
        let today = look(sign * size * noise() / moved)?.data;
        let seen = monitor(&arm, &today, MonitorOptions::default())?;
        let named = |what: &str| what.starts_with(&wanted);
        let tied = &seen.changes[..seen.tied];
        let first = tied.first().is_some_and(|change| named(&change.what));
        let among = tied.iter().any(|change| named(&change.what));
        slipped.seen.push(Look { found: seen.changed, first, among, tied: tied.len() });
        if size == SIZES[3] && !first {
            let words: Vec<&str> = tied.iter().map(|change| change.what.as_str()).collect();
            slipped.instead = Some(words.join(", "));
        }
    }
    Ok(slipped)
}
