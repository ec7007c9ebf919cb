//! The fitted model projected onto what a file carries: constant errors of every frame and target, and for tables one factor a joint.
//!
//! ```text
//! min_x  m ln Σ_i |p_i − p(q_i; ε)|²  +  m ln Σ_i |φ_i − φ(q_i; ε)|²  +  |(x − x⁰)/3s|²         the second where orientations were measured
//! ε(q) = constants + Σ_j g_j t_j(q_j),      x = [constants, g]
//! ```
//!
//! | symbol | here | shape | unit | |
//! | --- | --- | --- | --- | --- |
//! | p_i, φ_i | `Row::point`, `Row::tool` | 3 | m, rad | the fitted model at the configurations of the fit |
//! | t_j | tables of joint j | sites | m, rad | none for files of constants alone |
//! | x⁰ | `Walker::start` | | m, rad, 1 | constants of the fit itself, factors of one |
//! | s | [`scales`] | | m, rad, 1 | expected sizes |
//! | m | `Sums::count` | 1 | | components |
//!
//! Effects with a mean (a transmission error's cosine, a joint's compliance under its own weight) share it with the constants beside them: the constants
//! alone, cut out, may be worse than nominal. The logarithms are least squares with both variances estimated. What the file cannot carry (backlash,
//! say) is no reason to turn a weakly determined axis by degrees for a hundredth of the error: constants have the prior of the fit
//! about its own, of three expected sizes each. Levenberg and Marquardt's method with the exact error Jacobian, in expected sizes.

use super::error_tables::ErrorTables;
use super::reference::{Reference, Row};

use crate::CompensateError;
use nalgebra::{DMatrix, DVector, Vector3};
use truepose_errormodel::descent::{Schedule, descend, difference};
use truepose_errormodel::effects::Geometric;
use truepose_errormodel::{Effect, ErrorJacobian, GeneralizedErrors, RealPosture};
use truepose_kinematics::{Chain, PostureBuffer, Site, rotation_log};

/// A file carries the tool and not the targets: what moves all of them alike belongs to the tool.
const OF_A_TARGET: f64 = 0.1;
/// Standard deviation of a constant about that of the fit, expected sizes: what real effects share with constants is of their size.
pub(super) const WIDE: f64 = 3.0;
/// What is left below this, m and rad, is below the resolution of any instrument.
const NEGLIGIBLE: f64 = 1e-6;
/// Smallest damping, of the largest diagonal: what double precision can solve.
const LEAST_DAMPING: f64 = 1e-12;
/// The first step may go some ten expected sizes in a direction that one row fixes as well as all others do. Steps that lower the logarithms
/// by less than 1e-7, three in a row, are the last ones.
const SCHEDULE: Schedule = Schedule {
    first: 1e-2,
    good: (0.2, 0.0),
    bad: (10.0, f64::INFINITY),
    steps: 300,
    patience: (3, 3),
    flat: 1e-7,
    gain: difference,
};

/// What a file carries.
pub(super) struct Projected {
    pub constants: GeneralizedErrors,
    /// One a table.
    pub gains: Vec<f64>,
}

/// Projects the model at these configurations, from these constants and tables on.
pub(super) fn project(
    chain: &Chain,
    reference: &Reference,
    start: &GeneralizedErrors,
    tables: Option<&ErrorTables>,
) -> Result<Projected, CompensateError> {
    let sites: Vec<Site> = (0..chain.site_count()).map(|k| chain.site_at(k)).collect();
    let gains = tables.map_or(0, |tables| tables.tables.len());

    let scale = scales(chain, &sites, gains);
    let x: Vec<f64> =
        sites.iter().map(|&site| start.get(site)).chain(std::iter::repeat_n(1.0, gains)).collect();
    let mut walker = Walker::new(chain, (&sites, &scale), &x, tables);
    let sums = walker.sums(reference, &x);
    let cost = sums.objective();
    let propose = |(x, sums): &(Vec<f64>, Sums), damping: f64| {
        let step = sums.step(damping)?;
        let next: Vec<f64> =
            x.iter().zip(step.iter().zip(&scale)).map(|(x, (step, scale))| x + step * scale).collect();
        let then = walker.sums(reference, &next);
        let cost = then.objective();
        Some(((next, then), cost))
    };
    let ((x, _), _) = descend(((x, sums), cost), &SCHEDULE, propose, |next| next);
    let constants = walker.errors_of(&x, &[]);
    Ok(Projected { constants, gains: x[sites.len()..].to_vec() })
}

/// The normal equations at some unknowns, of positions and orientations.
struct Sums {
    gram: [DMatrix<f64>; 2],
    pull: [DVector<f64>; 2],
    /// Mean square of a component that is left; none where it does not count.
    left: [Option<f64>; 2],
    /// x − x⁰ in standard deviations of the prior.
    apart: DVector<f64>,
    /// Components of the positions.
    count: f64,
}

impl Sums {
    fn objective(&self) -> f64 {
        self.left.iter().flatten().map(|left| left.ln()).sum::<f64>() + self.apart.norm_squared() / self.count
    }

    fn step(&self, damping: f64) -> Option<DVector<f64>> {
        let size = self.pull[0].len();
        let mut a = DMatrix::identity(size, size) / (WIDE * WIDE);
        let mut b = -&self.apart / WIDE;
        for ((gram, pull), left) in self.gram.iter().zip(&self.pull).zip(self.left) {
            if let Some(left) = left {
                a += gram / left;
                b += pull / left;
            }
        }
        let least = LEAST_DAMPING * a.diagonal().amax();
        (a + DMatrix::identity(size, size) * damping.max(least)).cholesky().map(|factor| factor.solve(&b))
    }
}

/// How far each unknown is expected to move.
pub(super) fn scales(chain: &Chain, sites: &[Site], gains: usize) -> Vec<f64> {
    let expected = Geometric::default().columns(chain);
    let of = |site: &Site| {
        let column = expected.iter().find(|column| column.site == Some(*site));
        let share = if matches!(site, Site::Target(..)) { OF_A_TARGET } else { 1.0 };
        share * column.map_or(1e-3, |column| column.scale)
    };
    sites.iter().map(of).chain(std::iter::repeat_n(1.0, gains)).collect()
}

/// Evaluates rows.
struct Walker<'a> {
    chain: &'a Chain,
    sites: &'a [Site],
    scale: &'a [f64],
    start: Vec<f64>,
    tables: Option<&'a ErrorTables>,
    buffer: PostureBuffer,
    real: RealPosture,
    /// Of one row, in the scale of the unknowns.
    rows: [DMatrix<f64>; 2],
}

impl<'a> Walker<'a> {
    fn new(
        chain: &'a Chain,
        (sites, scale): (&'a [Site], &'a [f64]),
        start: &[f64],
        tables: Option<&'a ErrorTables>,
    ) -> Self {
        let rows = [DMatrix::zeros(3, scale.len()), DMatrix::zeros(3, scale.len())];
        let (buffer, real) = (PostureBuffer::new(chain), RealPosture::new(chain));
        Walker { chain, sites, scale, start: start.to_vec(), tables, buffer, real, rows }
    }

    fn sums(&mut self, reference: &Reference, x: &[f64]) -> Sums {
        let size = x.len();
        let mut gram = [DMatrix::zeros(size, size), DMatrix::zeros(size, size)];
        let mut pull = [DVector::zeros(size), DVector::zeros(size)];
        let mut squares = [0.0; 2];
        for row in &reference.rows {
            let gaps = self.gaps(row, x);
            for k in 0..if reference.turned { 2 } else { 1 } {
                gram[k].gemm_tr(1.0, &self.rows[k], &self.rows[k], 1.0);
                pull[k].gemv_tr(1.0, &self.rows[k], &gaps[k], 1.0);
                squares[k] += gaps[k].norm_squared();
            }
        }
        let count = 3.0 * reference.rows.len().max(1) as f64;
        let [position, turn] = squares.map(|s| (s / count).max(NEGLIGIBLE * NEGLIGIBLE));
        let apart = (0..size).map(|k| (x[k] - self.start[k]) / (WIDE * self.scale[k]));
        let apart = DVector::from_iterator(size, apart);
        Sums { gram, pull, left: [Some(position), reference.turned.then_some(turn)], apart, count }
    }

    /// Constants and tables at one configuration.
    fn errors_of(&self, x: &[f64], by_joint: &[GeneralizedErrors]) -> GeneralizedErrors {
        let mut errors = GeneralizedErrors::zero(self.chain);
        for (k, &site) in self.sites.iter().enumerate() {
            let gains = &x[self.sites.len()..];
            let moved: f64 = by_joint.iter().zip(gains).map(|(table, gain)| gain * table.get(site)).sum();
            errors.add(site, x[k] + moved);
        }
        errors
    }

    /// What is left of position (m) and orientation (rad), and in `rows` how it moves with each unknown.
    fn gaps(&mut self, row: &Row, x: &[f64]) -> [DVector<f64>; 2] {
        let joints = &row.conditions.joints;
        let by_joint = self.tables.map(|tables| tables.by_joint(self.chain, joints)).unwrap_or_default();
        let errors = self.errors_of(x, &by_joint);
        let nominal = self.buffer.update(self.chain, &row.conditions);
        self.real.update(&nominal, &errors);
        let jacobian = ErrorJacobian::new(self.chain, &self.real, &errors, row.target);
        let (rows, scale) = (&mut self.rows, self.scale);
        rows.iter_mut().for_each(|rows| rows.fill(0.0));
        let mut put = |k: usize, column: usize, value: Vector3<f64>| {
            (0..3).for_each(|c| rows[k][(c, column)] += value[c] * scale[column]);
        };
        for (column, &site) in self.sites.iter().enumerate() {
            let moves = [jacobian.position(site), jacobian.rotation(site)];
            for (k, motion) in moves.into_iter().enumerate() {
                put(k, column, motion);
                for (table, errors) in by_joint.iter().enumerate() {
                    put(k, self.sites.len() + table, motion * errors.get(site));
                }
            }
        }
        let turned = rotation_log(&(row.tool.rotation * self.real.tool().rotation.transpose()));
        let left = [row.point - jacobian.point(), turned];
        left.map(|v| DVector::from_column_slice(v.as_slice()))
    }
}
