//! What is left out at the nominal robot, looked at again where the rounds have ended.

use super::state::{Outcome, State};
use crate::IdentifyError;
use crate::reduction::{Reduction, reduce_further};
use nalgebra::DMatrix;
use truepose_solvers::ColumnScale;
use truepose_solvers::accumulator::Factor;

impl State<'_> {
    /// The reduction at the solution, when the data determines more there than at the nominal robot.
    pub(in crate::fit) fn looked_at_again(
        &self,
        reduction: &Reduction,
        outcome: &Outcome,
    ) -> Result<Option<Reduction>, IdentifyError> {
        let (at, rule) = (&self.coefficients, self.options.rank);
        if reduction.dropped.is_empty() {
            return Ok(None);
        }
        let all = self.linearise(None)?;
        let more = reduce_further(self.model, self.data, &all, rule, at, reduction)?;
        if more.rank() <= reduction.rank() || !reduction.kept.iter().all(|c| more.kept.contains(c)) {
            return Ok(None);
        }
        // Directions that the data determines better than by their expected sizes.
        let determined = |kept: &[usize], factor: &Factor| -> Result<usize, IdentifyError> {
            let scales: Vec<f64> = kept.iter().map(|&c| self.model.columns()[c].scale).collect();
            let values = factor.singular_values(ColumnScale::Given(&scales))?;
            Ok(values.iter().filter(|d| **d >= 1.0).count())
        };
        if determined(&more.kept, &all.select(&more.kept))? <= determined(&reduction.kept, &outcome.factor)? {
            return Ok(None);
        }
        Ok(Some(more))
    }

    /// Shares the grouped errors out among the finer groups of another reduction, as the prior expects it: the same robot to first
    /// order, and no long way through the valley between them.
    pub(in crate::fit) fn share_out(&mut self, coarse: &Reduction, fine: &Reduction) {
        let mut place = vec![usize::MAX; self.coefficients.len()];
        fine.kept.iter().enumerate().for_each(|(k, &column)| place[column] = k);
        let mut groups = DMatrix::zeros(coarse.rank(), fine.rank());
        for (row, group) in coarse.groups.iter().enumerate() {
            groups[(row, place[group.column])] = 1.0;
            let members = group.members.iter().filter(|(column, _)| place[*column] != usize::MAX);
            members.for_each(|&(column, weight)| groups[(row, place[column])] = weight);
        }
        if let Some(shared) = self.prior.shared_out(&groups, &coarse.grouped(&self.coefficients)) {
            self.coefficients = fine.expand(shared.as_slice(), self.coefficients.len());
        }
    }
}
