//! Declared payloads that are wrong at one level.

use crate::data::payload;
use crate::hypotheses::candidate::{Candidate, Change};
use crate::hypotheses::family::Family;
use crate::hypotheses::place::Place;
use crate::hypotheses::setting::Setting;

/// More levels than this are no levels but a continuous quantity.
const MOST_LEVELS: usize = 12;

pub(crate) fn add(setting: &Setting<'_>, all: &mut Vec<Candidate>) {
    let levels = payload::levels(setting.data);
    if levels.len() > MOST_LEVELS {
        return;
    }
    for level in levels {
        all.push(Candidate {
            family: Family::Payload,
            // Units of the file leave a rounding error in the last digits.
            place: Place { level: Some((level * 1e6).round() * 1e-6), ..Place::default() },
            change: Change::CorrectLoad { level, mass: level, deviation: 0.0 },
            width: None,
        });
    }
}
