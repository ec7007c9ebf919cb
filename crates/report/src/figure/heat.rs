//! A heat map of correlations between coefficients.

use super::axes::frame;
use super::{cut, escape};
use std::fmt::Write;

/// Square of values −1…1 with names; strength is opacity, sign is colour.
pub(crate) fn heat_map(about: &str, names: &[String], value: impl Fn(usize, usize) -> f64) -> String {
    const CELL: f64 = 14.0;
    const NAMES: f64 = 210.0;
    let n = names.len();
    let mut body = String::new();
    let side = CELL * n as f64;
    let _ = write!(body, "<rect class=\"tile\" x=\"{NAMES}\" y=\"4\" width=\"{side}\" height=\"{side}\"/>");
    for (row, name) in names.iter().enumerate() {
        let top = 4.0 + CELL * row as f64;
        let name = cut(name, 32);
        let _ = write!(
            body,
            "<text style=\"font-size:10.5px\" x=\"{}\" y=\"{:.1}\" text-anchor=\"end\">{} · {}</text>",
            NAMES - 5.0,
            top + 10.5,
            escape(&name),
            row + 1
        );
        for column in 0..n {
            let v = value(row, column);
            if !v.is_finite() || v.abs() < 0.05 {
                continue;
            }
            let _ = write!(
                body,
                "<rect class=\"{}\" x=\"{:.1}\" y=\"{top:.1}\" width=\"13\" height=\"13\" opacity=\"{:.2}\"/>",
                if v > 0.0 { "hot" } else { "cold" },
                NAMES + CELL * column as f64,
                v.abs().min(1.0)
            );
        }
    }
    for column in (0..n).filter(|c| n < 12 || (c + 1) % 5 == 0) {
        let _ = write!(
            body,
            "<text class=\"soft\" style=\"font-size:10.5px\" x=\"{:.1}\" y=\"{:.1}\" text-anchor=\"middle\">{}</text>",
            NAMES + CELL * (column as f64 + 0.5),
            side + 18.0,
            column + 1
        );
    }
    let height = side + 48.0;
    let _ = write!(
        body,
        "<rect class=\"cold\" x=\"{NAMES}\" y=\"{0:.1}\" width=\"12\" height=\"12\"/><text x=\"{1}\" y=\"{2:.1}\">−1</text>\
         <rect class=\"hot\" x=\"{3}\" y=\"{0:.1}\" width=\"12\" height=\"12\"/><text x=\"{4}\" y=\"{2:.1}\">+1 (fainter: weaker)</text>",
        side + 28.0,
        NAMES + 16.0,
        side + 38.0,
        NAMES + 50.0,
        NAMES + 66.0
    );
    frame((NAMES + side + 10.0).max(NAMES + 210.0), height, about, &body)
}
