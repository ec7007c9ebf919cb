//! Horizontal bars with names and numbers: the waterfall, and strategies side by side.

use super::axes::frame;
use super::escape;
use std::fmt::Write;

/// One bar.
pub(crate) struct Bar {
    /// Its name.
    pub name: String,
    /// Where it begins and ends.
    pub range: [f64; 2],
    /// Its colour.
    pub class: &'static str,
    /// What is written beside it.
    pub label: String,
}

/// Bars under each other; `level` is a dashed line with its name.
pub(crate) fn bars(about: &str, list: &[Bar], level: Option<(f64, String)>) -> String {
    const WIDTH: f64 = 760.0;
    const ROW: f64 = 30.0;
    const NAMES: f64 = 230.0;
    const LABELS: f64 = 130.0;
    let most =
        list.iter().flat_map(|b| b.range).chain(level.iter().map(|l| l.0)).fold(f64::MIN_POSITIVE, f64::max);
    let across = |v: f64| NAMES + v / most * (WIDTH - NAMES - LABELS);
    let height = ROW * list.len() as f64 + 28.0;
    let mut body = String::new();
    for (k, bar) in list.iter().enumerate() {
        let top = ROW * k as f64 + 6.0;
        let [from, to] = [bar.range[0].min(bar.range[1]), bar.range[0].max(bar.range[1])].map(across);
        let name = if bar.name.chars().count() > 34 {
            bar.name.chars().take(33).collect::<String>() + "…"
        } else {
            bar.name.clone()
        };
        let _ = write!(
            body,
            "<text x=\"{:.1}\" y=\"{:.1}\" text-anchor=\"end\">{}</text>\
             <rect class=\"{}\" x=\"{from:.1}\" y=\"{top:.1}\" width=\"{:.1}\" height=\"18\" rx=\"2\"/>\
             <text x=\"{:.1}\" y=\"{:.1}\">{}</text>",
            NAMES - 8.0,
            top + 13.5,
            escape(&name),
            bar.class,
            (to - from).max(1.0),
            to + 6.0,
            top + 13.5,
            escape(&bar.label)
        );
        if k + 1 < list.len() {
            let end = across(bar.range[1]);
            let _ = write!(
                body,
                "<path class=\"axis\" opacity=\".5\" d=\"M{end:.1} {:.1}V{:.1}\"/>",
                top + 18.0,
                top + ROW
            );
        }
    }
    if let Some((value, name)) = level {
        let at = across(value);
        let _ = write!(
            body,
            "<path class=\"ink thinline dash\" d=\"M{at:.1} 2V{:.1}\"/><text class=\"soft\" x=\"{:.1}\" y=\"{:.1}\">{}</text>",
            height - 18.0,
            (at - 4.0).max(4.0),
            height - 5.0,
            escape(&name)
        );
    }
    frame(WIDTH, height, about, &body)
}
