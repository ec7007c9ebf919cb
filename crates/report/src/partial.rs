//! Rows in which some components of the position were not measured.

use crate::count;
use serde::{Deserialize, Serialize};
use truepose_errormodel::Dataset;

/// How many rows have one or two components of a position, by which; every error of such a row is over these components.
#[derive(Debug, Clone, PartialEq, Eq, Default, Serialize, Deserialize)]
pub struct PartialRows {
    /// Rows with any component.
    pub of: usize,
    /// Components (`x`, `x and y`, …) and rows, most rows first.
    pub rows: Vec<(String, usize)>,
}

impl PartialRows {
    /// Of a data set; `None` where every measured position is complete. Rows that measured a number along a direction do not count.
    pub fn of(data: &Dataset) -> Option<Self> {
        let seen = |row: usize| data.seen(row).position;
        let with = || (0..data.len()).filter(|&row| data.ray(row).is_none() && seen(row).contains(&true));
        let mut rows: Vec<(String, usize)> = Vec::new();
        for row in with().filter(|&row| seen(row).contains(&false)) {
            let names: Vec<&str> =
                ["x", "y", "z"].into_iter().zip(seen(row)).filter(|s| s.1).map(|s| s.0).collect();
            let name = names.join(" and ");
            match rows.iter_mut().find(|(other, _)| *other == name) {
                Some((_, count)) => *count += 1,
                None => rows.push((name, 1)),
            }
        }
        rows.sort_by(|a, b| b.1.cmp(&a.1).then(a.0.cmp(&b.0)));
        (!rows.is_empty()).then(|| PartialRows { of: with().count(), rows })
    }

    /// What an RMS of position errors is over.
    pub(crate) fn rms(partial: Option<&Self>) -> &'static str {
        partial.map_or("3-D RMS", |_| "RMS over the measured components")
    }

    /// What a position error is.
    pub(crate) fn error(partial: Option<&Self>) -> &'static str {
        partial.map_or("3-D distance", |_| "distance over the measured components")
    }

    /// `Measured components of the position: x alone in 81 of 120 rows. Errors of these rows are over …`
    pub fn sentence(&self) -> String {
        let each = self.rows.iter().map(|(names, rows)| {
            let alone = if names.len() == 1 { " alone" } else { "" };
            format!("{names}{alone} in {rows}")
        });
        format!(
            "Measured components of the position: {} of {}. Errors of these rows are over the measured components, and less than 3-D ones.",
            each.collect::<Vec<_>>().join(", "),
            count(self.of, "row")
        )
    }
}
