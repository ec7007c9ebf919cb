//! The residual in the coordinate of one effect, against the input of the effect: with the effect removed from the model, and
//! with it included.

use super::axes::frame;
use super::{Plot, bins, cut, quantile, thin, unit_text};
use truepose_discover::Trace;

/// Points that are drawn.
const DRAWN: usize = 2500;
/// Means with their intervals.
const MEANS: usize = 24;
/// Steps of the curve.
const STEPS: usize = 160;

/// Width and height of a panel.
const PANEL: [f64; 2] = [400.0, 300.0];

/// An effect before and after.
pub(crate) struct TraceFigure {
    /// Without the effect, and with it: one SVG each, so that the page can place them side by side or stacked.
    pub panels: [String; 2],
    /// Both in one, for the file.
    pub whole: String,
    /// Notes for the caption.
    pub notes: Vec<String>,
}

/// The figure of one effect.
pub(crate) fn trace_figure(trace: &Trace, title: &str, period: Option<f64>) -> TraceFigure {
    let mut notes = Vec::new();
    let (factor, unit) =
        shown(trace.unit, quantile(trace.points.iter().map(|p| p.before.abs()).collect(), 0.5));
    let folded = fold(trace, period);
    let (x_factor, x_unit) = match trace.driver_unit.as_str() {
        "rad" => (1f64.to_degrees(), "°"),
        "m" => (1e3, "mm"),
        other => (1.0, other),
    };
    let x_unit = unit_text(x_unit);
    let name = cut(&trace.driver, 28);
    let x_of = |k: usize| {
        let x = trace.points[k].driver;
        x_factor * folded.map_or(x, |p| x.rem_euclid(p))
    };
    let x_name = match folded {
        Some(p) => {
            format!("{name} within its period of {} {x_unit}", crate::significant(p * x_factor, 4))
        }
        None if x_unit.is_empty() => name,
        None => format!("{name}, {x_unit}"),
    };
    // Rows with a short lever have little information and a large scatter.
    let lever = quantile(trace.points.iter().map(|p| p.lever).collect(), 0.9);
    let strong: Vec<usize> =
        (0..trace.points.len()).filter(|&k| trace.points[k].lever >= 0.25 * lever).collect();
    if strong.len() < trace.points.len() {
        notes.push(format!(
            "{} of {} rows are not drawn, because their position hardly depends on this error; the means weigh them by their sensitivity.",
            trace.points.len() - strong.len(),
            trace.points.len()
        ));
    }
    let sizes: Vec<f64> =
        strong.iter().map(|&k| trace.points[k].before.abs().max(trace.points[k].after.abs())).collect();
    let drawn: Vec<usize> = thin(&sizes, DRAWN, |_| false).into_iter().map(|k| strong[k]).collect();
    if drawn.len() < strong.len() {
        notes.push(format!("{} of {} rows are drawn, including the largest 1 %.", drawn.len(), strong.len()));
    }
    let all = || strong.iter().flat_map(|&k| [trace.points[k].before, trace.points[k].after]);
    let fits = trace.points.iter().map(|p| p.fitted);
    let low = quantile(all().collect(), 0.005).min(fits.clone().fold(f64::INFINITY, f64::min)) * factor;
    let high = quantile(all().collect(), 0.995).max(fits.fold(f64::NEG_INFINITY, f64::max)) * factor;
    let margin = 0.06 * (high - low);
    let y = [low - margin, high + margin];
    let xs: Vec<f64> = (0..trace.points.len()).map(x_of).collect();
    let x = [
        xs.iter().copied().fold(f64::INFINITY, f64::min),
        xs.iter().copied().fold(f64::NEG_INFINITY, f64::max),
    ];

    let mut panels = Vec::new();
    let mut outside = 0;
    for (panel, words) in ["without this effect", "with it"].iter().enumerate() {
        let of = |k: usize| {
            let p = &trace.points[k];
            factor * if panel == 0 { p.before } else { p.after }
        };
        let mut plot = Plot::new(PANEL[0], PANEL[1], x, y).axes(
            words,
            &x_name,
            &format!("{}, {unit}", cut(&trace.what, 28)),
        );
        let groups = trace.classes.len().max(1);
        for class in 0..groups {
            let inside = |k: &&usize| trace.points[**k].class == class;
            let colour = colour(panel, class, groups);
            plot.dots(&format!("{colour} dots"), drawn.iter().filter(inside).map(|&k| (xs[k], of(k))));
            let weighted: Vec<(f64, f64, f64)> = (0..trace.points.len())
                .filter(|k| trace.points[*k].class == class)
                .map(|k| (xs[k], of(k), trace.points[k].lever.powi(2)))
                .collect();
            for bin in bins(&weighted, MEANS).iter().filter(|b| b.count > 2 && b.error.is_finite()) {
                let half = 2.0 * bin.error;
                plot.line(&format!("{colour} curve"), &[(bin.x, bin.y - half), (bin.x, bin.y + half)]);
                plot.dots(&format!("{colour} strong"), std::iter::once((bin.x, bin.y)));
            }
            if panel == 0 && curve(&mut plot, trace, &xs, factor, class) {
                notes.push(
                    "The effect depends on more than this input: the curve is its mean, the band holds 95 % of its values there."
                        .into(),
                );
            }
        }
        if panel == 1 {
            plot.line("ink thinline", &[(x[0], 0.0), (x[1], 0.0)]);
        }
        outside += plot.outside();
        panels.push(plot);
    }
    if outside > 0 {
        notes.push(format!(
            "{} outside of the scale {} drawn at its edge.",
            crate::count(outside, "point"),
            if outside == 1 { "is" } else { "are" }
        ));
    }
    notes.dedup();
    let about =
        |words: &str| format!("{title}: residual of {}, against {}; {words}", trace.what, trace.driver);
    let both: String =
        panels.iter().enumerate().map(|(k, plot)| plot.panel([PANEL[0] * k as f64, 0.0])).collect();
    TraceFigure {
        panels: ["without the effect in the model", "with the effect in the model"]
            .map(&about)
            .map(|words| panels.remove(0).finish(&words)),
        whole: frame(
            2.0 * PANEL[0],
            PANEL[1],
            &about("on the left without the effect in the model, on the right with it"),
            &both,
        ),
        notes,
    }
}

/// Draws the fitted effect; true when it depends on more than this input.
fn curve(plot: &mut Plot, trace: &Trace, xs: &[f64], factor: f64, class: usize) -> bool {
    let mine = || (0..trace.points.len()).filter(|k| trace.points[*k].class == class);
    let fitted: Vec<(f64, f64, f64)> =
        mine().map(|k| (xs[k], factor * trace.points[k].fitted, 1.0)).collect();
    let doubt: Vec<(f64, f64, f64)> = mine().map(|k| (xs[k], factor * trace.points[k].sd, 1.0)).collect();
    let line = bins(&fitted, STEPS);
    let mean = fitted.iter().map(|f| f.1).sum::<f64>() / fitted.len().max(1) as f64;
    let whole = fitted.iter().map(|f| (f.1 - mean).powi(2)).sum::<f64>().sqrt();
    let within = line.iter().map(|b| b.spread.powi(2) * b.count as f64).sum::<f64>().sqrt();
    let loose = within > 0.3 * whole && whole > 0.0;
    let line = if loose { bins(&fitted, MEANS) } else { line };
    let sds = bins(&doubt, if loose { MEANS } else { STEPS });
    let band: Vec<(f64, f64, f64)> = line
        .iter()
        .zip(&sds)
        .map(|(b, sd)| {
            let half = 1.96 * if loose { b.spread } else { sd.y };
            (b.x, b.y - half, b.y + half)
        })
        .collect();
    plot.band(&band);
    // Data are missing where a twentieth of the range holds none.
    let ends = xs.iter().fold([f64::INFINITY, f64::NEG_INFINITY], |e, x| [e[0].min(*x), e[1].max(*x)]);
    let gap = ((ends[1] - ends[0]) / 20.0)
        .max(1.6 * (ends[1] - ends[0]) / if loose { MEANS } else { STEPS } as f64);
    plot.line_over_data("ink curve", &line.iter().map(|b| (b.x, b.y)).collect::<Vec<_>>(), gap);
    loose
}

fn colour(panel: usize, class: usize, classes: usize) -> &'static str {
    match (classes, panel, class) {
        (1, 0, _) => "before",
        (1, _, _) => "after",
        (_, _, 0) => "c0",
        (_, _, 1) => "c1",
        _ => "c2",
    }
}

/// The period over which a periodic effect is folded.
fn fold(trace: &Trace, period: Option<f64>) -> Option<f64> {
    const TURNS: f64 = 4.0;
    let low = trace.points.iter().map(|p| p.driver).fold(f64::INFINITY, f64::min);
    let high = trace.points.iter().map(|p| p.driver).fold(f64::NEG_INFINITY, f64::max);
    period.filter(|p| *p > 0.0 && (high - low) / p > TURNS)
}

/// Factor and unit that suit a typical size.
fn shown(unit: &str, typical: f64) -> (f64, &'static str) {
    match unit {
        "rad" if typical < 3e-4 => (1e6, "µrad"),
        "rad" => (1e3, "mrad"),
        "m" if typical < 3e-4 => (1e6, "µm"),
        "m" => (1e3, "mm"),
        "kg" => (1.0, "kg"),
        _ => (1.0, ""),
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use truepose_discover::TracePoint;

    fn wave(turns: f64, class: impl Fn(usize) -> usize) -> Trace {
        let point = |row: usize| {
            let driver = row as f64 / 500.0 * turns * std::f64::consts::TAU;
            let fitted = 1e-3 * driver.sin();
            let after = 1e-5 * ((row * 7919) % 13) as f64;
            let lever = if row.is_multiple_of(50) { 1e-3 } else { 1.0 };
            TracePoint {
                row,
                driver,
                before: fitted + after,
                after,
                fitted,
                sd: 1e-5,
                lever,
                class: class(row),
            }
        };
        Trace {
            what: "a <b> about its axis".into(),
            unit: "rad",
            driver: "a <b>".into(),
            driver_unit: "rad".into(),
            classes: Vec::new(),
            points: (0..500).map(point).collect(),
        }
    }

    #[test]
    fn both_panels_are_drawn_and_rows_left_out_are_noted() {
        let TraceFigure { panels, whole: svg, notes } = trace_figure(&wave(1.0, |_| 0), "wave", None);
        assert!(panels[0].contains("before dots") && !panels[0].contains("after dots"));
        assert!(panels[1].contains("after dots") && !panels[1].contains("before dots"));
        assert!(!svg.contains("NaN") && !svg.contains("<b>") && svg.contains("mrad"));
        assert!(svg.contains("before dots") && svg.contains("after dots") && svg.contains("ink curve"));
        assert!(notes.iter().any(|n| n.starts_with("10 of 500 rows")), "{notes:?}");
        assert!(!notes.iter().any(|n| n.contains("more than this input")), "{notes:?}");
    }

    #[test]
    fn periodic_effects_are_folded_over_their_period() {
        let TraceFigure { whole: svg, notes, .. } =
            trace_figure(&wave(9.0, |_| 0), "wave", Some(std::f64::consts::TAU));
        assert!(svg.contains("within its period of 360.0 °"));
        assert!(!notes.iter().any(|n| n.contains("more than this input")), "{notes:?}");
        // At half the period the curve is none of this input alone.
        let TraceFigure { notes, .. } =
            trace_figure(&wave(9.0, |_| 0), "wave", Some(0.7 * std::f64::consts::TAU));
        assert!(notes.iter().any(|n| n.contains("more than this input")), "{notes:?}");
    }
}
