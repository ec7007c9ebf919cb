//! Errors over the robot's joints: a chart over the two joints that explain most of their variance.
//!
//! ```text
//! η²_adj = 1 − [Σ_c Σ_{i∈c} (e_i − ē_c)² / (n − C)] / [Σ_i (e_i − ē)² / (n − 1)]
//! ```
//!
//! | symbol | here | unit |
//! | --- | --- | --- |
//! | e_i | 3-D error of row i | mm |
//! | c, C | a cell of the chart with two rows or more; their number | 1 |
//! | η²_adj | fraction of the error's variance between cells, corrected for their number | 1 |
//!
//! Source: the adjusted correlation ratio (Kelley 1935).

use super::Page;
use super::rows::{Input, Rows, length};
use crate::figure::{Chart, cell, cells_for, chart, range};
use crate::significant;

impl Page {
    /// The part, where two joints moved.
    pub(crate) fn joint_space(&mut self, rows: &Rows, titles: [&str; 2]) {
        let errors: Vec<f64> = rows.before.iter().map(length).collect();
        let joints: Vec<&Input> = rows.inputs.iter().take(rows.joints).collect();
        let cells = cells_for(rows.len());
        let pairs = (0..joints.len()).flat_map(|b| (0..b).map(move |a| (a, b)));
        let judged = pairs.filter_map(|(a, b)| {
            Some((between(&joints[a].values, &joints[b].values, &errors, cells)?, joints[a], joints[b]))
        });
        let Some((fraction, across, up)) = judged.max_by(|a, b| a.0.total_cmp(&b.0)) else { return };
        self.title("Position errors over joint values");
        let left: Vec<f64> = rows.after.iter().map(length).collect();
        let charts = [&errors, &left].map(|list| Chart::rms(&across.values, &up.values, list, cells));
        let most = charts[0].most().max(charts[1].most());
        let names = [across, up].map(|joint| format!("{}, {}", joint.name, joint.unit));
        let one = |k: usize, class: &str| {
            let about = format!(
                "RMS of the 3-D error over {} and {}, {}: largest {} mm",
                across.name,
                up.name,
                titles[k],
                significant(charts[k].most(), 3)
            );
            chart(&about, titles[k], [&names[0], &names[1]], &charts[k], most, class)
        };
        let mut caption = format!(
            "RMS of the 3-D position error in {cells} × {cells} cells over {} and {}, {}; cells without a measurement stay empty.",
            across.name,
            up.name,
            if joints.len() > 2 {
                "the pair of joints that explains most of the variance of the error"
            } else {
                "the joints that moved"
            }
        );
        if rows.same {
            self.figure("over_joints", &one(0, "bar-after"), &caption);
            return;
        }
        caption += &format!(
            " The cells explain {} % of the variance of the error on the left; the residual of an adequate model is the same in all cells.",
            significant(100.0 * fraction.max(0.0), 2)
        );
        let both = [one(0, "bar-before"), one(1, "bar-after")];
        self.figures("over_joints", &both, &caption);
    }
}

/// η²_adj of the errors over the cells of two inputs; none where the inputs or the errors do not vary, or no cell has two rows.
fn between(x: &[f64], y: &[f64], errors: &[f64], along: usize) -> Option<f64> {
    let (range_x, range_y) = (range(x), range(y));
    let mut cells = vec![(0.0, 0.0, 0usize); along * along];
    for ((&x, &y), &e) in x.iter().zip(y).zip(errors).filter(|(_, e)| e.is_finite()) {
        let at = &mut cells[cell(y, range_y, along)? * along + cell(x, range_x, along)?];
        *at = (at.0 + e, at.1 + e * e, at.2 + 1);
    }
    cells.retain(|c| c.2 > 1);
    let (sum, square, n) = cells.iter().fold((0.0, 0.0, 0usize), |t, c| (t.0 + c.0, t.1 + c.1, t.2 + c.2));
    if n <= cells.len() || cells.is_empty() {
        return None;
    }
    let within: f64 = cells.iter().map(|c| c.1 - c.0 * c.0 / c.2 as f64).sum();
    let whole = square - sum * sum / n as f64;
    let fraction = 1.0 - (within / (n - cells.len()) as f64) / (whole / (n - 1) as f64);
    fraction.is_finite().then_some(fraction)
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn dependence_on_two_inputs_is_distinguished_from_noise() {
        let x: Vec<f64> = (0..900).map(|k| f64::from(k % 30)).collect();
        let y: Vec<f64> = (0..900).map(|k| f64::from(k / 30)).collect();
        let scatter = |k: usize| f64::from(u32::try_from(k * 7919 % 101).unwrap_or(0)) / 100.0;
        let follows: Vec<f64> = (0..900).map(|k| x[k] * y[k] / 100.0 + 0.01 * scatter(k)).collect();
        let alone: Vec<f64> = (0..900).map(scatter).collect();
        assert!(between(&x, &y, &follows, 12).is_some_and(|fraction| fraction > 0.9));
        assert!(between(&x, &y, &alone, 12).is_some_and(|fraction| fraction < 0.2));
        assert_eq!(between(&x, &vec![1.0; 900], &follows, 12), None);
    }
}
