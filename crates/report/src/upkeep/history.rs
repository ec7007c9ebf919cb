//! The page with all looks at a robot.

use super::MonitorSummary;
use crate::figure::{Plot, escape};
use crate::page::Page;
use crate::{count, significant};

/// A look as the page shows it.
#[derive(Debug, Clone, PartialEq)]
pub struct LookView {
    /// Name of the file of measurements.
    pub data: String,
    /// Pose measurements.
    pub poses: usize,
    /// RMS of the residual, mm.
    pub rms_mm: f64,
    /// RMS of an unchanged robot, mm.
    pub expected_rms_mm: f64,
    /// p of the look.
    pub p_value: f64,
    /// Its level.
    pub level: f64,
    /// Whether p was below it.
    pub changed: bool,
    /// What had changed most likely.
    pub suspect: Option<String>,
}

/// Powers of ten below which a p is drawn at the edge.
const SMALLEST: f64 = 12.0;

/// The page: the last look, whose summary is given, and all looks in order.
pub fn history_page(last: &MonitorSummary, looks: &[LookView]) -> String {
    let mut page = Page::new(&format!("{}: looks since the calibration", last.robot));
    page.section("Verdict");
    page.raw(&format!("<p class=\"verdict\">{}</p>", escape(&last.verdict())));
    page.text(&since(looks));
    page.section("History");
    let most = looks.iter().map(|look| look.rms_mm.max(look.expected_rms_mm)).fold(1e-6, f64::max);
    let across = [0.5, looks.len() as f64 + 0.5];
    let plot =
        |title: &str, top: f64, up: &str| Plot::new(560.0, 260.0, across, [0.0, top]).axes(title, "look", up);
    let each = |of: fn(&LookView) -> f64| -> Vec<(f64, f64)> {
        looks.iter().enumerate().map(|(k, look)| (k as f64 + 1.0, of(look))).collect()
    };
    let alarms = |of: fn(&LookView) -> f64, alarm: bool| -> Vec<(f64, f64)> {
        each(of).into_iter().zip(looks).filter(|(_, look)| look.changed == alarm).map(|(at, _)| at).collect()
    };
    let mut left = plot("residual", 1.1 * most, "RMS, mm");
    left.line("ink thinline dash", &each(|look| look.expected_rms_mm));
    left.dots("after strong", alarms(|look| look.rms_mm, false).into_iter());
    left.dots("before strong", alarms(|look| look.rms_mm, true).into_iter());
    figure(
        &mut page,
        &left.finish("Residual of each look, and that of an unchanged robot"),
        "Residual of each look (dots; orange: the robot had changed), and what an unchanged robot has (dashed).",
    );
    let top = looks.iter().map(|look| power(look.p_value).max(power(look.level))).fold(1.0, f64::max);
    let mut right = plot("evidence of a change", 1.1 * top, "-log10 p");
    right.line("ink thinline dash", &each(|look| power(look.level)));
    right.dots("after strong", alarms(|look| power(look.p_value), false).into_iter());
    right.dots("before strong", alarms(|look| power(look.p_value), true).into_iter());
    let text = format!(
        "Evidence of each look, and the level that it has to exceed (dashed). The level rises from look to look: an unchanged robot ever exceeds it with a probability of {} % at most, however often it is looked at. What is smaller than 1e-{SMALLEST} is drawn there.",
        significant(100.0 * last.alpha, 2)
    );
    figure(&mut page, &right.finish("Evidence of each look, and the level that it has to exceed"), &text);
    let row = |(k, look): (usize, &LookView)| {
        vec![
            k.to_string(),
            look.data.clone(),
            look.poses.to_string(),
            significant(look.rms_mm, 3),
            significant(look.expected_rms_mm, 3),
            significant(look.p_value, 2),
            significant(look.level, 2),
            if look.changed { "changed" } else { "no change" }.to_owned(),
            look.suspect.clone().unwrap_or_default(),
        ]
    };
    let rows: Vec<Vec<String>> = (1..).zip(looks).map(row).collect();
    let head = ["look", "data", "poses", "RMS, mm", "unchanged, mm", "p", "level", "verdict", "most likely"];
    page.table("All looks, the first one first", &head, &rows, false);
    page.section("Last look");
    let told = last.to_string();
    page.raw(&format!("<pre tabindex=\"0\">{}</pre>", escape(told.trim())));
    page.finish().html
}

/// How many looks there were, and since when the robot has been another one.
fn since(looks: &[LookView]) -> String {
    let all = count(looks.len(), "look");
    let Some(first) = looks.iter().position(|look| look.changed) else {
        return format!("{all} since the calibration, none of which found a change.");
    };
    let alarms = looks.iter().filter(|look| look.changed).count();
    let suspect =
        looks[first].suspect.as_deref().map_or(String::new(), |what| format!("; most likely {what}"));
    format!(
        "{all} since the calibration; {alarms} found a change, for the first time look {} ({}{suspect}).",
        first + 1,
        looks[first].data
    )
}

/// -log10 p, as far as it is drawn.
fn power(p: f64) -> f64 {
    (-p.max(f64::MIN_POSITIVE).log10()).clamp(0.0, SMALLEST)
}

/// A figure that is on the page alone.
fn figure(page: &mut Page, svg: &str, caption: &str) {
    page.raw(&format!(
        "<figure><div class=\"wide\" tabindex=\"0\" role=\"group\" aria-label=\"{0}\">{svg}</div><figcaption>{0}</figcaption></figure>",
        escape(caption)
    ));
}

#[cfg(test)]
mod tests {
    use super::*;

    fn look(p_value: f64, changed: bool) -> LookView {
        LookView {
            data: "<monday>.csv".into(),
            poses: 12,
            rms_mm: 0.05,
            expected_rms_mm: 0.04,
            p_value,
            level: 0.005,
            changed,
            suspect: changed.then(|| "zero of j3 (rz@j3)".into()),
        }
    }

    #[test]
    fn a_page_tells_since_when_and_shows_every_look() {
        let last = MonitorSummary {
            robot: "R".into(),
            look: 3,
            rows: 36,
            poses: 12,
            changed: true,
            p_value: 1e-9,
            level: 0.00083,
            alpha: 0.01,
            rms_mm: 0.2,
            expected_rms_mm: 0.04,
            found: Vec::new(),
            set_up_anew: None,
            changes: Vec::new(),
            detectable: Vec::new(),
            invisible: Vec::new(),
        };
        let quiet = history_page(&last, &[look(0.4, false)]);
        assert!(quiet.contains("1 look since the calibration, none of which found a change."));
        let html = history_page(&last, &[look(0.4, false), look(0.0, true), look(1e-9, true)]);
        assert!(html.contains("3 looks since the calibration; 2 found a change, for the first time look 2"));
        assert!(html.contains("&lt;monday&gt;.csv") && !html.contains("<monday>"));
        assert!(!html.contains("NaN") && !html.contains("inf"), "{html}");
        assert_eq!(html.matches("<th scope=\"row\">").count(), 3);
        assert_eq!(html.matches("<svg").count(), 2);
    }
}
