//! Nested cross-validation: the whole search inside each fold.
//!
//! Cross-validation of the coefficients alone, with effects that were selected on all data, is optimistically
//! biased. Here each fold is left out before anything is fitted, and is predicted by the model that the
//! search finds on the other folds (Stone 1974; Varma and Simon 2006).

use crate::conclude::cross_validated::CrossValidated;
use crate::conclude::diagnosis::Diagnosis;
use crate::conclude::errors::Errors;
use crate::conclude::fallback::{Checks, of_fold};
use crate::conclude::fold_run::FoldRun;
use crate::conclude::held_out::HeldOutIntervals;
use crate::data::derived;
use crate::diagnose::on_split;
use crate::error::DiscoverError;
use crate::options::DiscoverOptions;
use crate::progress::Progress;
use nalgebra::Vector3;
use rayon::prelude::*;
use truepose_errormodel::{AnyEffect, Dataset};
use truepose_identify::{Answer, Folds, Residuals, Split, Spread, proceed};
use truepose_kinematics::Chain;
use truepose_solvers::Solver;

/// Errors of every row, predicted by a run of the search without its fold.
#[derive(Debug, Clone)]
pub struct Nested {
    /// 3-D position error of the declared model, m.
    pub before: Spread,
    /// 3-D position error of the model of each run, m.
    pub after: Spread,
    /// Their intervals and that of the gain, on rows that no decision has seen; `None` of too few configurations.
    pub intervals: Option<HeldOutIntervals>,
    /// The run of each fold.
    pub runs: Vec<FoldRun>,
}

/// Runs the whole search once for each fold of `split`. `progress` gets the number of the fold, from zero,
/// and is called from several threads.
///
/// # Errors
/// As [`crate::diagnose`]; when there are too few configurations for the folds.
pub fn nested<A: Answer>(
    chain: &Chain,
    declared: &[Box<dyn AnyEffect>],
    data: &Dataset,
    split: &Split,
    solver: &dyn Solver,
    options: &DiscoverOptions,
    observer: &(dyn Fn(usize, Progress) -> A + Sync),
) -> Result<Nested, DiscoverError> {
    let outer = Outer::new(chain, declared, data, split, solver, options)?;
    // In parallel: each run is a function of its fold alone.
    let runs =
        (0..outer.folds.count).into_par_iter().map(|fold| outer.run(fold, &|step| observer(fold, step)));
    Nested::of(runs.collect::<Result<_, _>>()?, options)
}

impl Diagnosis {
    /// The runs of the nested folds of this search where they are those of `split`; `data` are the rows that were searched. [`Nested::of`] puts
    /// them together as [`nested()`] would.
    pub fn runs_of(&self, split: &Split, data: &Dataset) -> Option<Vec<FoldRun>> {
        let folds = Folds::new(data, split).ok().filter(|folds| folds.count == self.fold_runs.len())?;
        let same = |run: &FoldRun| {
            let mut own = (0..data.len()).filter(|&row| folds.of_visit[data.visit[row]] == run.fold);
            run.clusters.len() == data.len() && own.by_ref().eq(run.rows.iter().copied())
        };
        self.fold_runs.iter().all(same).then(|| self.fold_runs.clone())
    }
}

/// Runs the whole search without one fold of `split`, counted from zero: one of the runs of [`nested()`], on this or on another machine.
///
/// # Errors
/// As [`nested()`]; when there is no such fold.
pub fn nested_fold<A: Answer>(
    chain: &Chain,
    declared: &[Box<dyn AnyEffect>],
    data: &Dataset,
    (split, fold): (&Split, usize),
    solver: &dyn Solver,
    options: &DiscoverOptions,
    observer: &(dyn Fn(Progress) -> A + Sync),
) -> Result<FoldRun, DiscoverError> {
    let outer = Outer::new(chain, declared, data, split, solver, options)?;
    let folds = outer.folds.count;
    if fold >= folds {
        return Err(DiscoverError::Folds(format!("there is no fold {fold} among {folds}, counted from 0")));
    }
    outer.run(fold, observer)
}

/// What all folds have in common.
struct Outer<'a> {
    chain: &'a Chain,
    declared: &'a [Box<dyn AnyEffect>],
    /// All rows, with derived channels.
    data: Dataset,
    folds: Folds,
    solver: &'a dyn Solver,
    /// Those of the runs without a fold.
    options: DiscoverOptions,
}

impl<'a> Outer<'a> {
    fn new(
        chain: &'a Chain,
        declared: &'a [Box<dyn AnyEffect>],
        data: &Dataset,
        split: &Split,
        solver: &'a dyn Solver,
        options: &'a DiscoverOptions,
    ) -> Result<Self, DiscoverError> {
        options.validate()?;
        let data = derived::with_derived(data, declared, &options.policy);
        let folds = Folds::new(&data, split)?;
        Ok(Outer { chain, declared, data, folds, solver, options: of_fold(options) })
    }

    fn run<A: Answer>(
        &self,
        fold: usize,
        observer: &(dyn Fn(Progress) -> A + Sync),
    ) -> Result<FoldRun, DiscoverError> {
        let Outer { chain, declared, data, folds, solver, options } = self;
        let rows = (0..data.len()).partition(|&row| folds.of_visit[data.visit[row]] != fold);
        let step = |step| Ok(proceed(observer(step))?);
        let found = on_split(chain, declared, (data, rows), *solver, options, Checks::OfFold, &step)?;
        Ok(FoldRun::of((fold, folds.count), &found, data))
    }
}

impl Nested {
    /// Of the runs of all folds, in any order; `options` are those of the runs.
    ///
    /// # Errors
    /// When a fold is missing or there twice, or the runs are of different data.
    pub fn of(mut runs: Vec<FoldRun>, options: &DiscoverOptions) -> Result<Self, DiscoverError> {
        runs.sort_by_key(|run| run.fold);
        let folds = whole(&runs)?;
        // Of the dependence that most runs would report; none comes after all others.
        let p = |run: &FoldRun| run.dependence.unwrap_or(f64::INFINITY);
        let mut each: Vec<&FoldRun> = runs.iter().collect();
        each.sort_by(|a, b| p(a).total_cmp(&p(b)));
        let clusters = &each[folds / 2].clusters;
        let (before, after) = (merged(&runs, |run| &run.before), merged(&runs, |run| &run.after));
        // Of the fold whose final model has the most unknowns: none of them is the fit to all rows.
        let largest = runs.iter().max_by_key(|run| run.rank);
        let judged = largest.map(|run| CrossValidated::with(run.used, folds));
        let (draws, seed) = (options.budget.bootstrap, options.seed);
        let intervals = HeldOutIntervals::of([&before, &after], clusters, judged, draws, seed);
        Ok(Nested { before: before.holdout.positions(), after: after.holdout.positions(), intervals, runs })
    }
}

/// How many folds there are, where each is there once and all are of the same rows.
fn whole(runs: &[FoldRun]) -> Result<usize, DiscoverError> {
    let refuse = |words: String| Err(DiscoverError::Folds(words));
    let Some(first) = runs.first() else { return refuse("there is no run of a fold".into()) };
    let (folds, rows) = (first.folds, first.clusters.len());
    if let Some(missing) = (0..folds.max(runs.len())).find(|&k| runs.get(k).is_none_or(|run| run.fold != k)) {
        return refuse(format!(
            "of the runs of {folds} folds, that of fold {missing} is missing or another is there twice"
        ));
    }
    let mut seen = vec![false; rows];
    for run in runs {
        if run.folds != folds || run.clusters.len() != rows {
            return refuse(format!("the run of fold {} is of other data or folds", run.fold));
        }
        let consistent = [run.before.len(), run.after.len()] == [run.rows.len(); 2]
            && run.rows.iter().all(|&row| row < rows && !std::mem::replace(&mut seen[row], true));
        if !consistent {
            return refuse(format!(
                "the run of fold {} has rows that are not there or of another fold",
                run.fold
            ));
        }
    }
    Ok(folds)
}

/// Residuals of all rows, each by the run that has not seen it.
fn merged(runs: &[FoldRun], which: fn(&FoldRun) -> &[Option<[f64; 3]>]) -> Errors {
    let rows = runs[0].clusters.len();
    let mut holdout =
        Residuals { position: vec![Vector3::repeat(f64::NAN); rows], orientation: vec![None; rows] };
    for run in runs {
        for (&row, residual) in run.rows.iter().zip(which(run)) {
            holdout.position[row] = residual.map_or(Vector3::repeat(f64::NAN), Vector3::from);
        }
    }
    Errors { holdout, ..Errors::default() }
}

#[cfg(test)]
mod tests {
    use super::*;

    /// Rows row % folds == fold of 40, with errors of 1 mm and a bit, and half of it with the findings.
    fn run(fold: usize, folds: usize) -> FoldRun {
        let rows: Vec<usize> = (0..40).filter(|row| row % folds == fold).collect();
        let errors = |factor: f64| {
            let one = |&row: &usize| (row != 7).then_some([factor * (1e-3 + 1e-5 * row as f64), 1e-4, 0.0]);
            rows.iter().map(one).collect()
        };
        FoldRun {
            fold,
            folds,
            findings: vec![format!("finding {fold}")],
            before: errors(1.0),
            after: errors(0.5),
            dependence: Some(0.1 * (fold + 1) as f64),
            clusters: (0..40).map(|row| row / (fold + 1)).collect(),
            rank: 20 + fold % 3,
            used: [0.1, 0.1 + 0.01 * fold as f64],
            rows,
        }
    }

    fn runs(folds: usize) -> Vec<FoldRun> {
        (0..folds).map(|fold| run(fold, folds)).collect()
    }

    #[test]
    fn runs_come_in_any_order_and_through_their_stored_form() {
        let options = DiscoverOptions::default();
        let whole = Nested::of(runs(5), &options).unwrap();
        assert_eq!((whole.before.count, whole.after.count), (39, 39));
        assert!(whole.after.rms < 0.6 * whole.before.rms && whole.intervals.unwrap().gain.is_some());
        let stored: Vec<String> =
            [3, 0, 4, 2, 1].map(|fold| serde_json::to_string(&run(fold, 5)).unwrap()).to_vec();
        let read = stored.iter().map(|text| serde_json::from_str(text).unwrap()).collect();
        let again = Nested::of(read, &options).unwrap();
        assert_eq!((again.before, again.after), (whole.before, whole.after));
        assert_eq!((again.intervals, again.runs), (whole.intervals, whole.runs));
    }

    #[test]
    fn clusters_are_those_of_the_median_dependence_and_of_none_where_most_have_none() {
        let options = DiscoverOptions::default();
        let with = |none: &[usize], same: usize| {
            let mut all = runs(5);
            none.iter().for_each(|&fold| all[fold].dependence = None);
            let of_median = Nested::of(all.clone(), &options).unwrap().intervals;
            all.iter_mut().for_each(|one| one.clusters = run(same, 5).clusters);
            of_median == Nested::of(all, &options).unwrap().intervals
        };
        assert!(with(&[], 2) && !with(&[], 4));
        assert!(with(&[0, 1, 2], 0), "the first run without a dependence");
    }

    #[test]
    fn what_is_no_set_of_folds_is_refused() {
        let refused = |change: fn(&mut Vec<FoldRun>)| {
            let mut all = runs(3);
            change(&mut all);
            Nested::of(all, &DiscoverOptions::default()).unwrap_err().to_string()
        };
        assert!(refused(Vec::clear).contains("no run"));
        assert!(refused(|all| drop(all.remove(1))).contains("fold 1 is missing"));
        assert!(refused(|all| all.push(run(0, 3))).contains("twice"));
        assert!(refused(|all| all[2].folds = 4).contains("fold 2 is of other"));
        assert!(refused(|all| all[1].clusters.truncate(39)).contains("fold 1 is of other"));
        assert!(refused(|all| all[1].rows[0] = 40).contains("fold 1 has rows"));
        assert!(refused(|all| all[1].rows[0] = 0).contains("fold 1 has rows"));
        assert!(refused(|all| all[0].after.truncate(1)).contains("fold 0 has rows"));
    }
}
