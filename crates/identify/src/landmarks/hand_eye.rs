//! Where a camera on the robot and the base are, from images alone: hand-eye.
//!
//! ```text
//! C_i = Z F_i X,   F_ij X = X C_ij       log R(C_ij) = R_Xᵀ log R(F_ij),   (R(F_ij) − 1) t_X = R_X t(C_ij) − t(F_ij)
//! ```
//!
//! | symbol | here | unit | frame |
//! | --- | --- | --- | --- |
//! | C_i, F_i | the camera in image i by its points; the tool from the base | m | measurement, base |
//! | X | the camera on the tool | m | tool |
//! | Z | the base of the robot | m | measurement |
//!
//! With the nominal robot (Park and Martin 1994; Shah 2013): a start, from which the fit goes on.

use super::carried::Carried;
use super::sensors::Sensors;
use crate::IdentifyError;
use nalgebra::{DMatrix, DVector, Matrix3, Vector3};
use std::any::Any;
use std::collections::BTreeMap;
use truepose_errormodel::observation::{Camera, Observation, Seen};
use truepose_kinematics::{Chain, Placed, Pose, nearest_rotation, rotation_log};

/// Points of one image that determine where its camera was.
const POINTS: usize = 4;
/// A least turn between images, rad, below which noise makes its axis.
const TURN: f64 = 0.05;

/// The robot with its base where the images say it stands, and the cameras on it, with the tools where they are now (one a row).
pub(super) fn with_base(
    carried: &Carried,
    chain: &Chain,
    sensors: &mut Sensors,
    at: &[Pose],
) -> Result<Chain, IdentifyError> {
    let from = chain.base().pose.inverse();
    let point = |row: usize| carried.point(row);
    let found = by_images((sensors, "base"), &carried.images, &point, &|row| from * at[row])?;
    let Some((_, pose)) = found else { return Ok(chain.clone()) };
    let placed = chain.clone().with_base(Placed { pose, ..*chain.base() });
    let name = "cameras on the robot".to_owned();
    placed.map_err(|error| IdentifyError::Landmark { name, why: error.to_string() })
}

/// Z, where `other` is, with the camera that shows it in most images; and every camera at its X, from images (one number a row) with four points of known
/// place at least. None without any such image.
pub(super) fn by_images(
    (sensors, other): (&mut Sensors, &str),
    of_row: &[usize],
    point: &dyn Fn(usize) -> Option<Vector3<f64>>,
    carrier: &dyn Fn(usize) -> Pose,
) -> Result<Option<(usize, Pose)>, IdentifyError> {
    let mut best: Option<(usize, (usize, Pose))> = None;
    for sensor in 0..sensors.found.len() {
        let rows: Vec<usize> = sensors.first_rows(sensor).filter(|&row| point(row).is_some()).collect();
        let found = &sensors.found[sensor];
        let Some(camera) = found.camera().filter(|_| !rows.is_empty()) else { continue };
        let mut images: BTreeMap<usize, Vec<usize>> = BTreeMap::new();
        for &row in &rows {
            images.entry(of_row[row]).or_default().push(row);
        }
        let mut pairs: Vec<(Pose, Pose)> = Vec::new();
        let (mut many, mut refused) = (0, None);
        let free = Camera { place: None, known: false, free_intrinsics: false, ..camera.clone() };
        for rows in images.values().filter(|rows| rows.len() >= POINTS) {
            let point = |row: usize| Pose::new(Matrix3::identity(), point(row).unwrap_or_default());
            let seen: Vec<Seen> =
                rows.iter().map(|&row| (point(row), sensors.numbers(row).to_vec())).collect();
            many += 1;
            match free.started(&seen) {
                Ok(found) => {
                    let camera = (&*found as &dyn Any).downcast_ref::<Camera>();
                    pairs.extend(
                        camera.and_then(|camera| camera.place).map(|place| (place, carrier(rows[0]))),
                    );
                }
                Err(reason) => refused = Some(reason),
            }
        }
        let why = |why: &str| IdentifyError::Landmark { name: found.name.clone(), why: why.into() };
        if let Some(reason) = refused.filter(|_| 2 * pairs.len() < many) {
            return Err(why(&format!("in {} of {many} images: {reason}", many - pairs.len())));
        }
        let (place, found) = hand_eye(&pairs).ok_or_else(|| {
            why(&format!("where camera and {other} are is not determined: three images of four known points each at least, with the camera turned about two axes between them"))
        })?;
        if !camera.known {
            let camera = Camera { place: Some(place), ..camera.clone() };
            sensors.found[sensor].observation = Box::new(camera);
        }
        if best.is_none_or(|(count, _)| pairs.len() > count) {
            best = Some((pairs.len(), (sensor, found)));
        }
    }
    Ok(best.map(|(_, found)| found))
}

/// X and Z of images: where the camera was in the measurement frame, and the tool in that of the base.
fn hand_eye(pairs: &[(Pose, Pose)]) -> Option<(Pose, Pose)> {
    let mut cross = Matrix3::zeros();
    let mut moves = Vec::new();
    for (i, (c, f)) in pairs.iter().enumerate() {
        for (c2, f2) in &pairs[i + 1..] {
            let (camera, tool) = (c.inverse() * *c2, f.inverse() * *f2);
            let (a, b) = (rotation_log(&tool.rotation), rotation_log(&camera.rotation));
            if a.norm() > TURN && a.norm() < 3.0 {
                cross += a * b.transpose();
                moves.push((camera, tool));
            }
        }
    }
    let svd = cross.svd(true, true);
    let mut sizes: [f64; 3] = svd.singular_values.into();
    sizes.sort_by(|a, b| b.total_cmp(a));
    // Turns about one axis only leave the turn about it open.
    if moves.len() < 2 || sizes[1] < 1e-3 * sizes[0] {
        return None;
    }
    let turn = nearest_rotation(&cross)?;
    let a = DMatrix::from_fn(3 * moves.len(), 3, |row, k| {
        moves[row / 3].1.rotation[(row % 3, k)] - f64::from(u8::from(row % 3 == k))
    });
    let b = DVector::from_fn(3 * moves.len(), |row, _| {
        let (camera, tool) = &moves[row / 3];
        (turn * camera.translation - tool.translation)[row % 3]
    });
    let shift = a.svd(true, true).solve(&b, 1e-9).ok()?;
    let mount = Pose::new(turn, Vector3::new(shift[0], shift[1], shift[2]));
    let bases: Vec<Pose> = pairs.iter().map(|(c, f)| *c * mount.inverse() * f.inverse()).collect();
    let rotation = nearest_rotation(&bases.iter().map(|base| base.rotation).sum())?;
    let place = bases.iter().map(|base| base.translation).sum::<Vector3<f64>>() / bases.len() as f64;
    Some((mount, Pose::new(rotation, place)))
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn camera_and_base_are_found_from_images_of_a_robot_that_turns_about_several_axes() {
        let (mount, base) = (
            Pose::from_xyz_rpy([0.03, -0.05, 0.1], [0.2, -0.1, 2.0]),
            Pose::from_xyz_rpy([1.0, 2.0, -0.5], [0.1, 3.0, -1.0]),
        );
        let tool = |k: f64| {
            Pose::from_xyz_rpy([0.4 + 0.1 * k, 0.2 * k.sin(), 0.5], [0.3 * k.cos(), 0.4 * k.sin(), 0.2 * k])
        };
        let pairs: Vec<(Pose, Pose)> =
            (0..6).map(|k| tool(f64::from(k))).map(|f| (base * f * mount, f)).collect();
        let (x, z) = hand_eye(&pairs).unwrap();
        for (found, truth) in [(x, mount), (z, base)] {
            assert!((found.translation - truth.translation).norm() < 1e-9);
            assert!((found.rotation - truth.rotation).amax() < 1e-9);
        }
        // About one axis only, the place along it is open.
        let about = |k: f64| Pose::rot(2, 0.3 * k) * Pose::trans(0, 0.4);
        let pairs: Vec<(Pose, Pose)> =
            (0..6).map(|k| about(f64::from(k))).map(|f| (base * f * mount, f)).collect();
        assert!(hand_eye(&pairs).is_none());
    }
}
