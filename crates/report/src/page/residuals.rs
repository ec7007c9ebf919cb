//! Residuals by axis, against every input, against the normal distribution, and the pose measurements with the largest errors.

use super::Page;
use super::rows::{Input, Rows, length};
use crate::figure::{Plot, bins, quantile, range, thin};
use crate::significant;

/// Points of a panel that are drawn.
const DRAWN: usize = 1500;
/// Columns of inputs beside each other.
const BESIDE: usize = 8;
/// Points, up to so many, that show their row and value where the pointer rests.
const NAMED: usize = 400;

impl Page {
    /// Statistics and pictures by axis.
    pub(crate) fn by_axis(&mut self, rows: &Rows, titles: [&str; 2]) {
        let axis = |list: &[[f64; 3]], k: usize| {
            list.iter().map(|v| v[k]).filter(|v| v.is_finite()).collect::<Vec<f64>>()
        };
        let mut table = Vec::new();
        for (k, name) in ["x", "y", "z"].iter().enumerate() {
            for (title, list) in rows.shown(titles) {
                let values = axis(list, k);
                if values.is_empty() {
                    continue;
                }
                let n = values.len() as f64;
                let mean = values.iter().sum::<f64>() / n;
                let rms = (values.iter().map(|v| v * v).sum::<f64>() / n).sqrt();
                let sizes: Vec<f64> = values.iter().map(|v| v.abs()).collect();
                let mut cells = vec![if rows.same { (*name).to_owned() } else { format!("{name}, {title}") }];
                let shown =
                    [mean, rms, quantile(sizes.clone(), 0.95), sizes.iter().copied().fold(0.0, f64::max)];
                // As many decimals as give the RMS three digits.
                let decimals =
                    if rms > 0.0 { (2.0 - rms.log10().floor()).clamp(0.0, 9.0) as usize } else { 3 };
                cells.extend(shown.map(|v| rounded(v, decimals)));
                table.push(cells);
            }
        }
        self.table(
            "Errors by axis over all rows, mm",
            &["axis", "mean", "RMS", "95th percentile", "largest"],
            &table,
            true,
        );
        self.raw("<div class=\"grid2\">");
        let sizes: Vec<f64> =
            (0..rows.len()).map(|k| largest(&rows.before[k]).max(largest(&rows.after[k]))).collect();
        let drawn = thin(&sizes, 2 * DRAWN, |_| false);
        for (k, name) in ["x", "y", "z"].iter().enumerate() {
            let values: Vec<f64> = axis(&rows.before, k).into_iter().chain(axis(&rows.after, k)).collect();
            let top = values.iter().map(|v| v.abs()).fold(0.0, f64::max);
            if values.is_empty() {
                continue;
            }
            let mut plot = Plot::new(340.0, 220.0, [1.0, rows.len() as f64], [-1.05 * top, 1.05 * top]).axes(
                &format!("error in {name}"),
                "row, in the order of the data",
                "mm",
            );
            let mut add = |class: &str, list: &[[f64; 3]]| {
                let place = |&r: &usize| (r as f64 + 1.0, list[r][k]);
                if drawn.len() > NAMED {
                    plot.dots(class, drawn.iter().map(place));
                    return;
                }
                plot.named_dots(
                    class,
                    drawn.iter().map(|r| {
                        let (x, y) = place(r);
                        (x, y, format!("row {}: {} mm", rows.row[*r] + 1, significant(y, 3)))
                    }),
                );
            };
            if !rows.same {
                add("before dots", &rows.before);
            }
            add("after dots", &rows.after);
            let about = format!("Errors in {name} of every row, before and after");
            self.figure(&format!("errors_{name}"), &plot.finish(&about), "");
        }
        self.raw("</div>");
        self.legend(rows, titles, drawn.len());
    }

    /// 3-D error against each input.
    pub(crate) fn against_inputs(&mut self, rows: &Rows, titles: [&str; 2]) {
        let before: Vec<f64> = rows.before.iter().map(length).collect();
        let after: Vec<f64> = rows.after.iter().map(length).collect();
        let sizes: Vec<f64> = before.iter().zip(&after).map(|(b, a)| 1e-3 * b + a).collect();
        let drawn = thin(&sizes, DRAWN, |_| false);
        let top = before.iter().chain(&after).copied().filter(|v| v.is_finite()).fold(1e-12, f64::max);
        self.raw("<div class=\"grid2\">");
        for (number, input) in (1..).zip(&rows.inputs) {
            let errors =
                [("before", &before), ("after", &after)].map(|(class, list)| (class, list.as_slice()));
            self.input(number, input, if rows.same { &errors[1..] } else { &errors }, top, &drawn);
        }
        self.raw("</div>");
        self.note("Lines: RMS in bins of equal width, dashed across bins without data. The residual of an adequate model shows no trend; a periodic pattern, a slope or a step indicates an \
             effect that the model lacks.");
        self.legend(rows, titles, drawn.len());
    }

    fn input(&mut self, number: usize, input: &Input, errors: &[(&str, &[f64])], top: f64, drawn: &[usize]) {
        let unit = if input.unit.is_empty() { String::new() } else { format!(", {}", input.unit) };
        let mut plot = Plot::new(340.0, 220.0, range(&input.values), [0.0, 1.05 * top]).axes(
            &format!("against {}", input.name),
            &format!("{}{unit}", input.name),
            "3-D error, mm",
        );
        for (class, list) in errors {
            plot.dots(&format!("{class} dots"), drawn.iter().map(|&r| (input.values[r], list[r])));
        }
        for (class, list) in errors {
            let squares: Vec<(f64, f64, f64)> = (0..list.len())
                .filter(|&r| input.values[r].is_finite())
                .map(|r| (input.values[r], list[r] * list[r], 1.0))
                .collect();
            let line: Vec<(f64, f64)> =
                bins(&squares, 16).iter().filter(|b| b.count > 1).map(|b| (b.x, b.y.sqrt())).collect();
            let [low, high] = range(&input.values);
            plot.line_over_data(&format!("{class} curve"), &line, 1.6 * (high - low) / 16.0);
        }
        let about = format!("3-D position errors against {}, before and after", input.name);
        self.figure(&format!("against_input_{number}"), &plot.finish(&about), "");
    }

    fn legend(&mut self, rows: &Rows, titles: [&str; 2], drawn: usize) {
        let thinned = if drawn < rows.len() {
            format!(" {drawn} of {} rows are drawn, including the 1 % with the largest errors.", rows.len())
        } else {
            String::new()
        };
        if rows.same {
            self.note(thinned.trim_start());
        } else {
            self.note(&format!("Orange: {}; blue: {}.{thinned}", titles[0], titles[1]));
        }
    }

    /// Components of the residual against the normal distribution; `sd` is the standard deviation that noise would have, mm.
    pub(crate) fn quantiles(&mut self, rows: &Rows, sd: f64) {
        let mut values: Vec<f64> = rows.after.iter().flatten().copied().filter(|v| v.is_finite()).collect();
        values.sort_by(f64::total_cmp);
        let n = values.len();
        if n < 5 {
            return;
        }
        // All of both tails, and the middle at equal steps.
        let step = (n / 400).max(1);
        let shown: Vec<(f64, f64)> = (0..n)
            .filter(|&k| k < 60 || k + 60 >= n || k % step == 0)
            .map(|k| (normal_quantile((k as f64 + 0.5) / n as f64), values[k]))
            .collect();
        let reach = shown.iter().map(|p| p.0.abs()).fold(0.0, f64::max);
        let top = values[n - 1].abs().max(values[0].abs()).max(sd * reach);
        let mut plot = Plot::new(420.0, 320.0, [-reach, reach], [-1.05 * top, 1.05 * top]).axes(
            "quantiles of the residual",
            "quantile of the normal distribution",
            "residual of a component, mm",
        );
        plot.line("ink thinline dash", &[(-reach, -reach * sd), (reach, reach * sd)]);
        plot.dots("after dots", shown.iter().copied());
        self.figure(
            "quantiles",
            &plot.finish("Quantiles of residual components against those of a normal distribution"),
            &format!(
                "Dashed: noise of {} mm per component. Tails above the line indicate outliers or a rare effect; a steeper slope indicates a residual \
                 above the noise.",
                significant(sd, 3)
            ),
        );
    }

    /// The pose measurements with the largest errors, with the inputs of their rows.
    pub(crate) fn largest_errors(&mut self, rows: &Rows, count: usize) {
        let mut order: Vec<usize> = (0..rows.len()).filter(|&k| length(&rows.after[k]).is_finite()).collect();
        order.sort_by(|&a, &b| length(&rows.after[b]).total_cmp(&length(&rows.after[a])).then(a.cmp(&b)));
        let mut seen: Vec<&str> = Vec::new();
        let mut largest = Vec::new();
        for k in order {
            if !seen.contains(&rows.visit[k].as_str()) {
                seen.push(&rows.visit[k]);
                largest.push(k);
            }
            if largest.len() == count {
                break;
            }
        }
        let mut head = vec![
            "pose measurement",
            "row",
            "line",
            "before, mm",
            "after, mm",
            "x, mm",
            "y, mm",
            "z, mm",
            "held out",
        ];
        head.retain(|head| !rows.same || *head != "before, mm");
        let row = |&k: &usize| {
            let error = length(&rows.after[k]);
            let mut cells = vec![
                rows.visit[k].clone(),
                (rows.row[k] + 1).to_string(),
                rows.line[k].map_or_else(|| "–".into(), |line| line.to_string()),
            ];
            if !rows.same {
                cells.push(significant(length(&rows.before[k]), 3));
            }
            cells.push(significant(error, 3));
            // Components with the decimals of the whole.
            let decimals = (2.0 - error.max(1e-9).log10().floor()).clamp(0.0, 9.0) as usize;
            cells.extend(rows.after[k].map(|v| rounded(v, decimals)));
            cells.push(if rows.held_out[k] { "yes" } else { "no" }.into());
            cells
        };
        let cells: Vec<Vec<String>> = largest.iter().map(row).collect();
        self.table("Pose measurements with the largest errors, with their components", &head, &cells, true);
        let names: Vec<String> = rows.inputs.iter().map(Input::title).collect();
        // As many inputs beside each other as a sheet is wide.
        for (part, names) in names.chunks(BESIDE).enumerate() {
            let mut head = vec!["row"];
            head.extend(names.iter().map(String::as_str));
            let inputs = rows.inputs.iter().skip(part * BESIDE).take(BESIDE);
            let row = |&k: &usize| {
                let mut cells = vec![(rows.row[k] + 1).to_string()];
                cells.extend(inputs.clone().map(|input| input.shown(k)));
                cells
            };
            self.table("Inputs of these rows", &head, &largest.iter().map(row).collect::<Vec<_>>(), true);
        }
    }
}

/// With so many decimals, and no minus before a zero.
fn rounded(value: f64, decimals: usize) -> String {
    let text = format!("{value:.decimals$}");
    let nothing = text.chars().all(|c| "-0.".contains(c));
    if nothing { text.trim_start_matches('-').into() } else { text }
}

/// Quantile of the standard normal distribution; relative error below 2e-9 (Acklam's rational functions).
fn normal_quantile(p: f64) -> f64 {
    const A: [f64; 6] = [
        -39.69683028665376,
        220.9460984245205,
        -275.9285104469687,
        138.357751867269,
        -30.66479806614716,
        2.506628277459239,
    ];
    const B: [f64; 5] =
        [-54.47609879822406, 161.5858368580409, -155.6989798598866, 66.80131188771972, -13.28068155288572];
    const C: [f64; 6] = [
        -7.784894002430293e-3,
        -0.3223964580411365,
        -2.400758277161838,
        -2.549732539343734,
        4.374664141464968,
        2.938163982698783,
    ];
    const D: [f64; 4] = [7.784695709041462e-3, 0.3224671290700398, 2.445134137142996, 3.754408661907416];
    let horner = |c: &[f64], x: f64| c.iter().fold(0.0, |sum, c| sum * x + c);
    let tail = |p: f64| {
        let q = (-2.0 * p.ln()).sqrt();
        horner(&C, q) / (horner(&D, q) * q + 1.0)
    };
    if p < 0.02425 {
        tail(p)
    } else if p > 1.0 - 0.02425 {
        -tail(1.0 - p)
    } else {
        let (q, r) = (p - 0.5, (p - 0.5).powi(2));
        horner(&A, r) * q / (horner(&B, r) * r + 1.0)
    }
}

fn largest(v: &[f64; 3]) -> f64 {
    v.iter().copied().filter(|x| x.is_finite()).map(f64::abs).fold(0.0, f64::max)
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn quantiles_of_the_normal_distribution() {
        for (p, z) in [
            (0.5, 0.0),
            (0.975, 1.959963985),
            (0.01, -2.326347874),
            (0.999, 3.090232306),
            (0.4, -0.253347103),
        ] {
            assert!((normal_quantile(p) - z).abs() < 1e-8, "{p}");
        }
    }
}
