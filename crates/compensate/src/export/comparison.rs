//! Three robots compared at the same positions: the nominal one, the one of the file, and the fitted model.
//!
//! ```text
//! as written   RMS_i |y_i − T(q_i) p_τ|
//! aligned      min_{B, X, p_τ}  RMS_i |y_i − B T(q_i) X p_τ|
//! ```
//!
//! | symbol | here | shape | unit | |
//! | --- | --- | --- | --- | --- |
//! | y | measured position; without measurements the fitted model's | 3 | m | measurement frame |
//! | T, p_τ | a robot's tool, and the target on it | pose, 3 | m | |
//! | B, X | base and tool, the best for each robot: whoever takes a file finds them anew | pose | m | p_τ free where it was declared unknown |

use super::reference::{Reference, Row};
use crate::exported_accuracy::Accuracy;
use nalgebra::{DMatrix, DVector, Matrix3, Vector3};
use truepose_kinematics::{Chain, Pose, TargetId, rotation_vector, skew};

/// Accuracy of an export beside the nominal robot and the model.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Comparison {
    /// The robot as it was described (where base, tool and targets were unknown: as they were first found).
    pub nominal: Accuracy,
    /// The export.
    pub export: Accuracy,
    /// The fitted model.
    pub model: Accuracy,
    /// How many positions.
    pub rows: usize,
    /// Rows of the fit that they were drawn from; none: configurations spread over the joints' ranges.
    pub drawn_from: Option<usize>,
    /// True against measured positions, false against those of the model.
    pub measured: bool,
}

/// Differences below this, m, are rounding.
const SAME: f64 = 1e-9;
/// Differences below this fraction are none: two fits of the same numbers differ by as much where one of them weighs orientations otherwise.
const ALIKE: f64 = 5e-3;

impl Comparison {
    /// Whether the export is worse than the nominal robot.
    pub fn worse(&self) -> bool {
        let worse = |export: f64, nominal: f64| export > nominal * (1.0 + ALIKE) + SAME;
        worse(self.export.aligned, self.nominal.aligned)
            || worse(self.export.as_written, self.nominal.as_written)
    }

    /// In words, a line each.
    pub fn statement(&self) -> Vec<String> {
        let against = match (self.measured, self.drawn_from) {
            (true, Some(all)) if all == self.rows => {
                format!("the {} measured positions of the fit", self.rows)
            }
            (true, Some(all)) => format!("measured positions ({} of the fit's {all})", self.rows),
            (false, Some(_)) => format!("the full model at {} configurations of the fit", self.rows),
            (_, None) => format!(
                "the full model at {} configurations spread over its ranges (the fit file holds no measured ones: fit again to include them)",
                self.rows
            ),
        };
        let line = |of: fn(&Accuracy) -> f64| {
            let mm = |accuracy: &Accuracy| format!("{:.4}", 1e3 * of(accuracy));
            format!(
                "nominal {} → this file {} → full model {} mm",
                mm(&self.nominal),
                mm(&self.export),
                mm(&self.model)
            )
        };
        vec![
            format!("RMS distance to {against}:"),
            format!("base and tool best for each: {}", line(|accuracy| accuracy.aligned)),
            format!("as written: {}", line(|accuracy| accuracy.as_written)),
        ]
    }
}

/// Compares an export with the other two; `exported` is its tool at a row and the target on it.
pub(super) fn compared(
    nominal: &Chain,
    reference: &Reference,
    mut exported: impl FnMut(&Row) -> (Pose, Vector3<f64>),
) -> Comparison {
    let measured = reference.rows.iter().any(|row| row.measured.is_some());
    let rows: Vec<&Row> = reference.rows.iter().filter(|row| !measured || row.measured.is_some()).collect();
    let free = |target: Option<TargetId>| target.filter(|t| !nominal.targets()[t.0].known);
    let seen = |row: &Row, (tool, point): (Pose, Vector3<f64>)| Seen {
        tool,
        point,
        free: free(row.target).map(|t| t.0),
        wanted: row.measured.unwrap_or(row.point),
    };
    let targets = nominal.targets().len();
    let judge = |of: &mut dyn FnMut(&Row) -> (Pose, Vector3<f64>)| {
        accuracy(rows.iter().map(|row| seen(row, of(row))).collect(), targets)
    };
    Comparison {
        nominal: judge(&mut |row| of_chain(nominal, row)),
        export: judge(&mut exported),
        model: judge(&mut |row| (row.tool, row.tool.inverse().apply(&row.point))),
        rows: rows.len(),
        drawn_from: reference.drawn_from,
        measured,
    }
}

/// The tool of a robot at a row, and the row's target on it.
pub(super) fn of_chain(chain: &Chain, row: &Row) -> (Pose, Vector3<f64>) {
    let target = row.target.and_then(|t| chain.targets().get(t.0));
    (
        chain.forward_to(row.conditions.tool, &row.conditions.joints),
        target.map_or(Vector3::zeros(), |target| target.position),
    )
}

/// A row as one robot has it.
struct Seen {
    tool: Pose,
    point: Vector3<f64>,
    /// The target, where it was declared unknown.
    free: Option<usize>,
    wanted: Vector3<f64>,
}

fn rms(rows: &[Seen]) -> f64 {
    let sum: f64 = rows.iter().map(|row| (row.wanted - row.tool.apply(&row.point)).norm_squared()).sum();
    (sum / rows.len().max(1) as f64).sqrt()
}

fn accuracy(mut rows: Vec<Seen>, targets: usize) -> Accuracy {
    let as_written = rms(&rows);
    let mut aligned = as_written;
    for _ in 0..ROUNDS {
        align(&mut rows, targets);
        let now = rms(&rows);
        if now.is_nan() || now >= aligned * (1.0 - 1e-12) {
            aligned = if now < aligned { now } else { aligned };
            break;
        }
        aligned = now;
    }
    Accuracy { as_written, aligned }
}

const ROUNDS: usize = 20;
/// Directions of smaller eigenvalues, of the largest, are not determined: they stay.
const DETERMINED: f64 = 1e-12;

/// One step of Gauss and Newton over base, tool and free targets.
fn align(rows: &mut [Seen], targets: usize) {
    let count = rows.len().max(1) as f64;
    let centre = rows.iter().map(|row| row.wanted).sum::<Vector3<f64>>() / count;
    let spread = rows.iter().map(|row| (row.wanted - centre).norm_squared()).sum::<f64>() / count;
    let reach = rows.iter().map(|row| row.point.norm_squared()).sum::<f64>() / count;
    // Turns move points as far as shifts do.
    let (wide, long) = (spread.sqrt().max(1e-3), reach.sqrt().max(1e-3));
    let size = 12 + 3 * targets;
    let (mut gram, mut right) = (DMatrix::zeros(size, size), DVector::zeros(size));
    let mut block = DMatrix::zeros(3, size);
    for row in rows.iter() {
        let at = row.tool.apply(&row.point);
        block.fill(0.0);
        let mut put =
            |column: usize, part: &Matrix3<f64>| block.view_mut((0, column), (3, 3)).copy_from(part);
        put(0, &Matrix3::identity());
        put(3, &(-skew(&(at - centre)) / wide));
        put(6, &row.tool.rotation);
        put(9, &(-row.tool.rotation * skew(&row.point) / long));
        if let Some(target) = row.free {
            put(12 + 3 * target, &row.tool.rotation);
        }
        gram.gemm_tr(1.0, &block, &block, 1.0);
        let gap = row.wanted - at;
        right.gemv_tr(1.0, &block, &DVector::from_column_slice(gap.as_slice()), 1.0);
    }
    let parts = gram.symmetric_eigen();
    let largest = parts.eigenvalues.amax();
    let mut along = parts.eigenvectors.tr_mul(&right);
    for (value, &eigenvalue) in along.iter_mut().zip(&parts.eigenvalues) {
        *value = if eigenvalue > DETERMINED * largest { *value / eigenvalue } else { 0.0 };
    }
    let step = parts.eigenvectors * along;
    let three = |k: usize| Vector3::new(step[k], step[k + 1], step[k + 2]);
    let turn = rotation_vector(&(three(3) / wide));
    let base = Pose::new(turn, centre + three(0) - turn * centre);
    let tool = rotation_vector(&(three(9) / long));
    for row in rows {
        row.tool = base * row.tool;
        row.point =
            tool * row.point + three(6) + row.free.map_or(Vector3::zeros(), |target| three(12 + 3 * target));
    }
}
