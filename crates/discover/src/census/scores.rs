//! The screen of a sample with the scores of all rows.
//!
//! X̃ᵀr = Xᵀr, since the fit of all rows leaves nothing of r along the model: a candidate costs its entries times `J̃ᵀr` of each visit, a set
//! of functions at all sites one product a block, and all periods of a joint one sum a visit ([`crate::census::waves`]).

use crate::census::all_rows::AllRows;
use crate::census::blocks::Blocks;
use crate::census::seen::Seen;
use crate::census::waves::MotionBins;
use crate::census::white::White;
use crate::error::DiscoverError;
use crate::hypotheses::candidate::Candidate;
use crate::hypotheses::change::Change;
use crate::options::DiscoverOptions;
use crate::problem::emitted::{Emitted, Said};
use crate::problem::linearisation::Linearisation;
use crate::screen::candidates::Screen;
use crate::screen::functions::Functions;
use crate::statistics::beta::surprisal;
use nalgebra::{DMatrix, DVector, DVectorView};
use std::ops::Range;
use truepose_errormodel::Dataset;

/// Xᵀr of everything that a screen looks at.
struct Scores {
    /// Of candidates that are taken for themselves, by their number.
    single: Vec<Option<DVector<f64>>>,
    /// Of functions (rows) at sites (columns).
    functions: DMatrix<f64>,
    /// Of the own motion of joints.
    motions: Vec<MotionBins>,
}

/// Puts the scores of all rows in the place of those of the sample.
pub(crate) fn screened(
    screen: &mut Screen,
    sample: &Linearisation<'_>,
    (all, blocks): (&AllRows, &Blocks),
    options: &DiscoverOptions,
) -> Result<(), DiscoverError> {
    let scores = scores(screen, sample, (all, blocks), options)?;
    let rows = all.count as f64;
    // T makes the columns of the sample orthonormal: those of all rows are longer.
    let shorter = sample.len() as f64 / rows;
    let freedom = all.count.saturating_sub(all.inverse.nrows());
    let judged = |basis: &DMatrix<f32>, score: &DVector<f64>| -> (f64, f64) {
        let explained = basis.map(f64::from).tr_mul(score).norm_squared() * shorter;
        let fraction = (explained / all.squares).min(1.0 - 1e-12);
        (-rows * (1.0 - fraction).ln(), surprisal(fraction, basis.ncols(), freedom))
    };
    for k in 0..screen.candidates.len() {
        let candidate = &screen.candidates[k].candidate;
        let at_site = screen.functions().and_then(|f| f.scores_at(sample, candidate, &scores.functions));
        let own = at_site.or_else(|| scores.single[k].clone());
        if let Some(score) = &mut screen.candidates[k].score {
            (score.gain, score.surprisal) = match &own {
                Some(own) if own.len() == score.basis.nrows() => judged(&score.basis, own),
                // Another load, of which the search has seen as much as there is to see.
                _ => (0.0, 0.0),
            };
        }
    }
    for (wave, bins) in screen.periods.iter_mut().zip(&scores.motions) {
        let sums = bins.waves(&wave.periods);
        wave.rejudge(|k, basis| judged(basis, &DVector::from_column_slice(&sums[k])));
    }
    Ok(())
}

/// Whether a candidate is taken for itself.
fn is_single(functions: Option<&Functions>, sample: &Linearisation<'_>, candidate: &Candidate) -> bool {
    matches!(candidate.change, Change::Add(_)) && functions.and_then(|f| f.place(sample, candidate)).is_none()
}

fn scores(
    screen: &Screen,
    sample: &Linearisation<'_>,
    (all, blocks): (&AllRows, &Blocks),
    options: &DiscoverOptions,
) -> Result<Scores, DiscoverError> {
    let functions = screen.functions();
    let effects = screen.candidates.iter().flat_map(|screened| screened.candidate.effects().iter());
    let derived = blocks.derived(&all.fit, effects);
    let first = blocks.first(&derived);
    // What nothing is left of in the sample, or what the data lacks a covariate for, has no score.
    let single: Vec<(usize, &Candidate)> = screen
        .candidates
        .iter()
        .enumerate()
        .filter(|(_, screened)| screened.score.is_some())
        .map(|(k, screened)| (k, &*screened.candidate))
        .filter(|(_, candidate)| is_single(functions, sample, candidate))
        .filter(|(_, candidate)| White::width_of(candidate, &all.at, &first).is_some())
        .collect();
    let asked = Emitted::all(&all.at, &single, |(_, candidate)| candidate.effects())?;
    let of_functions =
        Emitted::all(&all.at, functions.map_or(&[][..], Functions::effects), std::slice::from_ref)?;
    let chain = sample.chain();
    let motions: Vec<_> = screen.periods.iter().map(|wave| (wave.joint, wave.shares())).collect();
    let empty: Vec<MotionBins> = screen
        .periods
        .iter()
        .map(|wave| {
            let column = chain.coordinate(wave.joint).map_or(&[][..], |k| &blocks.data().joints[k]);
            let ends =
                column.iter().fold([f64::INFINITY, f64::NEG_INFINITY], |[a, b], &q| [a.min(q), b.max(q)]);
            MotionBins::new(ends, wave.periods.last().copied().unwrap_or(1.0))
        })
        .collect();
    let of = |block: &Dataset| -> Result<Scores, DiscoverError> {
        let seen = Seen::of((block, blocks), all, options)?;
        let scores = seen.scores();
        // Φᵀc of some visits.
        let along = |one: &Said<'_>, site: usize, visits: &Range<usize>| {
            let values = DVectorView::from_slice(one.values, one.values.len());
            one.factor * values.dot(&scores.column(site).rows_range(visits.clone()))
        };
        let mut sums = vec![None; screen.candidates.len()];
        for (part, asked) in &asked {
            let mut sum = vec![0.0; asked.width()];
            asked.each(block, &seen.rows, &mut |said| {
                for one in &said.beside {
                    sum[one.column] += along(one, one.site, &said.visits);
                }
            })?;
            let mut first = 0;
            for (k, candidate) in *part {
                let end = first + candidate.effects().len();
                sums[*k] = Some(DVector::from_column_slice(&sum[asked.columns_of(first..end)]));
                first = end;
            }
        }
        let mut at_sites =
            DMatrix::zeros(of_functions.iter().map(|(_, asked)| asked.width()).sum(), seen.sites);
        let mut first = 0;
        for (_, asked) in &of_functions {
            asked.each(block, &seen.rows, &mut |said| {
                for one in &said.beside {
                    for site in 0..seen.sites {
                        at_sites[(first + one.column, site)] += along(one, site, &said.visits);
                    }
                }
            })?;
            first += asked.width();
        }
        let mut bins = empty.clone();
        for ((joint, shares), bins) in motions.iter().zip(&mut bins) {
            let Some(column) = chain.coordinate(*joint) else { continue };
            for (visit, &row) in seen.rows.iter().enumerate() {
                let score = shares.iter().map(|&(site, share)| share * scores[(visit, site)]).sum();
                bins.add(block.joints[column][row], score);
            }
        }
        Ok(Scores { single: sums, functions: at_sites, motions: bins })
    };
    let mut whole: Option<Scores> = None;
    blocks.each(1, &derived, &of, &mut |_, part| match &mut whole {
        None => whole = Some(part),
        Some(whole) => {
            for (sum, more) in whole.single.iter_mut().flatten().zip(part.single.into_iter().flatten()) {
                *sum += more;
            }
            whole.functions += part.functions;
            whole.motions.iter_mut().zip(&part.motions).for_each(|(sum, more)| sum.merge(more));
        }
    })?;
    Ok(whole.unwrap_or(Scores {
        single: vec![None; screen.candidates.len()],
        functions: DMatrix::zeros(0, 0),
        motions: empty,
    }))
}
