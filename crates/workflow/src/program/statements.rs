//! What a program states besides its points.

use super::rows::Part;
use super::taught;
use truepose_controllers::{Carried, CorrectOptions};
use truepose_errormodel::{FittedModel, Interval};
use truepose_report::count;

/// A line for each.
pub(super) fn statements(fitted: &FittedModel, parts: &[Part<'_>], options: &CorrectOptions) -> Vec<String> {
    let mut all: Vec<String> = taught::note(&taught::open(parts, options)).into_iter().collect();
    if let Some(known) = loads(fitted).filter(|_| options.program_loads) {
        all.extend(carried(known, parts));
    }
    all
}

/// The loads of the data, kg, where there are several.
pub(super) fn loads(fitted: &FittedModel) -> Option<&Interval> {
    fitted.domain.payload.as_ref().filter(|known| known.upper > known.lower)
}

/// Which loads were taken, and where none was.
fn carried(known: &Interval, parts: &[Part<'_>]) -> Vec<String> {
    let mut taken: Vec<(String, usize)> = Vec::new();
    let mut open = taken.clone();
    for part in parts {
        for (point, _) in part.program.points().iter().zip(part.own).filter(|(_, own)| **own) {
            let (list, words) = match &point.carried {
                Carried::Mass { name, mass, .. } => (&mut taken, format!("{name} of {mass} kg")),
                Carried::Open(words) => (&mut open, words.clone()),
            };
            match list.iter_mut().find(|(other, _)| *other == words) {
                Some((_, count)) => *count += 1,
                None => list.push((words, 1)),
            }
        }
    }
    let listed = |list: &[(String, usize)]| {
        let one = |(words, number): &(String, usize)| format!("{words} ({})", count(*number, "point"));
        let mut words = list.iter().take(5).map(one).collect::<Vec<_>>().join("; ");
        if list.len() > 5 {
            words.push_str("; …");
        }
        words
    };
    let mut all = Vec::new();
    if !taken.is_empty() {
        all.push(format!(
            "loads are those that the program states (--payload for another): {}",
            listed(&taken)
        ));
    }
    if !open.is_empty() {
        all.push(format!(
            "the fit has loads from {} kg to {} kg, and points are compensated without a load (--payload, --com): {}",
            known.lower,
            known.upper,
            listed(&open)
        ));
    }
    all
}
