//! Lack of fit against the pure error of repeated pose measurements.
//!
//! | symbol | here | unit |
//! | --- | --- | --- |
//! | b_v = Σ_i r_vi / √n_v | what the n_v rows of a pose measurement share, an axis at a time | m |
//! | SS_b = Σ_v b_v², SS_w = Σ_vi (r_vi − r̄_v)² | residual squares between and within pose measurements | m² |
//! | f_b, f_w | [`Freedom`]: what the unknowns leave of either, less the shape parameters | 1 |
//! | σ²_b, σ²_w | the same variances from repeats ([`PureError`]) | m² |
//!
//! ```text
//! F_b = (SS_b/f_b)/σ²_b,   F_w = (SS_w/f_w)/σ²_w,   p = 1 − (1 − min(p_b, p_w))²
//! ```
//!
//! The two strata are tested apart: a missing effect moves all rows of a pose measurement together, and beside the noise of single rows it would be
//! lost. Degrees of freedom are effective ones: neither axes nor targets are independent.
//!
//! Source: Fisher's lack-of-fit test, as in Draper and Smith, *Applied Regression Analysis*, 3rd ed., §2.1; strata: Searle, Casella and McCulloch
//! 1992, ch. 4. Pose measurements that came from different sides of approach are repeats of each other: so backlash counts as lack of fit when both
//! sides stand in the model's data, and as pure error when it is ignored; `one_sided` says which repeats there are.

use crate::numbers::Numbers;
use crate::pure_error::{PureError, Stratum};
use crate::repeat_groups::exact_repeats;
use crate::{Fit, Freedom};
use serde::{Deserialize, Serialize};
use statrs::distribution::{ContinuousCDF, FisherSnedecor};
use truepose_errormodel::{Dataset, Visits};

/// Degrees of freedom within pose measurements below which nothing is tested there: two differences in space.
const LEAST_WITHIN: f64 = 6.0;

/// What repeated pose measurements say.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
pub struct Repeats {
    /// Configurations that were measured more than once.
    pub groups: usize,
    /// Effective degrees of freedom of the pure error.
    pub freedom: usize,
    /// RMS of one row around its expectation over the components that were measured, m.
    pub rms: f64,
    /// Whether all repeats of a configuration came with the same directions of approach.
    pub one_sided: bool,
    /// Lack of fit of the model, where it has degrees of freedom.
    pub lack_of_fit: Option<LackOfFit>,
}

/// Lack of fit against the pure error.
#[derive(Debug, Clone, Copy, PartialEq, Serialize, Deserialize)]
pub struct LackOfFit {
    /// F statistic of the stratum with the smaller p.
    pub f: f64,
    /// Degrees of freedom of its numerator.
    pub freedom: usize,
    /// Probability of so large an F when nothing is missing.
    pub p_value: f64,
}

/// Residual variance of a model, with what its unknowns took from it given back.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct ResidualVariance {
    /// RMS of one row over the components that were measured, m: √3 times the root of the variance of an axis where all three were.
    pub rms: f64,
    /// Effective degrees of freedom of its square.
    pub freedom: f64,
    /// (variance of an axis, degrees of freedom) between pose measurements, m².
    between: (f64, f64),
    /// The same within them; none where each has one row.
    within: Option<(f64, f64)>,
}

impl ResidualVariance {
    /// Of a fit on its data; `None` where no position was measured or nothing is left to scatter.
    pub fn of(fit: &Fit, data: &Dataset) -> Option<Self> {
        let visits = Visits::of(data);
        let all = Freedom::all(data, &visits);
        let left = Freedom::of(fit, data).unwrap_or_else(|_| {
            all.share((1.0 - fit.reduction.rank() as f64 / all.positions().max(1.0)).max(0.02))
        });
        let numbers = Numbers::new(&fit.residuals, data);
        let (mut between, mut within) = (0.0, 0.0);
        for rows in &visits.rows {
            for axis in 0..3 {
                let values = rows.iter().filter_map(|&row| Some(numbers.of(row)?[axis]));
                let (mut sum, mut squares, mut n) = (0.0, 0.0, 0.0);
                values.filter(|v| !v.is_nan()).for_each(|v| {
                    (sum, squares, n) = (sum + v, squares + v * v, n + 1.0);
                });
                if n > 0.0 {
                    between += sum * sum / n;
                    within += (squares - sum * sum / n).max(0.0);
                }
            }
        }
        let freedom = left.between - fit.shapes.len() as f64;
        if freedom < 1.0 || between + within <= 0.0 {
            return None;
        }
        let between = (between / freedom, freedom);
        let within = (all.within >= 1.0 && left.within > 0.0).then(|| (within / left.within, left.within));
        let per_row = Numbers::per_row(data);
        let (variance, numbers) = within.map_or((0.0, 0.0), |(v, _)| (v * all.within, all.within));
        let square = per_row * (between.0 * all.between + variance) / (all.between + numbers);
        // Satterthwaite, of the sum of the strata.
        let part = |(variance, freedom): (f64, f64), numbers: f64| (variance * numbers).powi(2) / freedom;
        let spread = part(between, all.between) + within.map_or(0.0, |w| part(w, all.within));
        let freedom = (square / per_row * (all.between + numbers)).powi(2) / spread.max(f64::MIN_POSITIVE);
        Some(ResidualVariance { rms: square.sqrt(), freedom, between, within })
    }

    /// Lack of fit against pure error.
    pub fn lack_of_fit(&self, pure: &PureError) -> LackOfFit {
        let test = |(variance, freedom): (f64, f64), noise: &Stratum| {
            let f = variance / noise.variance.max(f64::MIN_POSITIVE);
            let freedom = (freedom * noise.axes / 3.0).max(1.0);
            let p_value = FisherSnedecor::new(freedom, noise.freedom).map_or(1.0, |d| d.sf(f));
            LackOfFit { f, freedom: freedom.round() as usize, p_value }
        };
        let between = test(self.between, &pure.between);
        let enough =
            |(noise, own): &(&Stratum, (f64, f64))| noise.freedom >= LEAST_WITHIN && own.1 >= LEAST_WITHIN;
        let Some((noise, own)) = pure.within.as_ref().zip(self.within).filter(enough) else {
            return between;
        };
        let within = test(own, noise);
        let first = if within.p_value < between.p_value { within } else { between };
        // The strata are independent. Written so that small p keep their digits.
        LackOfFit { p_value: first.p_value * (2.0 - first.p_value), ..first }
    }
}

/// Pure error of repeated configurations and lack of fit of the model; none when no configuration was measured twice.
pub fn repeats(fit: &Fit, data: &Dataset) -> Option<Repeats> {
    let pure = PureError::of(&fit.residuals, data, &exact_repeats(data))?;
    Some(Repeats {
        groups: pure.groups,
        freedom: pure.freedom.round() as usize,
        rms: pure.rms,
        one_sided: pure.one_sided,
        lack_of_fit: ResidualVariance::of(fit, data).map(|residual| residual.lack_of_fit(&pure)),
    })
}
