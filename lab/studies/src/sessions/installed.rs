//! Three installations of one arm in one fit: do intervals of coefficients cover, and how large is the error against an oracle?
//!
//! The oracle is told where the bases stand exactly, and fits the same rows as those of one installation.

use super::robots::{Robot, error, identified, noise};
use crate::parts::Scope;
use crate::prelude::*;
use truepose_errormodel::{DatasetBuilder, Measurement, SessionRules};
use truepose_identify::{place, unify};

/// Poses of each session.
const POSES: [usize; 3] = [50, 50, 50];

const KINDS: [&str; 4] = [
    "base new",
    "base new, tool mounted anew by 2 deg, 3 mm",
    "the same by 25 deg, 60 mm",
    "the same by 180 deg, 60 mm",
];

struct Installed {
    kind: usize,
    /// Coefficients that were inside of their intervals, and how many.
    inside: usize,
    all: usize,
    /// Error at new poses of the last session, and the oracle's, m; none where it was refused.
    errors: Option<(f64, f64)>,
    refused: Option<String>,
}

/// The table.
pub fn table(scope: &Scope) -> Outcome<String> {
    let all = scope.each(|number| one(number, scope.locked))?;
    let mut text = format!(
        "{:44} robots  refused  coverage  coefficients  error um  oracle um  pure  with noise, RMS  90 % of robots\n",
        "three sessions of 50 poses, 3 targets"
    );
    for (kind, word) in KINDS.iter().enumerate() {
        let of: Vec<&Installed> = all.iter().filter(|one| one.kind == kind).collect();
        let (inside, count) = of.iter().fold((0, 0), |sum, one| (sum.0 + one.inside, sum.1 + one.all));
        let errors: Vec<(f64, f64)> = of.iter().filter_map(|one| one.errors).collect();
        let with = |(a, b): &(f64, f64)| (a.hypot(noise()), b.hypot(noise()));
        let (a, b) = (rms(errors.iter().map(|e| e.0)), rms(errors.iter().map(|e| e.1)));
        let noisy = rms(errors.iter().map(|e| with(e).0)) / rms(errors.iter().map(|e| with(e).1));
        let most = nearest_quantile(errors.iter().map(|e| with(e).0 / with(e).1), 0.9);
        let (robots, refused) = (of.len(), of.iter().filter(|one| one.refused.is_some()).count());
        let (share, um, oracle) = (100.0 * inside as f64 / count.max(1) as f64, 1e6 * a, 1e6 * b);
        write!(text, "{word:44} {robots:6} {refused:8} {share:8.2}% {count:13} {um:9.1} {oracle:10.1}")?;
        writeln!(text, " {:5.3} {noisy:16.3} {most:14.3}", a / b)?;
    }
    let mut refused: Vec<&str> = all.iter().filter_map(|one| one.refused.as_deref()).collect();
    refused.sort_unstable();
    refused.dedup();
    refused.iter().take(5).try_for_each(|why| writeln!(text, "  refused: {why}"))?;
    Ok(text)
}

/// The robot in a session: its base, and the tool as it is mounted there.
fn there(chain: &Chain, seed: u64, session: usize, kind: usize) -> Outcome<Chain> {
    let number = (seed as f64) * 0.37 + session as f64;
    let at = [4.0 * number.sin(), 4.0 * (1.7 * number).cos(), 0.3 * (2.3 * number).sin()];
    let base = Pose::from_xyz_rpy(at, [0.0, 0.0, 3.0 * (3.1 * number).sin()]);
    let chain = chain.clone().with_base(known(base))?;
    let (angle, length) = [(0.0, 0.0), (2.0, 3e-3), (25.0, 60e-3), (180.0, 60e-3)][kind];
    if session == 0 || kind == 0 {
        return Ok(chain);
    }
    let turn = Vector3::new((5.0 * number).sin(), (7.0 * number).sin(), (11.0 * number).sin()).normalize();
    let turn = turn * f64::to_radians(angle);
    let by = Vector3::new((13.0 * number).sin(), (17.0 * number).sin(), (19.0 * number).sin()).normalize()
        * length;
    let moved = Pose::new(truepose_kinematics::rotation_vector(&turn), by);
    let pose = chain.tool().pose * moved;
    Ok(chain.with_tool(known(pose))?)
}

/// Rows of several sessions in one table, each in its own frame.
fn table_of(chain: &Chain, parts: &[Observation]) -> Outcome<Dataset> {
    let mut builder = DatasetBuilder::new(chain);
    let (mut sessions, mut first) = (Vec::new(), 0);
    for (session, part) in parts.iter().enumerate() {
        let data = &part.data;
        for row in 0..data.len() {
            let joints = data.conditions(row).joints;
            let visit = (first + data.visit[row]) as u64;
            builder.push(
                Measurement::at(joints).position(data.position[row]).target(data.target[row]).visit(visit),
            )?;
            sessions.push(session as f64);
        }
        first += data.visit.iter().max().map_or(0, |last| last + 1);
    }
    let mut data = builder.finish();
    data.set_sessions(Some(sessions));
    Ok(data)
}

fn one(number: u64, locked: bool) -> Outcome<Installed> {
    let robot = Robot::of(number, locked, 3)?;
    let kind = (number / 3) as usize % KINDS.len();
    let blank = robot.chain.clone().with_base(Placed { pose: Pose::IDENTITY, known: false })?;
    let places = (0..3).map(|k| there(&robot.chain, robot.seed, k, kind)).collect::<Result<Vec<_>, _>>()?;
    let plants =
        places.iter().map(|chain| robot.plant(chain, Flaws::default())).collect::<Result<Vec<Plant>, _>>()?;
    let each = plants.iter().zip(POSES).zip(1..);
    let parts = each
        .map(|((plant, poses), campaign)| robot.observed(plant, poses, campaign))
        .collect::<Result<Vec<_>, _>>()?;
    let data = table_of(&blank, &parts)?;
    let names: Vec<String> = ["A", "B", "C"].map(String::from).to_vec();
    let rules = SessionRules { tool: kind > 0, ..SessionRules::default() };
    let mut record = Installed { kind, inside: 0, all: 0, errors: None, refused: None };
    let unified = match unify(&blank, &data, &names, rules) {
        Ok(unified) => unified,
        Err(why) => return Ok(Installed { refused: Some(why.to_string()), ..record }),
    };
    let placed = place(&unified.chain, &unified.data)?.chain;
    let effects: Vec<_> = elastic_errors().into_iter().chain(unified.effects.iter().cloned()).collect();
    let found = fitted(&placed, &effects, &unified.data, &FitOptions::default())?;
    // What would be seen without noise, in the same frame.
    let mut quiet = unified.data.clone();
    let truths = parts.iter().flat_map(|part| &part.true_positions);
    for (row, truth) in truths.enumerate() {
        let frame = &unified.installed[quiet.session(row)].frame;
        quiet.position[row] = frame.apply(truth).into();
    }
    let truths = coefficients_of_plant(found.fitted.model(), &found, &quiet, found.noise)?;
    let half = found.half_widths();
    for group in &found.reduction.groups {
        let k = group.column;
        record.all += 1;
        record.inside += usize::from((found.fitted.coefficients()[k] - truths[k]).abs() <= half[k]);
    }
    let fitted = found.fitted.clone().with_sessions(unified.installed.clone());
    let fresh = robot.observed(&plants[2], 100, 9)?;
    let oracle = oracle(&robot, &places, &parts, kind)?;
    let mut of_session = fresh.clone();
    for target in of_session.data.target.iter_mut().flatten() {
        *target = fitted.target_in_session(*target, 2);
    }
    record.errors = Some((error(&fitted.in_session(2)?, &of_session)?, error(&oracle, &fresh)?));
    Ok(record)
}

/// All rows carried to the last session by the true bases. The rows of another tool are left out: what the last session alone has.
fn oracle(robot: &Robot, places: &[Chain], parts: &[Observation], kind: usize) -> Outcome<FittedModel> {
    let mut carried = Vec::new();
    for (place, part) in places.iter().zip(parts) {
        let mut part = part.clone();
        part.data.carry(&(places[2].base().pose * place.base().pose.inverse()));
        carried.push(part);
    }
    if kind == 0 {
        let mut data = table_of(&robot.chain, &carried)?;
        data.set_sessions(None);
        return Ok(identified(&places[2], &data)?.fitted);
    }
    // A tool elsewhere is other targets: those of each session are found beside the arm.
    let mut chain = places[2].clone();
    let mut targets = chain.targets().to_vec();
    for (k, place) in places.iter().enumerate().take(2) {
        for target in robot.chain.targets() {
            let on_flange = place.tool().pose.apply(&target.position);
            let position = places[2].tool().pose.inverse().apply(&on_flange);
            let name = format!("{} {k}", target.name);
            targets.push(Target { name, position, ..target.clone() });
        }
    }
    chain = chain.with_targets(targets)?;
    let count = robot.chain.targets().len();
    for (k, part) in carried.iter_mut().enumerate().take(2) {
        for target in part.data.target.iter_mut().flatten() {
            target.0 += count * (k + 1);
        }
    }
    let mut data = table_of(&chain, &carried)?;
    data.set_sessions(None);
    Ok(identified(&chain, &data)?.fitted)
}
