//! The paper's figures 6, 7 and 8 and the payload test, as SVG.

use super::trial::{Experiment, Radii};
use crate::prelude::*;
use plotters::prelude::*;

const SPECIFICATION_MM: f64 = 0.5;

fn mm(v: &Vector3<f64>) -> (f64, f64, f64) {
    (v.x * 1e3, v.y * 1e3, v.z * 1e3)
}

/// Figure 6: errors in space before and after, with the specification sphere (its three great circles).
pub fn space(path: &Path, experiment: &Experiment, after: &Radii, model: &str) -> Outcome {
    let root = SVGBackend::new(path, (1200, 600)).into_drawing_area();
    root.fill(&WHITE)?;
    let (left, right) = root.split_horizontally(600);
    let before = experiment.errors_before();
    cloud(&left, "before compensation, mm", &before)?;
    cloud(&right, &format!("after: {model}, mm"), &after.errors)?;
    root.present()?;
    Ok(())
}

fn cloud(
    area: &DrawingArea<SVGBackend, plotters::coord::Shift>,
    title: &str,
    errors: &[Vector3<f64>],
) -> Outcome {
    let reach = errors.iter().map(|e| e.amax() * 1e3).fold(SPECIFICATION_MM, f64::max) * 1.1;
    let range = -reach..reach;
    let mut chart = ChartBuilder::on(area).caption(title, ("sans-serif", 18)).margin(15).build_cartesian_3d(
        range.clone(),
        range.clone(),
        range,
    )?;
    chart.configure_axes().draw()?;
    for plane in 0..3 {
        let circle = (0..=72).map(|k| {
            let (s, c) = (f64::from(k) * 5f64.to_radians()).sin_cos();
            let (s, c) = (s * SPECIFICATION_MM, c * SPECIFICATION_MM);
            match plane {
                0 => (c, s, 0.0),
                1 => (c, 0.0, s),
                _ => (0.0, c, s),
            }
        });
        chart.draw_series(LineSeries::new(circle, BLUE.mix(0.6)))?;
    }
    chart.draw_series(errors.iter().map(|e| Circle::new(mm(e), 3, RED.filled())))?;
    Ok(())
}

/// Figure 7: 270 returns to home, by axis.
pub fn repeatability(path: &Path, experiment: &Experiment) -> Outcome {
    let root = SVGBackend::new(path, (1200, 400)).into_drawing_area();
    root.fill(&WHITE)?;
    let n = experiment.returns.len() as f64;
    let mean = experiment.returns.iter().sum::<Vector3<f64>>() / n;
    for (axis, area) in root.split_evenly((1, 3)).iter().enumerate() {
        let values: Vec<f64> = experiment.returns.iter().map(|p| (p[axis] - mean[axis]) * 1e3).collect();
        let sd = (values.iter().map(|v| v * v).sum::<f64>() / (n - 1.0)).sqrt();
        let bins = |v: f64| ((v / 0.02).round() * 20.0) as i32;
        let mut counts = std::collections::BTreeMap::new();
        values.iter().for_each(|&v| *counts.entry(bins(v)).or_insert(0i32) += 1);
        let most = counts.values().copied().max().unwrap_or(1);
        let title = format!("{}: 3σ = {:.3} mm", ["x", "y", "z"][axis], 3.0 * sd);
        let mut chart = ChartBuilder::on(area)
            .caption(title, ("sans-serif", 18))
            .margin(15)
            .x_label_area_size(30)
            .y_label_area_size(35)
            .build_cartesian_2d(-260i32..260, 0..most + 5)?;
        chart.configure_mesh().x_desc("µm").y_desc("returns").draw()?;
        chart.draw_series(
            counts
                .iter()
                .map(|(&at, &count)| Rectangle::new([(at - 9, 0), (at + 9, count)], BLUE.mix(0.7).filled())),
        )?;
    }
    root.present()?;
    Ok(())
}

/// Figure 8: residuals at the check configurations by axis, all plants.
pub fn axes(path: &Path, radii: &[Radii]) -> Outcome {
    let root = SVGBackend::new(path, (900, 400)).into_drawing_area();
    root.fill(&WHITE)?;
    let mut chart = ChartBuilder::on(&root)
        .caption(
            "residuals by axis at the check configurations: mean and ±3σ of each plant, mm",
            ("sans-serif", 16),
        )
        .margin(15)
        .x_label_area_size(30)
        .y_label_area_size(45)
        .build_cartesian_2d(0.0..3.0f64, -0.4..0.4f64)?;
    chart.configure_mesh().x_labels(4).x_label_formatter(&|_| String::new()).y_desc("mm").draw()?;
    for axis in 0..3 {
        for (k, plant) in radii.iter().enumerate() {
            let n = plant.errors.len() as f64;
            let mean = plant.errors.iter().map(|e| e[axis] * 1e3).sum::<f64>() / n;
            let sd =
                (plant.errors.iter().map(|e| (e[axis] * 1e3 - mean).powi(2)).sum::<f64>() / (n - 1.0)).sqrt();
            let x = axis as f64 + 0.1 + 0.8 * k as f64 / radii.len() as f64;
            let colour = Palette99::pick(axis);
            chart.draw_series(LineSeries::new(
                [(x, mean - 3.0 * sd), (x, mean + 3.0 * sd)],
                colour.stroke_width(2),
            ))?;
            chart.draw_series([Circle::new((x, mean), 2, BLACK.filled())])?;
        }
        let label = Text::new(["x", "y", "z"][axis], (axis as f64 + 0.45, 0.37), ("sans-serif", 18));
        chart.draw_series([label])?;
    }
    root.present()?;
    Ok(())
}

/// Displacement of the treatment point against the payload at home.
pub fn linearity(path: &Path, experiment: &Experiment) -> Outcome {
    let root = SVGBackend::new(path, (700, 450)).into_drawing_area();
    root.fill(&WHITE)?;
    let most = experiment.loads.iter().map(|p| p.1 * 1e3).fold(1.0, f64::max) * 1.05;
    let mut chart = ChartBuilder::on(&root)
        .caption("displacement of the treatment point at home", ("sans-serif", 18))
        .margin(15)
        .x_label_area_size(40)
        .y_label_area_size(50)
        .build_cartesian_2d(0.0..310.0f64, 0.0..most)?;
    chart.configure_mesh().x_desc("payload, lb").y_desc("mm").draw()?;
    let points: Vec<(f64, f64)> = experiment.loads.iter().map(|p| (p.0, p.1 * 1e3)).collect();
    chart.draw_series(LineSeries::new(points.iter().copied(), BLUE))?;
    chart.draw_series(points.iter().map(|&p| Circle::new(p, 4, RED.filled())))?;
    root.present()?;
    Ok(())
}
