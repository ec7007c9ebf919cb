//! A camera in the cell, and the tool of unknown place whose targets it sees.
//!
//! ```text
//! z = π(K⁻¹ F T p),     C_i = T⁻¹ F_i⁻¹ K        with C_i the camera beside the targets, by image i: hand and eye
//! T ← T (1 + δ)         ∂z/∂δ = H R_F R_T [1, −[p]×]
//! ```
//!
//! | symbol | here | unit | frame |
//! | --- | --- | --- | --- |
//! | K | the camera | m | measurement |
//! | F, T | the flange; the tool on it | m | measurement, flange |
//! | p, z | a target, and where it was seen; H: derivative of the pixels by its place | m, px; px/m | tool |
//!
//! With the nominal robot: a start, from which the fit goes on. Images of small tags have two poses that differ by little, and where the wrong one was
//! taken hand and eye are wrong by that; so camera and tool are then fitted to all pixels together.

use super::hand_eye::by_images;
use super::sensors::Sensors;
use crate::IdentifyError;
use nalgebra::{DMatrix, DVector, Matrix3, RowVector3, Vector3};
use std::any::Any;
use truepose_errormodel::Dataset;
use truepose_errormodel::descent::{Schedule, descend, relative_gain};
use truepose_errormodel::observation::{Camera, Observation, Reading};
use truepose_kinematics::{Chain, Placed, Pose, rotation_vector, skew};

const SCHEDULE: Schedule = Schedule {
    first: 1e-3,
    good: (0.1, 1e-12),
    bad: (10.0, 1e9),
    steps: 100,
    patience: (2, usize::MAX),
    flat: 1e-10,
    gain: relative_gain,
};

/// A target that was seen: the flange, the target on the tool, and the pixels.
struct Sight {
    flange: Pose,
    target: Vector3<f64>,
    pixels: Vec<f64>,
}

/// Camera and tool, what is left of the pixels, and its derivatives.
type State = (Camera, Pose, DVector<f64>, DMatrix<f64>);

/// The robot with its tool where a camera in the cell sees the targets of known place on it, and that camera; `at` are the targets, one a row. As it is
/// where no image has four of them.
pub(super) fn with_tool(
    (chain, data): (&Chain, &Dataset),
    images: &[usize],
    sensors: &mut Sensors,
    at: &[Pose],
) -> Result<Chain, IdentifyError> {
    let target = |row: usize| {
        let target = chain.targets().get(data.target[row]?.0)?;
        target.known.then_some(target.position)
    };
    let tool = chain.tool().pose;
    let flange = |row: usize| {
        let off = Pose::new(Matrix3::identity(), target(row).unwrap_or_default());
        at[row] * (tool * off).inverse()
    };
    let found = by_images((sensors, "tool"), images, &target, &|row| flange(row).inverse())?;
    let Some((sensor, beside)) = found else { return Ok(chain.clone()) };
    let sight = |row: usize| {
        let target = target(row)?;
        Some(Sight { flange: flange(row), target, pixels: sensors.numbers(row).to_vec() })
    };
    let sights: Vec<Sight> = sensors.first_rows(sensor).filter_map(sight).collect();
    let mut pose = beside.inverse();
    if let Some(camera) = sensors.found[sensor].camera()
        && let Some((camera, tool)) = together(camera, pose, &sights)
    {
        pose = tool;
        let place = camera.place;
        let described = sensors.found[sensor].camera().cloned();
        sensors.found[sensor].observation = Box::new(Camera { place, ..described.unwrap_or(camera) });
    }
    let placed = chain.clone().map_tools(|tool| Placed { pose, ..*tool });
    placed.map_err(|error| IdentifyError::Landmark { name: "tool".into(), why: error.to_string() })
}

fn together(camera: &Camera, tool: Pose, sights: &[Sight]) -> Option<(Camera, Pose)> {
    let held = Camera { free_intrinsics: false, ..camera.clone() };
    let start = seen(held, tool, sights)?;
    let cost = start.2.norm_squared();
    let propose = |(camera, tool, right, rows): &State, damping: f64| {
        let mut normal = rows.tr_mul(rows);
        let largest = normal.diagonal().amax();
        for k in 0..normal.nrows() {
            normal[(k, k)] += damping * normal[(k, k)] + 1e-14 * largest;
        }
        let step = normal.cholesky()?.solve(&rows.tr_mul(right));
        let own = step.len() - 6;
        let three = |k: usize| Vector3::new(step[own + k], step[own + k + 1], step[own + k + 2]);
        let moved = camera.moved(&step.as_slice()[..own]);
        let camera = (&*moved as &dyn Any).downcast_ref::<Camera>()?.clone();
        Some(match seen(camera, *tool * Pose::new(rotation_vector(&three(3)), three(0)), sights) {
            Some(next) => {
                let cost = next.2.norm_squared();
                (Some(next), cost)
            }
            None => (None, f64::INFINITY),
        })
    };
    // A step that is accepted has a finite cost.
    let start = (Some(start), cost);
    let propose = |at: &Option<State>, damping: f64| propose(at.as_ref()?, damping);
    let (camera, tool, ..) = descend(start, &SCHEDULE, propose, |next| next).0?;
    Some((camera, tool))
}

/// All sights from here; none where one is behind the camera.
fn seen(camera: Camera, tool: Pose, sights: &[Sight]) -> Option<State> {
    let mut reading = Reading::default();
    let (mut right, mut rows): (Vec<f64>, Vec<Vec<f64>>) = (Vec::new(), Vec::new());
    for sight in sights {
        let carried = sight.flange * tool;
        let at = Pose::new(Matrix3::identity(), carried.apply(&sight.target));
        if !camera.read(&at, &mut reading) {
            return None;
        }
        for (k, pixel) in sight.pixels.iter().enumerate().take(reading.value.len()) {
            right.push(pixel - reading.value[k]);
            let [x, y, z, ..] = reading.by_pose[k];
            let shift = RowVector3::new(x, y, z) * carried.rotation;
            let turn = -shift * skew(&sight.target);
            rows.push(reading.by_own[k].iter().chain(shift.iter()).chain(turn.iter()).copied().collect());
        }
    }
    let columns = rows.first()?.len();
    let rows = DMatrix::from_fn(rows.len(), columns, |i, k| rows[i][k]);
    Some((camera, tool, DVector::from_vec(right), rows))
}
