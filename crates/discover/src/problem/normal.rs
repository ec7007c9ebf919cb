//! Normal equations of the present model under any noise, from sums that are formed once.
//!
//! Numbers of one visit and component go together; where n of them have the same standard deviation σ, and ρ is what they share,
//!
//! ```text
//! ZᵀV⁻¹Z = 1/σ² · (Σ (z − z̄)ᵀ(z − z̄) + t² Σ n z̄ᵀz̄),   t² = 1/(1 + n ρ²/σ²),   Z = [A | X | y]
//! ```
//!
//! with z̄ the mean of a group: two sums of squares, so that nothing cancels where ρ is far above σ,
//! so that another noise costs a sum over *classes*: groups of the same n and stated deviation. Data that has many classes is whitened
//! number by number.

use crate::problem::equations::bordered;
use crate::problem::observation::Observation;
use crate::statistics::product::cross;
use nalgebra::{DMatrix, DVector};
use std::ops::Range;
use truepose_errormodel::Dataset;
use truepose_identify::NoiseModel;

/// So many classes are always a saving; more of them where their products are no more numbers than twice the columns.
const CLASSES: usize = 4;

/// Groups of equally many numbers that are stated to be equally good.
#[derive(Debug)]
struct Class {
    /// Numbers in a group; groups, one after the other.
    size: usize,
    members: Vec<usize>,
    position: bool,
    /// Stated standard deviation.
    stated: f64,
    /// [A | y].
    rows: GroupedColumns,
    own: Products,
}

/// Columns of the members of a class.
#[derive(Debug)]
struct GroupedColumns {
    /// z − z̄, where groups have several numbers.
    about: Option<DMatrix<f64>>,
    /// √n z̄.
    means: DMatrix<f64>,
}

/// Σ (z − z̄)ᵀ(z − z̄) and Σ n z̄ᵀz̄.
#[derive(Debug)]
struct Products {
    within: Option<DMatrix<f64>>,
    between: DMatrix<f64>,
}

/// What is known of [A | y].
#[derive(Debug)]
pub(crate) struct Normal {
    classes: Vec<Class>,
}

/// Columns of several candidates, class by class.
pub(crate) struct Grouped(Vec<GroupedColumns>);

/// A candidate's columns X against each other and against [A | y], class by class.
pub(crate) struct CandidateProducts {
    width: usize,
    classes: Vec<(Products, Products)>,
}

impl Class {
    /// (1/σ², t²) and the logarithm of the determinant of the groups' covariances.
    fn weights(&self, noise: NoiseModel) -> ((f64, f64), f64) {
        let (sd, shared) = match self.position {
            true => (noise.position(self.stated), noise.visit_sd),
            false => (noise.orientation(self.stated), 0.0),
        };
        let precision = 1.0 / (sd * sd);
        let n = self.size as f64;
        let stretch = 1.0 + n * shared * shared * precision;
        let groups = (self.members.len() / self.size) as f64;
        ((precision, 1.0 / stretch), groups * (stretch.ln() - n * precision.ln()))
    }

    /// Of rows that stand in the members' order.
    fn grouped(&self, rows: DMatrix<f64>) -> GroupedColumns {
        let n = self.size;
        if n == 1 {
            return GroupedColumns { about: None, means: rows };
        }
        let mean = |g: usize, j: usize| rows.column(j).rows(g * n, n).sum() / n as f64;
        let means = DMatrix::from_fn(rows.nrows() / n, rows.ncols(), mean);
        let about = DMatrix::from_fn(rows.nrows(), rows.ncols(), |i, j| rows[(i, j)] - means[(i / n, j)]);
        GroupedColumns { about: Some(about), means: means * (n as f64).sqrt() }
    }
}

impl GroupedColumns {
    fn products(&self, other: &GroupedColumns) -> Products {
        let within = self.about.as_ref().zip(other.about.as_ref()).map(|(a, b)| cross(a, b));
        Products { within, between: cross(&self.means, &other.means) }
    }
}

impl Products {
    /// Adds them under these weights.
    fn add_to(&self, sum: &mut DMatrix<f64>, (precision, kept): (f64, f64)) {
        let between = sum.as_mut_slice().iter_mut().zip(self.between.as_slice());
        match &self.within {
            Some(within) => {
                let both = between.zip(within.as_slice());
                both.for_each(|((s, b), w)| *s += precision * (w + kept * b));
            }
            None => between.for_each(|(s, b)| *s += precision * (kept * b)),
        }
    }
}

impl Normal {
    /// Of a scene; none when its numbers fall into many classes.
    pub fn of(
        observations: &[Observation],
        data: &Dataset,
        (base, y): (&DMatrix<f64>, &DVector<f64>),
    ) -> Option<Self> {
        // What numbers along directions share is no mean of them.
        let of_pose = |pose: &[Observation]| pose.len() > 1 && data.ray(pose[0].row).is_some();
        if data.rays().is_some() && observations.chunk_by(|a, b| a.visit == b.visit).any(of_pose) {
            return None;
        }
        let stated = |at: usize| {
            let o = observations[at];
            match o.component < 3 {
                true => data.position_sd[o.row][o.component],
                false => data.orientation_sd[o.row][o.component - 3],
            }
        };
        let group = |at: usize| (observations[at].visit, observations[at].component);
        let most = CLASSES.max(2 * base.nrows() / (base.ncols() + 1));
        let mut order: Vec<usize> = (0..observations.len()).collect();
        order.sort_by_key(|&at| group(at));
        let mut classes: Vec<(usize, bool, f64, Vec<usize>)> = Vec::new();
        for members in order.chunk_by(|&a, &b| group(a) == group(b)) {
            let (first, size) = (stated(members[0]), members.len());
            let same = |a: f64, b: f64| a.to_bits() == b.to_bits();
            if !members.iter().all(|&at| same(stated(at), first)) {
                return None;
            }
            let position = observations[members[0]].component < 3;
            let known = classes.iter().position(|c| c.0 == size && c.1 == position && same(c.2, first));
            match known {
                Some(class) => classes[class].3.extend(members),
                None if classes.len() == most => return None,
                None => classes.push((size, position, first, members.to_vec())),
            }
        }
        let r = base.ncols();
        let classes = classes.into_iter().map(|(size, position, stated, members)| {
            let mut rows = base.select_rows(&members).resize_horizontally(r + 1, 0.0);
            members.iter().enumerate().for_each(|(k, &at)| rows[(k, r)] = y[at]);
            let nothing = DMatrix::zeros(0, 0);
            let mut class = Class {
                size,
                members,
                position,
                stated,
                rows: GroupedColumns { about: None, means: nothing.clone() },
                own: Products { within: None, between: nothing },
            };
            class.rows = class.grouped(rows);
            class.own = class.rows.products(&class.rows);
            class
        });
        Some(Normal { classes: classes.collect() })
    }

    /// The products of a candidate's raw columns, m × k.
    pub fn candidate_products(&self, extra: &DMatrix<f64>) -> CandidateProducts {
        let classes = self.classes.iter().map(|class| {
            let mine = class.grouped(extra.select_rows(&class.members));
            (class.rows.products(&mine), mine.products(&mine))
        });
        CandidateProducts { width: extra.ncols(), classes: classes.collect() }
    }

    /// Raw columns, m × k, by class.
    pub fn grouped(&self, columns: &DMatrix<f64>) -> Grouped {
        Grouped(self.classes.iter().map(|class| class.grouped(columns.select_rows(&class.members))).collect())
    }

    /// `[A | y]ᵀ V⁻¹ X` under a noise: r + 1 rows.
    pub fn across(&self, noise: NoiseModel, columns: &Grouped) -> DMatrix<f64> {
        self.summed(noise, |at, class| class.rows.products(&columns.0[at]))
    }

    /// `XᵀV⁻¹Y` under a noise.
    pub fn between(&self, noise: NoiseModel, first: &Grouped, second: &Grouped) -> DMatrix<f64> {
        self.summed(noise, |at, _| first.0[at].products(&second.0[at]))
    }

    /// `XᵀV⁻¹X` of some of the columns under a noise.
    pub fn own(&self, noise: NoiseModel, columns: &Grouped, which: Range<usize>) -> DMatrix<f64> {
        self.summed(noise, |at, _| {
            let part = |all: &DMatrix<f64>| all.columns(which.start, which.len()).into_owned();
            let of = &columns.0[at];
            let own = GroupedColumns { about: of.about.as_ref().map(part), means: part(&of.means) };
            own.products(&own)
        })
    }

    fn summed(&self, noise: NoiseModel, products: impl Fn(usize, &Class) -> Products) -> DMatrix<f64> {
        let mut sum: Option<DMatrix<f64>> = None;
        for (at, class) in self.classes.iter().enumerate() {
            let products = products(at, class);
            let (rows, columns) = products.between.shape();
            products.add_to(sum.get_or_insert_with(|| DMatrix::zeros(rows, columns)), class.weights(noise).0);
        }
        sum.unwrap_or_else(|| DMatrix::zeros(0, 0))
    }

    /// The Gram matrix of `[A | X | y]` under a noise, and the logarithm of the determinant of its covariance.
    pub fn gram(&self, noise: NoiseModel, candidate: &CandidateProducts) -> (DMatrix<f64>, f64) {
        let (k, r) = (candidate.width, self.classes.first().map_or(0, |class| class.rows.means.ncols() - 1));
        let mut model = DMatrix::zeros(r + 1, r + 1);
        let mut along = DMatrix::zeros(r + 1, k);
        let mut own = DMatrix::zeros(k, k);
        let mut log_determinant = 0.0;
        for (class, (across, products)) in self.classes.iter().zip(&candidate.classes) {
            let (weights, log) = class.weights(noise);
            log_determinant += log;
            class.own.add_to(&mut model, weights);
            across.add_to(&mut along, weights);
            products.add_to(&mut own, weights);
        }
        let gram = bordered(&model, &Vec::from_iter(0..r), &along, &own);
        (gram, log_determinant)
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::options::DiscoverOptions;
    use crate::problem::linearisation::Linearisation;
    use truepose_errormodel::ErrorModel;
    use truepose_errormodel::effects::Geometric;
    use truepose_identify::{FitOptions, fit};
    use truepose_kinematics::{Load, samples};
    use truepose_solvers::PivotedQr;

    /// Visits of one row and of three, some with an orientation, and one instrument.
    fn data() -> Dataset {
        let mut data =
            Dataset { joints: vec![Vec::new(); 6], approach: vec![Vec::new(); 6], ..Dataset::default() };
        for visit in 0..60 {
            for row in 0..if visit % 4 == 0 { 3 } else { 1 } {
                let wave = |k: usize| (1.7 * visit as f64 + 0.9 * (k * k) as f64).sin();
                (0..6).for_each(|k| data.joints[k].push(1.5 * wave(k)));
                data.approach.iter_mut().for_each(|column| column.push(0.0));
                data.position.push([wave(7), wave(8), 0.1 * f64::from(row) + wave(9)]);
                data.orientation.push((visit % 3 == 0).then_some([1.0, 0.0, 0.0, 0.0]));
                data.position_sd.push([2e-5; 3]);
                data.orientation_sd.push([f64::NAN; 3]);
                data.target.push(None);
                data.visit.push(visit);
                data.load.push(Load::default());
                data.time.push(0.0);
            }
        }
        data
    }

    #[test]
    fn sums_say_what_whitened_columns_say() {
        let data = data();
        let model = ErrorModel::new(samples::ur10(), vec![Box::new(Geometric::default())]).unwrap();
        let quick = FitOptions { max_iterations: 2, ..FitOptions::default() };
        let fit = fit(&model, &data, &PivotedQr::default(), &quick).unwrap();
        let options = DiscoverOptions::default();
        let linearisation = Linearisation::new(&fit, &data, &options).unwrap();
        let extra = DMatrix::from_fn(linearisation.len(), 3, |i, j| (0.3 * i as f64 + j as f64).cos());
        let normal = linearisation.normal().expect("four classes");
        let candidate = normal.candidate_products(&extra);
        let (r, k) = (linearisation.base.ncols(), 3);
        let mut all = linearisation.base.clone().resize_horizontally(r + k + 1, 0.0);
        all.columns_mut(r, k).copy_from(&extra);
        all.column_mut(r + k).copy_from(&linearisation.y);
        for (row, visit) in [(1e-4, 0.0), (3e-5, 2e-4)] {
            let noise = NoiseModel { position_sd: row, visit_sd: visit, orientation_sd: 1e-3 };
            let whitener = linearisation.whitener(noise);
            let white = whitener.of(&all);
            let (gram, log_determinant) = normal.gram(noise, &candidate);
            let expected = cross(&white, &white);
            let worst = (0..=r + k).flat_map(|i| (0..=r + k).map(move |j| (i, j))).map(|(i, j)| {
                (gram[(i, j)] - expected[(i, j)]).abs()
                    / (expected[(i, i)] * expected[(j, j)]).sqrt().max(1e-300)
            });
            assert!(worst.fold(0.0, f64::max) < 1e-12);
            assert!((log_determinant - whitener.log_determinant()).abs() < 1e-9 * log_determinant.abs());
        }
    }

    #[test]
    fn nothing_cancels_where_visits_scatter_far_more_than_rows() {
        let data = data();
        let model = ErrorModel::new(samples::ur10(), vec![Box::new(Geometric::default())]).unwrap();
        let quick = FitOptions { max_iterations: 2, ..FitOptions::default() };
        let fit = fit(&model, &data, &PivotedQr::default(), &quick).unwrap();
        let options = DiscoverOptions::default();
        let linearisation = Linearisation::new(&fit, &data, &options).unwrap();
        // The same in every number of a visit: only the mean of a group speaks, 1/ρ² for each.
        let extra = DMatrix::from_element(linearisation.len(), 1, 1.0);
        let noise = NoiseModel { position_sd: 0.0, visit_sd: 1e-2, orientation_sd: 1e-3 };
        let normal = linearisation.normal().expect("four classes");
        let (gram, _) = normal.gram(noise, &normal.candidate_products(&extra));
        let numbers =
            |position: bool| linearisation.observations.iter().filter(move |o| (o.component < 3) == position);
        let groups: std::collections::BTreeSet<_> = numbers(true).map(|o| (o.visit, o.component)).collect();
        let size =
            |group: &(usize, usize)| numbers(true).filter(|o| (o.visit, o.component) == *group).count();
        let of_positions: f64 = groups.iter().map(|group| 1.0 / (4e-10 / size(group) as f64 + 1e-4)).sum();
        let expected = of_positions + numbers(false).count() as f64 / 1e-6;
        let r = linearisation.base.ncols();
        assert!((gram[(r, r)] / expected - 1.0).abs() < 1e-12, "{} {expected}", gram[(r, r)]);
    }

    #[test]
    fn many_instruments_are_no_classes() {
        let mut data = data();
        data.position_sd.iter_mut().enumerate().for_each(|(row, sd)| *sd = [1e-5 * (1.0 + row as f64); 3]);
        let model = ErrorModel::new(samples::ur10(), vec![Box::new(Geometric::default())]).unwrap();
        let quick = FitOptions { max_iterations: 2, ..FitOptions::default() };
        let fit = fit(&model, &data, &PivotedQr::default(), &quick).unwrap();
        let options = DiscoverOptions::default();
        assert!(Linearisation::new(&fit, &data, &options).unwrap().normal().is_none());
    }
}
