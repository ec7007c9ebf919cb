//! Whether residuals of poses depend on those measured shortly before, and the wander of instrument or robot that makes them.
//!
//! A cause that the model lacks makes residuals depend on each other, too, wherever the poses sweep a joint or the cause is a drift; and where
//! something wanders, a sweep turns it into an effect of the joint. So the search runs without a wander first. Where
//! [`crate::problem::autocorrelation`] is significant, a candidate has to raise the restricted likelihood *with a wander in both models*,
//! each with the wander that fits it best: a cause leaves none, or a smaller one. When no candidate does, the wander joins the model as columns
//! with a prior ([`crate::problem::wander`]), and the search goes on beside it.

use crate::problem::autocorrelation::{Autocorrelation, autocorrelation};
use crate::problem::joint_noise::BesideJoints;
use crate::problem::linearisation::Linearisation;
use crate::problem::sequence::{Ordered, Process, Sequence};
use crate::problem::wander::Wander;
use crate::problem::whitening::Whitener;
use crate::statistics::chi_square::surprisal;
use nalgebra::DMatrix;
use serde::{Deserialize, Serialize};
use std::sync::OnceLock;

/// Dependence of the residuals of poses on those measured before.
#[derive(Debug, Clone, Copy, PartialEq, Serialize, Deserialize)]
pub struct Dependence {
    /// Correlation of a pose's residual with that of the next pose, of one axis.
    pub autocorrelation: f64,
    /// p of no dependence, from the largest score over time constants.
    pub p_value: f64,
    /// Standard deviation of the wander in space, m; none where it is not significant.
    pub wander: Option<f64>,
    /// Its time constant, s (numbers of poses where the data has no time).
    pub time_constant: Option<f64>,
    /// Whether the data has a time.
    pub timed: bool,
}

/// The residuals of a linearised problem in the order of their poses.
struct Examined {
    whitener: Whitener,
    sequence: Sequence,
    /// Whitened [A | y].
    white: DMatrix<f64>,
    test: Autocorrelation,
}

impl Examined {
    /// None with too few poses.
    fn of(linearisation: &Linearisation<'_>, seed: u64) -> Option<Self> {
        let whitener = linearisation.whitener(linearisation.noise);
        let sequence = Sequence::of(linearisation, &whitener)?;
        let r = linearisation.base.ncols();
        let mut white = linearisation.base.clone().resize_horizontally(r + 1, 0.0);
        white.column_mut(r).copy_from(&linearisation.y);
        whitener.apply(&mut white);
        let test = autocorrelation(&sequence, &white, linearisation.prior.as_ref(), seed);
        Some(Examined { whitener, sequence, white, test })
    }

    /// The same where poses depend on each other significantly.
    fn significant(self, linearisation: &Linearisation<'_>) -> Option<Self> {
        (self.test.p_value <= linearisation.policy.dependence_level).then_some(self)
    }

    /// Whitened [A | … | y] in the order of the poses.
    fn ordered(&self, linearisation: &Linearisation<'_>, white: &DMatrix<f64>) -> Ordered<'_> {
        Ordered::new(&self.sequence, white, linearisation.base.ncols(), linearisation.prior.as_ref())
    }

    fn wander(self, linearisation: &Linearisation<'_>) -> Wander {
        let (process, _) = self.ordered(linearisation, &self.white).fitted(Process::begun(self.test.time));
        Wander { sequence: self.sequence, process }
    }
}

impl Linearisation<'_> {
    /// Whether poses depend on those before significantly.
    pub fn is_dependent(&self, seed: u64) -> bool {
        self.wander().is_empty()
            && Examined::of(self, seed).and_then(|examined| examined.significant(self)).is_some()
    }

    /// The same with the wander of instrument or robot as further columns, where poses depend on each other significantly.
    pub fn beside_wander(self, seed: u64) -> Self {
        match Examined::of(&self, seed).and_then(|examined| examined.significant(&self)) {
            Some(examined) => examined.wander(&self).joined(self),
            None => self,
        }
    }
}

/// Tests of candidates beside a wander of instrument or robot.
pub(crate) struct BesideWander<'l> {
    linearisation: &'l Linearisation<'l>,
    /// The same beside a scatter of the joints.
    pub joints: BesideJoints<'l>,
    seed: u64,
    /// The poses in their order with −2 ln of the likelihood without a candidate and its process, once a candidate is tested; none where
    /// poses do not depend on each other significantly.
    without: OnceLock<Option<(Examined, Process, f64)>>,
}

impl<'l> BesideWander<'l> {
    /// At a linearised problem.
    pub fn of(linearisation: &'l Linearisation<'l>, seed: u64) -> Self {
        BesideWander {
            linearisation,
            joints: BesideJoints::of(linearisation),
            seed,
            without: OnceLock::new(),
        }
    }

    fn without(&self) -> Option<&(Examined, Process, f64)> {
        let problem = self.linearisation;
        let examined = || {
            if !problem.wander().is_empty() || problem.noise.joints.is_some() {
                return None;
            }
            let examined = Examined::of(problem, self.seed)?.significant(problem)?;
            let (process, deviance) =
                examined.ordered(problem, &examined.white).fitted(Process::begun(examined.test.time));
            Some((examined, process, deviance))
        };
        self.without.get_or_init(examined).as_ref()
    }

    /// p of raw columns of a candidate (m × k, of so many directions) beside a wander, family-wise: the likelihood ratio of two models with a
    /// wander each. None where poses do not depend on each other significantly, or the problem has the wander already.
    pub fn p_value(&self, columns: &DMatrix<f64>, freedom: usize) -> Option<f64> {
        if columns.ncols() == 0 {
            return None;
        }
        let (examined, process, deviance) = self.without()?;
        let (r, k) = (self.linearisation.base.ncols(), columns.ncols());
        let mut more = examined.white.clone().insert_columns(r, k, 0.0);
        more.columns_mut(r, k).copy_from(&examined.whitener.of(columns));
        let (_, with) = examined.ordered(self.linearisation, &more).fitted(*process);
        let single = (-surprisal(deviance - with, freedom)).exp();
        Some((single * self.linearisation.policy.dependence_tests).min(1.0))
    }
}

/// What the residuals of a linearised problem say; none with too few poses.
pub(crate) fn dependence(linearisation: &Linearisation<'_>, seed: u64) -> Option<Dependence> {
    let examined = Examined::of(linearisation, seed)?;
    let test = examined.test;
    let step = examined.sequence.step;
    let wander = examined.significant(linearisation).map(|examined| examined.wander(linearisation));
    let space = |w: &Wander| (3.0 * w.process.wander * w.sequence.typical).sqrt();
    Some(Dependence {
        autocorrelation: wander.as_ref().map_or(test.neighbours, |w| w.process.autocorrelation()),
        p_value: test.p_value,
        wander: wander.as_ref().map(space),
        time_constant: wander.as_ref().map(|w| w.process.time * step),
        timed: test.timed,
    })
}
