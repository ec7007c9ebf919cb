//! Data from and to arrays of [`ndarray`], for programs that have their measurements in memory.
//!
//! | array | shape | unit | frame |
//! | --- | --- | --- | --- |
//! | joints | rows × movable joints | rad, m | |
//! | positions | rows × 3 | m | measurement frame; NaN where it was not measured |

use crate::{Dataset, Dwell, DwellTolerance, ModelError, approach_from_order, visits_from_rows};
use ndarray::{Array2, ArrayView2};
use truepose_kinematics::{Chain, Load, TargetId};

impl Dataset {
    /// Positions of one target (none: of the tool's origin) measured at these joint values, in the order in which the robot took them,
    /// without load, time and channels: those are fields to be filled.
    ///
    /// # Errors
    /// [`ModelError::Shape`] when the arrays do not fit the robot or each other, or a joint value is not finite.
    pub fn from_arrays(
        chain: &Chain,
        joints: ArrayView2<'_, f64>,
        positions: ArrayView2<'_, f64>,
        target: Option<TargetId>,
    ) -> Result<Dataset, ModelError> {
        let rows = joints.nrows();
        let shape = |what: &'static str, have: usize, need: usize| {
            if have == need { Ok(()) } else { Err(ModelError::Shape { what, have, need }) }
        };
        shape("joint columns", joints.ncols(), chain.movable().len())?;
        shape("positions", positions.nrows(), rows)?;
        shape("components of a position", positions.ncols(), 3)?;
        shape("finite joint values", joints.iter().filter(|v| v.is_finite()).count(), joints.len())?;
        let unknown = vec![[f64::NAN; 3]; rows];
        let mut data = Dataset {
            joints: joints.columns().into_iter().map(|column| column.to_vec()).collect(),
            position: positions.rows().into_iter().map(|row| [row[0], row[1], row[2]]).collect(),
            orientation: vec![None; rows],
            position_sd: unknown.clone(),
            orientation_sd: unknown,
            target: vec![target; rows],
            load: vec![Load::default(); rows],
            time: vec![0.0; rows],
            approach: vec![vec![0.0; rows]; chain.movable().len()],
            visit: vec![0; rows],
            dwell: Dwell::of(chain, DwellTolerance::default()),
            ..Dataset::default()
        };
        data.visit = visits_from_rows(&data);
        data.approach = approach_from_order(&data);
        data.schema.approach = true;
        data.validate(chain)?;
        Ok(data)
    }

    /// The joint values, rows × movable joints, rad or m.
    pub fn joints_array(&self) -> Array2<f64> {
        Array2::from_shape_fn((self.len(), self.joints.len()), |(row, joint)| self.joints[joint][row])
    }

    /// The measured positions, rows × 3, m, NaN where they were not measured.
    pub fn positions_array(&self) -> Array2<f64> {
        Array2::from_shape_fn((self.len(), 3), |(row, axis)| self.position[row][axis])
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use ndarray::{Axis, array};
    use truepose_kinematics::samples;

    #[test]
    fn arrays_come_back_as_they_were() {
        let chain = samples::all().remove(0);
        let n = chain.movable().len();
        let joints = Array2::from_shape_fn((4, n), |(row, joint)| 0.1 * row as f64 - 0.2 * joint as f64);
        let positions = Array2::from_shape_fn((4, 3), |(row, axis)| row as f64 + 0.25 * axis as f64);
        // Views with other strides than an array of their own.
        let table = ndarray::concatenate![Axis(1), joints, positions];
        let (left, right) = table.view().split_at(Axis(1), n);
        let data = Dataset::from_arrays(&chain, left, right, None);
        let data = data.expect("arrays that fit");
        assert_eq!(data.joints_array(), joints);
        assert_eq!(data.positions_array(), positions);
        assert_eq!(data.visit, [0, 1, 2, 3]);
        // Every joint rose from row to row.
        assert_eq!(data.approach[0], [0.0, 1.0, 1.0, 1.0]);
    }

    #[test]
    fn arrays_that_do_not_fit_are_refused() {
        let chain = samples::all().remove(0);
        let n = chain.movable().len();
        let (joints, positions) = (Array2::zeros((2, n)), Array2::zeros((2, 3)));
        let refused = |joints: &Array2<f64>, positions: &Array2<f64>| {
            Dataset::from_arrays(&chain, joints.view(), positions.view(), None)
                .expect_err("no fit")
                .to_string()
        };
        assert_eq!(
            refused(&Array2::zeros((2, n + 1)), &positions),
            format!("joint columns: {} where {n} are needed", n + 1)
        );
        assert_eq!(refused(&joints, &array![[0.0, 0.0, 0.0]]), "positions: 1 where 2 are needed");
        assert_eq!(
            refused(&joints, &Array2::zeros((2, 2))),
            "components of a position: 2 where 3 are needed"
        );
        let mut broken = joints.clone();
        broken[[1, 0]] = f64::NAN;
        assert_eq!(
            refused(&broken, &positions),
            format!("finite joint values: {} where {} are needed", 2 * n - 1, 2 * n)
        );
    }
}
