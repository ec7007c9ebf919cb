//! Figures of the study: error against condition, noise, outliers and rows, one line a strategy.

use super::record::Record;
use crate::prelude::*;
use plotters::prelude::*;

/// A number of a record.
type Of = fn(&Record) -> f64;

/// A figure: file, sweep, what runs along each axis.
struct Figure {
    file: &'static str,
    sweep: &'static str,
    across: (&'static str, Of),
    up: (&'static str, Of),
}

const fn figure(
    file: &'static str,
    sweep: &'static str,
    across: (&'static str, Of),
    up: (&'static str, Of),
) -> Figure {
    Figure { file, sweep, across, up }
}

const HELD_OUT: (&str, Of) = ("held-out error / oracle", Record::ratio);
const PARAMETERS: (&str, Of) = ("parameter error in expected sizes", |r| r.parameters);
const SECONDS: (&str, Of) = ("time of one solve, s", |r| r.seconds);
const CONDITION: (&str, Of) = ("condition number", |r| r.condition);
const ROWS: (&str, Of) = ("rows", |r| r.rows);

const FIGURES: [Figure; 6] = [
    figure("condition_held_out.svg", "condition", CONDITION, HELD_OUT),
    figure("condition_parameters.svg", "condition", CONDITION, PARAMETERS),
    figure("noise_parameters.svg", "noise", ("noise / signal", |r| r.noise), PARAMETERS),
    figure(
        "outliers_held_out.svg",
        "outliers",
        ("share of wrong visits, % + 1", |r| 100.0 * r.outliers + 1.0),
        HELD_OUT,
    ),
    figure("rows_held_out.svg", "rows", ROWS, HELD_OUT),
    figure("rows_time.svg", "rows", ROWS, SECONDS),
];

/// Draws all of them.
pub fn draw(folder: &Path, records: &[Record]) -> Outcome {
    FIGURES.iter().try_for_each(|figure| figure.draw(folder, records))
}

impl Figure {
    fn draw(&self, folder: &Path, records: &[Record]) -> Outcome {
        let lines = self.lines(records);
        let points = || lines.iter().flat_map(|line| &line.1);
        let ends = |of: fn(&(f64, f64)) -> f64| {
            let values = || points().map(of);
            (values().fold(f64::INFINITY, f64::min), values().fold(0.0, f64::max))
        };
        let ((left, right), (low, high)) = (ends(|p| p.0), ends(|p| p.1));
        let path = folder.join(self.file);
        let root = SVGBackend::new(&path, (1000, 600)).into_drawing_area();
        root.fill(&WHITE)?;
        let mut chart = ChartBuilder::on(&root)
            .caption(format!("{} against {}", self.up.0, self.across.0), ("sans-serif", 18))
            .margin(15)
            .margin_right(170)
            .x_label_area_size(40)
            .y_label_area_size(70)
            .build_cartesian_2d((left..right * 1.05).log_scale(), (low * 0.9..high * 1.1).log_scale())?;
        chart.configure_mesh().x_desc(self.across.0).y_desc(self.up.0).draw()?;
        for (k, (solver, line)) in lines.iter().enumerate() {
            let colour = Palette99::pick(k).to_rgba();
            chart.draw_series(LineSeries::new(line.iter().copied(), colour.stroke_width(2)))?;
            chart.draw_series(line.iter().map(|&p| Circle::new(p, 3, colour.filled())))?;
            let at = (840, 60 + 24 * k as i32);
            let style = TextStyle::from(("sans-serif", 15).into_font()).color(&colour);
            root.draw_text(solver, &style, at)?;
        }
        root.present()?;
        Ok(())
    }

    /// Medians over the seeds; strategies in the order of the records.
    fn lines(&self, records: &[Record]) -> Vec<(String, Vec<(f64, f64)>)> {
        let mine: Vec<&Record> = records.iter().filter(|r| r.sweep == self.sweep).collect();
        let mut solvers: Vec<&str> = Vec::new();
        mine.iter().for_each(|r| {
            if !solvers.contains(&r.solver.as_str()) {
                solvers.push(&r.solver)
            }
        });
        let mut places: Vec<f64> = mine.iter().map(|r| self.across.1(r)).collect();
        places.sort_by(f64::total_cmp);
        places.dedup_by(|a, b| a.total_cmp(b).is_eq());
        let point = |solver: &str, at: f64| {
            let here = mine.iter().filter(|r| r.solver == solver && self.across.1(r).total_cmp(&at).is_eq());
            let value = quantile(here.map(|r| self.up.1(r)), 0.5);
            (value > 0.0).then_some((at, value))
        };
        solvers
            .iter()
            .map(|s| ((*s).to_owned(), places.iter().filter_map(|&at| point(s, at)).collect()))
            .collect()
    }
}
