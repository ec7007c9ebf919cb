//! Of several causes at once: whether the largest are named, and where the true robot ends when it is commanded by the model.

use super::plant::Made;
use super::record::Record;
use super::reported::Reported;
use crate::prelude::*;

/// How many of the largest causes have to be named.
const LARGEST: usize = 2;

/// Fills the record's columns.
pub fn judge(made: &Made, reported: &Reported, fitted: &FittedModel, record: &mut Record) -> Outcome {
    let causes: Vec<_> = reported.effects.iter().filter(|effect| effect.is_cause()).collect();
    let named = |piece: &super::pieces::Piece| {
        causes.iter().any(|effect| piece.is_named(&effect.name.family, effect.name.joint.as_deref()))
    };
    let words: Vec<String> = made
        .pieces
        .iter()
        .map(|(piece, size)| {
            let joint = piece.joint.as_ref().map_or("", |(_, name)| name.as_str());
            let found = if named(piece) { "named" } else { "not named" };
            format!("{:?} {joint} {size:.2} {found}", piece.share)
        })
        .collect();
    record.set("found", made.pieces.iter().take(LARGEST).all(|(piece, _)| named(piece)));
    record.set("words", format!("{} | {}", words.join("; "), record.text("words")));
    let (before, after, refused) = executed(made, fitted)?;
    record.set("executed_before", before.hypot(made.floor) / made.floor);
    record.set("executed", after.hypot(made.floor) / made.floor);
    record.set("executed_refused", refused);
    Ok(())
}

/// 3-D RMS distance of the true robot, without noise, from where the nominal one would be at fresh configurations, m: commanded so, and
/// by the model; and how many commands the model refuses.
fn executed(made: &Made, fitted: &FittedModel) -> Outcome<(f64, f64, usize)> {
    let chain = fitted.chain();
    let data = made.truth.derived_for(fitted.model())?;
    let mut compensator = Compensator::bind(fitted, &data.schema, CompensatorOptions::default())?;
    let mut fresh = made.fresh.clone();
    let (mut rows, mut wanted) = (Vec::new(), Vec::new());
    for row in 0..data.len() {
        let visit = data.visit[row];
        if rows.last().is_some_and(|&last: &usize| data.visit[last] == visit) {
            continue;
        }
        let conditions = data.conditions(row);
        let (position, goal) = nominal_goal(chain, &conditions, data.target[row]);
        let command = compensator.command(&goal, &conditions, Some(&conditions.joints));
        if command.status == Status::Ok {
            fresh.visits[visit].joints = command.joints.to_vec();
            rows.push(row);
            wanted.push(position);
        }
    }
    let refused = fresh.visits.len() - rows.len();
    let seen = made.quiet.observe(&fresh, made.fresh_seed)?;
    let of = |at: &dyn Fn(usize) -> Vector3<f64>| {
        let square = |(&row, wanted): (&usize, &Vector3<f64>)| (at(row) - wanted).norm_squared();
        (rows.iter().zip(&wanted).map(square).sum::<f64>() / rows.len().max(1) as f64).sqrt()
    };
    let before = of(&|row| made.truth.measured_position(row));
    Ok((before, of(&|row| seen.true_positions[row]), refused))
}
