//! The many candidates that are a function of the visit at one site: functions are taken once, and all of a site go through the
//! model together.

use crate::error::DiscoverError;
use crate::hypotheses::candidate::Candidate;
use crate::hypotheses::series::{Series, functions, series};
use crate::problem::linearisation::Linearisation;
use crate::problem::projection::{Projection, Score};
use crate::problem::tables::UnitResponse;
use crate::screen::screened::Screened;
use crate::significance::rotation::{Largest, Rotations};
use nalgebra::{DMatrix, DVector};
use rayon::prelude::*;
use std::ops::Range;
use truepose_errormodel::AnyEffect;
use truepose_errormodel::effects::Factor;
use truepose_kinematics::{Axis, FrameId, Site};

/// Sets of functions of the visit, with the scores of each at every component of every frame.
pub(crate) struct Functions {
    sets: Vec<(Vec<Factor>, Range<usize>)>,
    /// By frame, then by set.
    scores: Vec<Vec<AtFrame>>,
    /// The sites of each frame's components.
    sites: Vec<[usize; 6]>,
    /// Of every visit, visits × functions.
    values: DMatrix<f32>,
    /// All functions, side by side.
    effects: Vec<Box<dyn AnyEffect>>,
}

/// Scores of one set of functions at one frame, of the components that a candidate has.
struct AtFrame {
    /// At each component alone.
    single: [Option<Score>; 6],
    /// At all of them together.
    all: Option<Option<Score>>,
}

/// The unit response of a component, with Q_1ᵀX and Xᵀr̃ of all functions.
type Through = (UnitResponse, (DMatrix<f64>, DVector<f64>));

/// At which components of a frame the candidates have a set of functions.
#[derive(Debug, Clone, Copy, Default)]
struct Wanted {
    single: [bool; 6],
    all: bool,
}

impl Functions {
    /// Of all candidates that have this form.
    pub fn new(
        linearisation: &Linearisation<'_>,
        projection: &Projection,
        candidates: &[Candidate],
    ) -> Result<Self, DiscoverError> {
        let chain = linearisation.chain();
        let frames: Vec<FrameId> = chain.frames().collect();
        let mut sets: Vec<(Vec<Factor>, Range<usize>)> = Vec::new();
        let mut effects: Vec<Box<dyn AnyEffect>> = Vec::new();
        // By set, then by frame.
        let mut wanted: Vec<Vec<Wanted>> = Vec::new();
        let mut width = 0;
        for Series { factors, frame, components } in candidates.iter().filter_map(series) {
            let known = position(&sets, factors);
            let set = known.unwrap_or(sets.len());
            if known.is_none() {
                let one = functions(factors);
                let count = one.columns(chain).len();
                sets.push((factors.to_vec(), width..width + count));
                wanted.push(vec![Wanted::default(); frames.len()]);
                effects.push(one);
                width += count;
            }
            let Some(at) = frames.iter().position(|&known| known == frame) else { continue };
            match components {
                [axis] => wanted[set][at].single[index(*axis)] = true,
                _ => wanted[set][at].all = true,
            }
        }
        let tables = projection.tables(linearisation);
        let values = evaluated(linearisation, &effects, &tables.stations)?;
        // The functions are those of a displacement of the base: a rotation's expected size is that over the length of the robot.
        let length = chain.characteristic_length();
        let turned = Axis::ALL.map(|axis| if axis.is_rotation() { 1.0 / length } else { 1.0 });
        let sites: Vec<[usize; 6]> = frames
            .iter()
            .map(|&frame| Axis::ALL.map(|axis| chain.site_index(Site::Frame(frame, axis))))
            .collect();
        let scores = sites
            .par_iter()
            .enumerate()
            .map(|(at, sites)| {
                let of_frame = || wanted.iter().map(|by_frame| &by_frame[at]);
                // Unit responses of the components that a candidate has, with the products of all functions.
                let unit: [Option<Through>; 6] = std::array::from_fn(|k| {
                    of_frame().any(|wanted| wanted.all || wanted.single[k]).then(|| {
                        let response = tables.unit_response(&projection.q, &[(sites[k], turned[k])]);
                        let through = response.through(&values);
                        (response, through)
                    })
                });
                let score = |own: &Range<usize>, wanted: &Wanted| {
                    let (first, count) = (own.start, own.len());
                    let single = std::array::from_fn(|k| {
                        let (response, (along, score)) = unit[k].as_ref().filter(|_| wanted.single[k])?;
                        let raw = response.products(&values.columns(first, count));
                        let score = score.rows(first, count).into_owned();
                        let score = projection.judged(&raw, &along.columns(first, count), &score)?;
                        Some(of_functions(score, &[turned[k]]))
                    });
                    let all = wanted.all.then(|| {
                        let functions = values.columns(first, count).into_owned();
                        let each: [(usize, f64); 6] = std::array::from_fn(|k| (sites[k], turned[k]));
                        let raw = tables.products(&each, &functions);
                        let mut along = DMatrix::zeros(projection.q.ncols(), 6 * count);
                        let mut score = DVector::zeros(6 * count);
                        for (k, (_, (all, scores))) in
                            unit.iter().enumerate().filter_map(|(k, u)| Some((k, u.as_ref()?)))
                        {
                            along.columns_mut(k * count, count).copy_from(&all.columns(first, count));
                            score.rows_mut(k * count, count).copy_from(&scores.rows(first, count));
                        }
                        let score = projection.judged(&raw, &along, &score)?;
                        Some(of_functions(score, &turned))
                    });
                    AtFrame { single, all }
                };
                sets.iter().zip(of_frame()).map(|((_, own), wanted)| score(own, wanted)).collect()
            })
            .collect();
        Ok(Functions { sets, scores, sites, values: values.map(|v| v as f32), effects })
    }

    /// All functions, side by side, each as one component of the base emits it.
    pub fn effects(&self) -> &[Box<dyn AnyEffect>] {
        &self.effects
    }

    /// Of these scores, functions × sites, those of a candidate; none when it has another form.
    pub fn scores_at(
        &self,
        linearisation: &Linearisation<'_>,
        candidate: &Candidate,
        scores: &DMatrix<f64>,
    ) -> Option<DVector<f64>> {
        let (frame, set, component) = self.place(linearisation, candidate)?;
        let own = &self.sets[set].1;
        let at = |k: usize| scores.column(self.sites[frame][k]).rows(own.start, own.len()).into_owned();
        Some(match component {
            Some(k) => at(k),
            None => DVector::from_iterator(6 * own.len(), (0..6).flat_map(|k| at(k).data.as_vec().clone())),
        })
    }

    /// The largest explained fractions of these candidates, of which those of this form are taken in, under random rotations: `at` are the
    /// rotations at every site.
    pub fn largest(
        &self,
        linearisation: &Linearisation<'_>,
        candidates: &[Screened],
        rotations: &Rotations,
        at: &[DMatrix<f32>],
    ) -> Largest {
        let mut by_frame: Vec<Vec<(usize, Option<usize>, &Score)>> = vec![Vec::new(); self.sites.len()];
        for screened in candidates {
            let (Some(score), Some((frame, set, component))) =
                (&screened.score, self.place(linearisation, &screened.candidate))
            else {
                continue;
            };
            by_frame[frame].push((set, component, score));
        }
        // Products with a transposed copy are blocked, those with a transposed view are dot products.
        let functions = self.values.transpose();
        self.sites
            .par_iter()
            .zip(by_frame)
            .map(|(sites, candidates)| {
                let mut largest = rotations.nothing();
                let products: Vec<DMatrix<f32>> = sites.iter().map(|&site| &functions * &at[site]).collect();
                for (set, component, score) in candidates {
                    let own = &self.sets[set].1;
                    match component {
                        Some(k) => {
                            rotations.add(&mut largest, &products[k].rows(own.start, own.len()), &score.basis)
                        }
                        None => {
                            let mut all = DMatrix::zeros(6 * own.len(), products[0].ncols());
                            for (k, product) in products.iter().enumerate() {
                                all.rows_mut(k * own.len(), own.len())
                                    .copy_from(&product.rows(own.start, own.len()));
                            }
                            rotations.add(&mut largest, &all, &score.basis);
                        }
                    }
                }
                largest
            })
            .reduce(|| rotations.nothing(), Largest::with)
    }

    /// (Frame, set of functions, component or all) of a candidate; none when it has another form.
    pub fn place(
        &self,
        linearisation: &Linearisation<'_>,
        candidate: &Candidate,
    ) -> Option<(usize, usize, Option<usize>)> {
        let Series { factors, frame, components } = series(candidate)?;
        let set = position(&self.sets, factors)?;
        let at = linearisation.chain().frames().position(|known| known == frame)?;
        match components {
            [axis] => Some((at, set, Some(index(*axis)))),
            _ => self.scores[at][set].all.as_ref().map(|_| (at, set, None)),
        }
    }

    /// The score of a candidate; none when it has another form.
    pub fn score(&self, linearisation: &Linearisation<'_>, candidate: &Candidate) -> Option<Option<Score>> {
        let Series { factors, frame, components } = series(candidate)?;
        let set = position(&self.sets, factors)?;
        let at = linearisation.chain().frames().position(|known| known == frame)?;
        let scores = &self.scores[at][set];
        match components {
            [axis] => Some(scores.single[index(*axis)].clone()),
            _ => scores.all.clone(),
        }
    }
}

/// All functions at these stations, stations × functions. A model holds a limited number of unknowns: they are asked in parts.
fn evaluated(
    linearisation: &Linearisation<'_>,
    effects: &[Box<dyn AnyEffect>],
    stations: &[usize],
) -> Result<DMatrix<f64>, DiscoverError> {
    /// Effects of a part; each has at most some dozens of functions.
    const PART: usize = 64;
    let mut parts = Vec::new();
    for part in effects.chunks(PART) {
        let of_part = linearisation.evaluate(part)?;
        let mut values = DMatrix::zeros(stations.len(), of_part.width());
        of_part.each(stations.iter().copied(), &mut |visit, entries| {
            for &(column, _, value) in entries {
                values[(visit, column)] += value;
            }
        })?;
        parts.push(values);
    }
    let mut all = DMatrix::zeros(stations.len(), parts.iter().map(DMatrix::ncols).sum());
    let mut first = 0;
    for part in parts {
        all.columns_mut(first, part.ncols()).copy_from(&part);
        first += part.ncols();
    }
    Ok(all)
}

/// The score of columns that are functions times one factor a component, with a basis for the functions themselves.
fn of_functions(mut score: Score, factors: &[f64]) -> Score {
    let each = score.basis.nrows() / factors.len();
    for (row, mut entries) in score.basis.row_iter_mut().enumerate() {
        entries.scale_mut(factors[row / each] as f32);
    }
    score
}

/// Number of an axis among the components of a frame.
fn index(axis: Axis) -> usize {
    Axis::ALL.iter().position(|&known| known == axis).unwrap_or_default()
}

/// Candidates that differ only in their site follow each other closely.
fn position(sets: &[(Vec<Factor>, Range<usize>)], factors: &[Factor]) -> Option<usize> {
    sets.iter().rposition(|(known, _)| known == factors)
}
