//! Horizontal bars under their names and numbers: the waterfall, and strategies side by side.

use super::axes::frame;
use super::{cut, escape};
use std::fmt::Write;

/// One bar.
pub(crate) struct Bar {
    /// Its name.
    pub name: String,
    /// Where it begins and ends.
    pub range: [f64; 2],
    /// Its colour.
    pub class: &'static str,
    /// What is written beside its name.
    pub label: String,
}

/// Bars under each other, each under its name, so that they can be read on a narrow page; `level` is a dashed line with its
/// name.
pub(crate) fn bars(about: &str, list: &[Bar], level: Option<(f64, String)>) -> String {
    drawn(about, list, level, false)
}

/// Bars of which each begins where the one before ended.
pub(crate) fn waterfall(about: &str, list: &[Bar], level: Option<(f64, String)>) -> String {
    drawn(about, list, level, true)
}

fn drawn(about: &str, list: &[Bar], level: Option<(f64, String)>, steps: bool) -> String {
    const WIDTH: f64 = 400.0;
    const ROW: f64 = 44.0;
    const BAR: f64 = 16.0;
    /// Letters of 14 px that find room in a line.
    const LETTERS: usize = 52;
    let most =
        list.iter().flat_map(|b| b.range).chain(level.iter().map(|l| l.0)).fold(f64::MIN_POSITIVE, f64::max);
    let across = |v: f64| v / most * (WIDTH - 2.0);
    let height = ROW * list.len() as f64 + if level.is_some() { 20.0 } else { 2.0 };
    let mut body = String::new();
    for (k, bar) in list.iter().enumerate() {
        let top = ROW * k as f64 + 20.0;
        let [from, to] = [bar.range[0].min(bar.range[1]), bar.range[0].max(bar.range[1])].map(across);
        let name = cut(&bar.name, LETTERS.saturating_sub(bar.label.chars().count() + 3));
        let _ = write!(
            body,
            "<text x=\"0\" y=\"{0:.1}\" style=\"font-size:14px\">{1}</text>\
             <text x=\"{WIDTH}\" y=\"{0:.1}\" style=\"font-size:14px\" text-anchor=\"end\" font-weight=\"600\">{2}</text>\
             <rect class=\"tile\" x=\"0\" y=\"{top:.1}\" width=\"{WIDTH}\" height=\"{BAR}\"/>\
             <rect class=\"{3}\" x=\"{from:.1}\" y=\"{top:.1}\" width=\"{4:.1}\" height=\"{BAR}\" rx=\"2\"><title>{5}</title></rect>",
            top - 6.0,
            escape(&name),
            escape(&bar.label),
            bar.class,
            (to - from).max(1.5),
            escape(&format!("{}: {}", bar.name, bar.label)),
        );
        if steps && k + 1 < list.len() {
            let end = across(bar.range[1]);
            let _ = write!(
                body,
                "<path class=\"axis\" opacity=\".5\" d=\"M{end:.1} {:.1}V{:.1}\"/>",
                top + BAR,
                top + ROW
            );
        }
    }
    if let Some((value, name)) = level {
        let at = across(value);
        let (anchor, x) = if at > 0.5 * WIDTH { ("end", at + 1.0) } else { ("start", (at - 1.0).max(0.0)) };
        for k in 0..list.len() {
            let top = ROW * k as f64 + 20.0;
            let _ = write!(
                body,
                "<path class=\"ink thinline dash\" d=\"M{at:.1} {top:.1}V{:.1}\"/>",
                top + BAR + 5.0
            );
        }
        let _ = write!(
            body,
            "<text class=\"soft\" x=\"{x:.1}\" y=\"{:.1}\" text-anchor=\"{anchor}\">{}</text>",
            height - 8.0,
            escape(&name)
        );
    }
    frame(WIDTH, height, about, &body)
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn names_and_levels_stay_inside() {
        let bar = |to: f64| Bar {
            name: "a <name> ".repeat(20),
            range: [0.0, to],
            class: "bar-after",
            label: "1 mm".into(),
        };
        for level in [0.0, 0.2, 1.0] {
            let svg = waterfall("about", &[bar(1.0), bar(0.2)], Some((level, "noise floor".into())));
            assert!(
                svg.contains('…')
                    && !svg.contains("<name>")
                    && svg.contains("</title></rect>")
                    && svg.contains("noise floor")
            );
            let anchor = if level > 0.5 { "end\">noise" } else { "start\">noise" };
            assert!(svg.contains(anchor), "{svg}");
        }
    }
}
