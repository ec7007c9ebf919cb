//! The page with all looks at a robot.

use super::MonitorSummary;
use crate::figure::{Plot, escape};
use crate::page::{Page, Report};
use crate::{RunRecord, count, significant};

/// A look as the page shows it.
#[derive(Debug, Clone, PartialEq)]
pub struct LookView {
    /// Name of the file of measurements.
    pub data: String,
    /// When it was measured, year-month-day.
    pub date: Option<String>,
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
    fill(&mut page, last, looks);
    page.finish().html
}

/// The report of a look, with the head of the certificate, and all looks in order.
pub fn monitor_report(last: &MonitorSummary, looks: &[LookView], run: &RunRecord) -> Report {
    let mut page = Page::new(&format!("{}: whether it has changed", last.robot));
    let poses = format!("{} ({})", last.poses, count(last.rows, "row"));
    let date = last.date.clone().map(|date| ("measured", date));
    let facts: Vec<_> = date.into_iter().chain([("pose measurements", poses)]).collect();
    page.head(run, &facts);
    fill(&mut page, last, looks);
    page.section("Files");
    page.reproduction(run);
    page.finish()
}

/// Where each look is on an axis, and the axis: days since the first one where all have a date, else their numbers.
fn axis(looks: &[LookView]) -> (Vec<f64>, String) {
    let dates: Option<Vec<f64>> = looks.iter().map(|look| day(look.date.as_deref()?)).collect();
    match dates.filter(|days| days.iter().any(|day| *day > days[0])) {
        Some(days) => {
            let first = looks[0].date.as_deref().unwrap_or_default();
            (days.iter().map(|day| day - days[0]).collect(), format!("days since {first}"))
        }
        None => ((1..=looks.len()).map(|k| k as f64).collect(), "look".into()),
    }
}

/// Days of a date, year-month-day, since one that is long past.
fn day(date: &str) -> Option<f64> {
    let mut parts = date.split('-').map(|part| part.parse::<i64>().ok());
    let (year, month, day) = (parts.next()??, parts.next()??, parts.next()??);
    // Years that begin in March have their leap day at the end.
    let (year, month) = if month > 2 { (year, month - 3) } else { (year - 1, month + 9) };
    Some((365 * year + year / 4 - year / 100 + year / 400 + (153 * month + 2) / 5 + day) as f64)
}

fn fill(page: &mut Page, last: &MonitorSummary, looks: &[LookView]) {
    page.section("Verdict");
    page.raw(&format!("<p class=\"verdict\">{}</p>", escape(&last.verdict())));
    if let Some(specification) = &last.specification {
        page.text(&specification.sentence());
    }
    page.text(&since(looks));
    page.section("History");
    let most = looks.iter().map(|look| look.rms_mm.max(look.expected_rms_mm)).fold(1e-6, f64::max);
    let (at, along) = axis(looks);
    let ends =
        at.iter().fold([f64::INFINITY, f64::NEG_INFINITY], |[low, high], &v| [low.min(v), high.max(v)]);
    let margin = 0.5f64.max(0.05 * (ends[1] - ends[0]));
    let across = [ends[0] - margin, ends[1] + margin];
    let plot =
        |title: &str, top: f64, up: &str| Plot::new(560.0, 260.0, across, [0.0, top]).axes(title, &along, up);
    let each = |of: fn(&LookView) -> f64| -> Vec<(f64, f64)> {
        at.iter().zip(looks).map(|(&at, look)| (at, of(look))).collect()
    };
    let alarms = |of: fn(&LookView) -> f64, alarm: bool| -> Vec<(f64, f64)> {
        each(of).into_iter().zip(looks).filter(|(_, look)| look.changed == alarm).map(|(at, _)| at).collect()
    };
    let mut left = plot("residual", 1.1 * most, "RMS, mm");
    left.line("ink thinline dash", &each(|look| look.expected_rms_mm));
    left.dots("after strong", alarms(|look| look.rms_mm, false).into_iter());
    left.dots("before strong", alarms(|look| look.rms_mm, true).into_iter());
    figure(
        page,
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
    figure(page, &right.finish("Evidence of each look, and the level that it has to exceed"), &text);
    let row = |(k, look): (usize, &LookView)| {
        vec![
            k.to_string(),
            look.date.clone().unwrap_or_else(|| "–".into()),
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
    let head =
        ["look", "date", "data", "poses", "RMS, mm", "unchanged, mm", "p", "level", "verdict", "most likely"];
    page.table("All looks, the first one first", &head, &rows, false);
    page.section("Last look");
    let told = last.to_string();
    page.raw(&format!("<pre tabindex=\"0\">{}</pre>", escape(told.trim())));
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
        "{all} since the calibration; {alarms} found a change, for the first time look {} ({}{}{suspect}).",
        first + 1,
        looks[first].date.as_ref().map_or_else(String::new, |date| format!("{date}, ")),
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
            date: None,
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
            date: None,
            specification: None,
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
