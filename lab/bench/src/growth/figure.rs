//! The figure: two panels with logarithmic axes, each with the power that was fitted.

use super::Series;
use crate::prelude::*;
use plotters::coord::Shift;
use plotters::prelude::*;

type Area<'a> = DrawingArea<SVGBackend<'a>, Shift>;

/// Draws both series side by side.
pub fn draw(path: &Path, rows: &Series, unknowns: &Series) -> Outcome {
    let root = SVGBackend::new(path, (900, 360)).into_drawing_area();
    root.fill(&WHITE)?;
    let (left, right) = root.split_horizontally(450);
    panel(&left, rows, "rows (318 unknowns)")?;
    panel(&right, unknowns, "unknowns (5 000 points)")?;
    root.present()?;
    Ok(())
}

fn panel(area: &Area<'_>, series: &Series, words: &str) -> Outcome {
    let [x, t] = [0, 1].map(|k| {
        let of = |p: &(f64, f64)| if k == 0 { p.0 } else { p.1 };
        let least = series.points.iter().map(of).fold(f64::INFINITY, f64::min);
        let most = series.points.iter().map(of).fold(0.0, f64::max);
        (0.8 * least..1.25 * most).log_scale()
    });
    let exponent = series.exponent();
    let mut chart = ChartBuilder::on(area)
        .caption(format!("time ∝ {}^{exponent:.2}", series.name), ("sans-serif", 16))
        .margin(12)
        .x_label_area_size(38)
        .y_label_area_size(56)
        .build_cartesian_2d(x, t)?;
    chart
        .configure_mesh()
        .x_desc(words)
        .x_labels(4)
        .y_desc("CPU, s")
        .x_label_formatter(&|x| format!("{x:.0}"))
        .y_label_formatter(&|t| format!("{t}"))
        .light_line_style(WHITE.mix(0.0))
        .draw()?;
    // The power through the middle of what it was fitted to.
    let upper = series.upper();
    let n = upper.len() as f64;
    let level = upper.iter().map(|(x, t)| (t.ln() - exponent * x.ln()) / n).sum::<f64>();
    chart.draw_series(LineSeries::new(
        upper.iter().map(|(x, _)| (*x, (level + exponent * x.ln()).exp())),
        RED.stroke_width(2),
    ))?;
    chart.draw_series(series.points.iter().map(|p| Circle::new(*p, 4, BLUE.filled())))?;
    Ok(())
}
