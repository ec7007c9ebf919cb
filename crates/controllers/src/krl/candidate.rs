//! Literals that may be points.

use super::aggregate::Aggregate;
use crate::Dialect;
use crate::number::{Form, Slot};
use truepose_kinematics::Pose;

/// A literal that may be a point.
#[derive(Debug, Clone)]
pub(super) struct Candidate {
    pub(super) name: String,
    pub(super) line: usize,
    pub(super) kind: Literal,
    pub(super) external: Vec<(String, f64)>,
    /// The motion that contains it.
    pub(super) inline: Option<usize>,
    pub(super) slots: Vec<Slot>,
    pub(super) turns: Vec<Slot>,
    /// A component that is missing or no literal.
    pub(super) incomplete: Option<String>,
    /// Whether it is a place on the way of a circular motion, without an orientation of its own.
    pub(super) auxiliary: bool,
}

#[derive(Debug, Clone)]
pub(super) enum Literal {
    /// Numbers X Y Z A B C, S and T; whether the type is FRAME.
    Pose {
        numbers: Vec<f64>,
        status: Option<i64>,
        turn: Option<i64>,
        frame: bool,
    },
    Axes(Vec<f64>),
}

pub(super) fn pose(aggregate: &Aggregate<'_>) -> Option<Pose> {
    let numbers: Option<Vec<f64>> =
        ["X", "Y", "Z", "A", "B", "C"].iter().map(|name| aggregate.value(name)).collect();
    Dialect::Krl.pose(&numbers?)
}

/// The point of an aggregate with a point's components.
pub(super) fn candidate(
    text: &[u8],
    name: &str,
    aggregate: &Aggregate<'_>,
    frame: bool,
    typed: bool,
) -> Option<Candidate> {
    let all = |prefix: &str| ["1", "2", "3", "4", "5", "6"].map(|k| format!("{prefix}{k}"));
    let (axes, externals) = (all("A"), all("E"));
    let joint = aggregate.entries.iter().any(|entry| axes.contains(&entry.name));
    let place = ["X", "Y", "Z"].iter().any(|name| aggregate.has(name));
    let known = |entry: &str| {
        axes.iter().chain(&externals).any(|a| a == entry)
            || ["X", "Y", "Z", "A", "B", "C", "S", "T"].contains(&entry)
    };
    if !(joint || place || typed) || !(typed || aggregate.entries.iter().all(|entry| known(&entry.name))) {
        return None;
    }
    let external: Vec<(String, f64)> = externals
        .iter()
        .filter_map(|name| {
            aggregate.entry(name).map(|e| (name, e.value.as_ref().map_or(f64::NAN, |v| v.value)))
        })
        .map(|(name, value)| (name.clone(), value))
        .collect();
    let names: Vec<&str> =
        if joint { axes.iter().map(String::as_str).collect() } else { vec!["X", "Y", "Z", "A", "B", "C"] };
    let least: [usize; 6] = if joint { [5; 6] } else { [3, 3, 3, 4, 4, 4] };
    let slots = aggregate.slots(text, &names, &least);
    let values: Vec<f64> = names.iter().map(|name| aggregate.value(name).unwrap_or(f64::NAN)).collect();
    let whole = |name: &str| aggregate.value(name).map(|value| value as i64);
    let mut incomplete = slots.is_none().then(|| {
        let missing: Vec<&str> =
            names.iter().zip(&values).filter(|(_, v)| v.is_nan()).map(|(n, _)| *n).collect();
        format!("{} absent or computed", missing.join(", "))
    });
    let odd = |name: &str| aggregate.has(name) && aggregate.value(name).is_none_or(|v| v.fract() != 0.0);
    if let Some(name) = ["S", "T"].iter().find(|name| !joint && odd(name)) {
        incomplete = Some(format!("{name} is computed"));
    }
    let turn = aggregate.entry("T").and_then(|entry| entry.value.as_ref()).filter(|_| !joint);
    let turns = turn.map(|literal| Slot {
        range: literal.range.clone(),
        form: if literal.bits { Form::Bits } else { Form::Whole },
    });
    let kind = if joint {
        Literal::Axes(values)
    } else {
        Literal::Pose { numbers: values, status: whole("S"), turn: whole("T"), frame }
    };
    Some(Candidate {
        name: name.into(),
        line: aggregate.line,
        kind,
        external,
        inline: None,
        slots: slots.unwrap_or_default(),
        turns: turns.into_iter().collect(),
        incomplete,
        auxiliary: false,
    })
}

impl Candidate {
    /// The first point of a circular motion: without angles it is a place on the way, whose orientation is that of the destination.
    pub(super) fn on_the_way(self, text: &[u8], aggregate: &Aggregate<'_>) -> Candidate {
        let angles = ["A", "B", "C"].iter().any(|name| aggregate.has(name));
        match aggregate.slots(text, &["X", "Y", "Z"], &[3; 3]).filter(|_| !angles) {
            Some(slots) => Candidate { slots, incomplete: None, auxiliary: true, ..self },
            None => self,
        }
    }

    /// With the orientation of a destination.
    pub(super) fn oriented(&self, destination: Option<&Candidate>) -> Candidate {
        let mut candidate = self.clone();
        match (&mut candidate.kind, destination.map(|destination| &destination.kind)) {
            (Literal::Pose { numbers, .. }, Some(Literal::Pose { numbers: there, .. }))
                if there.iter().all(|number| number.is_finite()) =>
            {
                numbers[3..].copy_from_slice(&there[3..]);
            }
            _ => {
                let words = "A, B, C absent, and its destination has none in the files given";
                candidate.incomplete = Some(words.into());
            }
        }
        candidate
    }
}
