//! Unchanged robots, looked at fifty times: how many ever raise an alarm at the stated 1 %?

use super::robots::{Robot, identified};
use crate::parts::Scope;
use crate::prelude::*;
use truepose_upkeep::{MonitorOptions, monitor};

/// Looks at a robot, and check poses of a look.
const LOOKS: usize = 50;
const CHECKS: usize = 12;

/// What kinds of unchanged robots there are.
const KINDS: [&str; 4] = [
    "100 poses, 3 targets; check poses the same each time",
    "100 poses, 3 targets; other check poses each time",
    "40 poses, 1 target; check poses the same each time",
    "100 poses, 3 targets, a gear error that the fit lacks; the same",
];

struct Watched {
    kind: usize,
    /// The first look that raised an alarm.
    alarm: Option<usize>,
    /// Whether the first look has p below one half, and below 5 %.
    low: [bool; 2],
}

/// The table.
pub fn table(scope: &Scope) -> Outcome<String> {
    let all = scope.each(|number| one(number, scope.locked))?;
    let layout = "unchanged robots, 50 looks each -66|robots 6|ever 5|first look 11|p0<0.5 7|p0<0.05 8";
    let mut table = Table::columns(layout);
    for (kind, word) in KINDS.iter().enumerate() {
        let of: Vec<&Watched> = all.iter().filter(|watched| watched.kind == kind).collect();
        let count = |is: &dyn Fn(&Watched) -> bool| of.iter().filter(|w| is(w)).count();
        let share = |is: &dyn Fn(&Watched) -> bool| fixed(count(is) as f64 / of.len().max(1) as f64, 3);
        let (ever, first) = (count(&|w| w.alarm.is_some()), count(&|w| w.alarm == Some(0)));
        table.row(&[word, &of.len(), &ever, &first, &share(&|w| w.low[0]), &share(&|w| w.low[1])]);
    }
    Ok(table.text())
}

fn one(number: u64, locked: bool) -> Outcome<Watched> {
    let kind = (number / 3) as usize % KINDS.len();
    let robot = Robot::of(number, locked, if kind == 2 { 1 } else { 3 })?;
    let plant = robot.plant(&robot.chain, if kind == 3 { with_gear(&robot) } else { Flaws::default() })?;
    let poses = if kind == 2 { 40 } else { 100 };
    let arm = identified(&robot.chain, &robot.observed(&plant, poses, 1)?.data)?.fitted;
    looks(&robot, &plant, &arm, kind)
}

/// A gear of the third joint that errs by 0.1 mrad once a turn.
fn with_gear(robot: &Robot) -> Flaws {
    let gear = gear(name_of(&robot.chain, robot.chain.movable()[2]), 0.1, None);
    Flaws { transmission: vec![gear], ..Flaws::default() }
}

fn looks(robot: &Robot, plant: &Plant, arm: &FittedModel, kind: usize) -> Outcome<Watched> {
    let mut watched = Watched { kind, alarm: None, low: [false; 2] };
    for look in 0..LOOKS {
        let seed = robot.seed + ((100 + look as u64) << 32);
        let poses =
            Campaign::random(&robot.chain, CHECKS, if kind == 1 { seed } else { robot.seed + (7 << 32) })?;
        let today = plant.observe(&poses, seed)?.data;
        let seen = monitor(arm, &today, MonitorOptions { looks: look, ..MonitorOptions::default() })?;
        if look == 0 {
            watched.low = [seen.p_overall < 0.5, seen.p_overall < 0.05];
        }
        if seen.changed {
            watched.alarm = Some(look);
            break;
        }
    }
    Ok(watched)
}
