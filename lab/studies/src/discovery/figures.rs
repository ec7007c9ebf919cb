//! A figure of each part, as SVG.

use super::hidden_effects::HiddenEffect;
use super::record::Record;
use super::summary::{confusion, first_p};
use crate::prelude::*;
use plotters::prelude::*;

/// The p of the nulls' first screens: their distribution against the straight line that it should be.
pub fn nulls(path: &Path, records: &[Record]) -> Outcome {
    let mut p: Vec<f64> = records.iter().filter(|r| r.ended()).map(first_p).collect();
    p.sort_by(f64::total_cmp);
    let root = SVGBackend::new(path, (600, 560)).into_drawing_area();
    root.fill(&WHITE)?;
    let mut chart = ChartBuilder::on(&root)
        .caption(format!("{} robots with nothing hidden", p.len()), ("sans-serif", 18))
        .margin(15)
        .x_label_area_size(40)
        .y_label_area_size(50)
        .build_cartesian_2d(0.0..1.0f64, 0.0..1.0f64)?;
    chart.configure_mesh().x_desc("family-wise p of the first screen").y_desc("share below").draw()?;
    chart.draw_series(LineSeries::new([(0.0, 0.0), (1.0, 1.0)], BLACK.mix(0.4)))?;
    let n = p.len().max(1) as f64;
    chart.draw_series(LineSeries::new(p.iter().enumerate().map(|(k, &p)| (p, (k + 1) as f64 / n)), BLUE))?;
    root.present()?;
    Ok(())
}

/// Share found with the right name and place against the size, one small chart a cause.
pub fn power(path: &Path, records: &[Record], multiples: &[f64]) -> Outcome {
    const COLUMNS: usize = 5;
    let root = SVGBackend::new(path, (1250, 1000)).into_drawing_area();
    root.fill(&WHITE)?;
    let areas = root.split_evenly((HiddenEffect::all().len().div_ceil(COLUMNS), COLUMNS));
    let (first, last) = (multiples.first().copied().unwrap_or(0.5), multiples.last().copied().unwrap_or(8.0));
    for (word, area) in HiddenEffect::all().iter().map(Word::word).zip(&areas) {
        let share = |m: f64, of: fn(&Record) -> bool| {
            let here: Vec<&Record> = records
                .iter()
                .filter(|r| r.cause == word && r.ended() && (r.multiple - m).abs() < 1e-9)
                .collect();
            let count = here.iter().filter(|r| of(r)).count();
            (!here.is_empty()).then(|| (m.log2(), count as f64 / here.len() as f64))
        };
        let line = |of: fn(&Record) -> bool| -> Vec<(f64, f64)> {
            multiples.iter().filter_map(|&m| share(m, of)).collect()
        };
        let mut chart = ChartBuilder::on(area)
            .caption(&word, ("sans-serif", 15))
            .margin(8)
            .x_label_area_size(25)
            .y_label_area_size(35)
            .build_cartesian_2d(first.log2() - 0.2..last.log2() + 0.2, -0.03..1.03f64)?;
        chart.configure_mesh().x_labels(5).x_label_formatter(&|x| format!("{}", x.exp2())).draw()?;
        chart.draw_series(LineSeries::new(line(|r| r.findings > 0), BLACK.mix(0.4)))?;
        let right = line(|r| r.found);
        chart.draw_series(right.iter().map(|&at| Circle::new(at, 3, BLUE.filled())))?;
        chart.draw_series(LineSeries::new(right, BLUE.stroke_width(2)))?;
    }
    root.present()?;
    Ok(())
}

/// What is hidden against what is named first.
pub fn matrix(path: &Path, records: &[Record]) -> Outcome {
    let counts = confusion(records);
    let mut names: Vec<&str> = counts.keys().map(|(_, first)| first.as_str()).collect();
    names.sort_unstable();
    names.dedup();
    let named = |word: &String| counts.keys().any(|(cause, _)| cause == word);
    let rows: Vec<String> = HiddenEffect::all().iter().map(Word::word).filter(named).collect();
    let (left, top, cell) = (150, 130, 44);
    let size = (left + cell * names.len() as i32 + 20, top + cell * rows.len() as i32 + 20);
    let root = SVGBackend::new(path, (size.0 as u32, size.1 as u32)).into_drawing_area();
    root.fill(&WHITE)?;
    let title = "hidden (rows) and named first (columns), 2 and more × the detectable size";
    root.draw(&Text::new(title, (10, 8), ("sans-serif", 15)))?;
    for (k, name) in names.iter().enumerate() {
        let style = ("sans-serif", 13).into_text_style(&root).transform(FontTransform::Rotate270);
        root.draw(&Text::new(*name, (left + cell * k as i32 + 14, top - 8), style))?;
    }
    for (row, word) in rows.iter().enumerate() {
        let y = top + cell * row as i32;
        root.draw(&Text::new(word.as_str(), (10, y + 15), ("sans-serif", 13)))?;
        let all: usize = counts.iter().filter(|((cause, _), _)| cause == word).map(|(_, n)| n).sum();
        for (k, name) in names.iter().enumerate() {
            let x = left + cell * k as i32;
            let n = counts.get(&(word.clone(), (*name).to_owned())).copied().unwrap_or(0);
            let share = n as f64 / all.max(1) as f64;
            root.draw(&Rectangle::new(
                [(x, y), (x + cell - 2, y + cell - 2)],
                BLUE.mix(0.08 + 0.8 * share).filled(),
            ))?;
            if n > 0 {
                let colour = if share > 0.6 { &WHITE } else { &BLACK };
                root.draw(&Text::new(
                    n.to_string(),
                    (x + 14, y + 14),
                    ("sans-serif", 14).into_font().color(colour),
                ))?;
            }
        }
    }
    root.present()?;
    Ok(())
}

/// Errors of parameters in half widths of their intervals, by size: 95 % should lie between the lines.
pub fn coverage(path: &Path, records: &[Record]) -> Outcome {
    let root = SVGBackend::new(path, (800, 450)).into_drawing_area();
    root.fill(&WHITE)?;
    let mut chart = ChartBuilder::on(&root)
        .caption("errors of the parameters over half their 95 % intervals", ("sans-serif", 18))
        .margin(15)
        .x_label_area_size(40)
        .y_label_area_size(50)
        .build_cartesian_2d(-1.5..3.5f64, -4.0..4.0f64)?;
    chart
        .configure_mesh()
        .x_desc("multiple of the detectable size")
        .x_label_formatter(&|x| format!("{}", x.exp2()))
        .draw()?;
    for edge in [-1.0, 1.0] {
        chart.draw_series(LineSeries::new([(-1.5, edge), (3.5, edge)], BLACK.mix(0.5)))?;
    }
    let points = records.iter().flat_map(|r| {
        r.intervals.iter().filter(|i| !i.empty()).enumerate().map(move |(k, i)| {
            let aside = 0.3 * (((r.seed * 7 + k as u64) % 11) as f64 / 11.0 - 0.5);
            let half = 0.5 * (i.ci95[1] - i.ci95[0]);
            (r.multiple.log2() + aside, ((i.value - i.truth) / half).clamp(-4.0, 4.0))
        })
    });
    chart.draw_series(points.map(|at| Circle::new(at, 3, BLUE.mix(0.6).filled())))?;
    root.present()?;
    Ok(())
}
