//! Bases and stations of a job, the external axes: `BC00001=1500.000` of a base (a track), `EC00001=0,90.0` of a station.
//!
//! They are at these values where a motion names them beside its point: `MOVL C00001 BC00001 V=93.0`.

use crate::lines::Line;
use crate::number::number_at;
use crate::program::Point;
use std::collections::HashMap;

/// Their values by the first two letters and the number.
#[derive(Debug, Default)]
pub(super) struct Stations(HashMap<(String, u64), Vec<(String, f64)>>);

/// `BC00001`
fn key(name: &str) -> Option<(String, u64)> {
    let (letters, digits) = name.split_at_checked(2)?;
    let digits = Some(digits).filter(|digits| digits.bytes().all(|byte| byte.is_ascii_digit()))?;
    ["BC", "EC", "BP", "EX"].contains(&letters).then(|| Some((letters.into(), digits.parse().ok()?)))?
}

impl Stations {
    /// A line of the section //POS.
    pub(super) fn line(&mut self, line: &Line<'_>, pulses: bool) {
        let text = String::from_utf8_lossy(line.trimmed());
        let Some((name, values)) = text.split_once('=') else { return };
        let Some(key) = key(name.trim()) else { return };
        let one = |(k, value): (usize, &str)| {
            let value = value.trim();
            let number = number_at(value.as_bytes()).filter(|(_, length)| *length == value.len());
            // Pulses are no lengths and no angles.
            let unit = if pulses { " in pulses" } else { "" };
            (format!("{}{}{unit}", key.0, k + 1), number.map_or(f64::NAN, |(value, _)| value))
        };
        let values = values.split(',').enumerate().map(one).collect();
        self.0.insert(key, values);
    }

    /// A motion to a point, with its words.
    pub(super) fn move_to<'t>(&self, words: impl Iterator<Item = &'t str>, point: &mut Point, line: usize) {
        let mut here: Vec<(String, f64)> = Vec::new();
        for key in words.filter_map(key) {
            let unknown = || vec![(format!("{}{:05}", key.0, key.1), f64::NAN)];
            here.extend(self.0.get(&key).cloned().unwrap_or_else(unknown));
        }
        if point.external.is_empty() {
            point.external = here;
        } else if point.external != here {
            let words = format!("line {line} goes to it with other external axes than a line before");
            point.fixed.get_or_insert(words);
        }
    }
}
