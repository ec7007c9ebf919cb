//! Records of a kind, and what their cells come to.

use super::description::Kind;
use super::interval::Fraction;
use super::record::Record;

pub fn of<'a>(records: &[&'a Record], kind: Kind) -> Vec<&'a Record> {
    records.iter().copied().filter(|record| record.text("kind") == kind.word()).collect()
}

/// Of those that have the column.
pub fn fraction<'a>(records: impl IntoIterator<Item = &'a Record>, column: &str) -> Fraction {
    Fraction::of(records.into_iter().filter_map(|record| record.yes(column)))
}

pub fn quantiles(values: Vec<f64>) -> String {
    let mut values: Vec<f64> = values.into_iter().filter(|value| value.is_finite()).collect();
    values.sort_by(f64::total_cmp);
    let at = |part: f64| values.get(((values.len().max(1) - 1) as f64 * part).round() as usize).copied();
    match (at(0.1), at(0.5), at(0.9)) {
        (Some(low), Some(middle), Some(high)) => format!("{middle:.2} ({low:.2}–{high:.2})"),
        _ => "–".into(),
    }
}

pub fn numbers(records: &[&Record], column: &str) -> Vec<f64> {
    records.iter().filter_map(|record| record.number(column)).collect()
}
