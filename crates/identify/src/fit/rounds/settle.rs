//! Base, tool and targets solved for anew where a step of all unknowns has led: valleys that bend because these have to follow.
//!
//! ```text
//! p = R_B (F(ε) y) + t_B        min over (t_B, R_B, y) at the ε of the step
//! ```
//!
//! The positions are linear in y and in t_B, whatever the arm. Where the data tells base and tool apart by small turns of the joints alone,
//! both may lie half a metre from where the nominal arm put them; a step that moves arm and placement along one straight line leaves the
//! valley after millimetres, one after which the placement follows the arm stays in it for a hundred times as long. This is Ruhe and Wedin's
//! second algorithm for separable problems (1980), with the prior.

use super::state::State;
use crate::IdentifyError;
use crate::reduction::Reduction;
use nalgebra::{DMatrix, DVector};
use truepose_kinematics::{FrameId, Site};

impl State<'_> {
    /// Places of the kept columns that say where base, tool and targets are.
    pub(super) fn placement(&self, reduction: &Reduction) -> Vec<usize> {
        let chain = self.model.chain();
        let places = |column: usize| match self.model.columns()[column].site {
            Some(Site::Frame(frame, _)) => frame == FrameId::BASE || chain.tool_of(frame).is_some(),
            Some(Site::Target(..)) => true,
            None => false,
        };
        (0..reduction.rank()).filter(|&k| places(reduction.kept[k])).collect()
    }

    /// Moves these of the grouped errors to where they are best, all others being what they are.
    pub(super) fn settle(&mut self, reduction: &Reduction, places: &[usize]) -> Result<(), IdentifyError> {
        let columns: Vec<usize> = places.iter().map(|&k| reduction.kept[k]).collect();
        let factor = self.passing_over(&columns)?;
        let count = columns.len();
        let (mut a, mut y) = (factor.r, factor.z.column(0).into_owned());
        if let Some(rows) = self.prior.rows() {
            let held = &rows * DVector::from_vec(reduction.grouped(&self.coefficients));
            let mine = rows.select_columns(places);
            let mut all = DMatrix::zeros(count + mine.nrows(), count);
            all.rows_mut(0, count).copy_from(&a);
            all.rows_mut(count, mine.nrows()).copy_from(&mine);
            let mut right = DVector::zeros(count + mine.nrows());
            right.rows_mut(0, count).copy_from(&y);
            right.rows_mut(count, mine.nrows()).copy_from(&-held);
            (a, y) = (all, right);
        }
        let split = a.qr();
        split.q_tr_mul(&mut y);
        if let Some(change) = split.r().solve_upper_triangular(&y.rows(0, count).into_owned()) {
            columns.iter().zip(change.iter()).for_each(|(&column, by)| self.coefficients[column] += by);
        }
        Ok(())
    }
}
