//! Measured orientations against those of the placed robot, and as what else they may have been meant.
//!
//! `R_k ≈ O_k R_T`, `O_k` from the base as the positions place it, `R_T` the rotation of the tool that fits best.

use super::misread::{GAIN, Misread, Misreading, TURNED, better};
use nalgebra::{Matrix3, Vector3};
use std::f64::consts::{PI, TAU};
use truepose_errormodel::Dataset;
use truepose_kinematics::{Chain, Placed, Pose, rotation_log, rotation_vector};

/// Rows that are looked at.
const ROWS: usize = 300;
/// Rows from which a start is taken.
const STARTS: usize = 12;

/// RMS of the angle between measured and nominal orientations with the best rotation of the tool, rad; none without orientations.
pub(super) fn rms(chain: &Chain, data: &Dataset) -> Option<f64> {
    let rows = rows(chain, data);
    left(&rows.iter().map(|(nominal, measured)| (*nominal, vec![*measured])).collect::<Vec<_>>())
}

/// The likely other convention of the orientations.
pub(super) fn misread(chain: &Chain, data: &Dataset) -> Option<Misread> {
    let rows = rows(chain, data);
    let with = |other: &dyn Fn(&Matrix3<f64>) -> Vec<Matrix3<f64>>| {
        left(&rows.iter().map(|(nominal, measured)| (*nominal, other(measured))).collect::<Vec<_>>())
    };
    let before = with(&|measured| vec![*measured])?;
    let mut tried = Vec::new();
    for (convention, compose) in CONVENTIONS {
        tried.push((Misreading::Angles { convention }, with(&|r| vectors(r).map(compose).collect())));
    }
    for (given, _) in CONVENTIONS.iter().enumerate() {
        for (meant, (convention, compose)) in CONVENTIONS.iter().enumerate() {
            if given != meant
                && let Some(angles) = ANGLES[given]
            {
                let after = with(&|r| both(angles(r)).into_iter().map(compose).collect());
                tried.push((Misreading::OtherAngles { convention }, after));
            }
        }
        if let Some(angles) = ANGLES[given] {
            let vector = |angles: [f64; 3]| rotation_vector(&Vector3::from(angles));
            let after = with(&|r| both(angles(r)).into_iter().map(vector).collect());
            tried.push((Misreading::RotationVector, after));
        }
    }
    tried.push((Misreading::InverseOrientation, with(&|r| vec![r.transpose()])));
    let last = |r: &Matrix3<f64>| {
        let [w, x, y, z] = Pose::new(*r, Vector3::zeros()).quaternion();
        // Read as (w, x, y, z), meant as (x, y, z, w).
        vec![Pose::rotation_from_quaternion([z, w, x, y])]
    };
    tried.push((Misreading::ScalarLast, with(&last)));
    let mut best: Option<Misread> = None;
    for (what, after) in tried {
        if let Some(after) = after.filter(|&after| after < GAIN * before && after < TURNED) {
            better(&mut best, Misread { what, before, after });
        }
    }
    best
}

/// The two sets of three angles of one rotation: the middle one may be beyond a quarter turn. Of all conventions whose axes differ.
fn both([a, b, c]: [f64; 3]) -> [[f64; 3]; 2] {
    let half = |v: f64| if v > 0.0 { v - PI } else { v + PI };
    [[a, b, c], [half(a), half(-b), half(c)]]
}

type Compose = fn([f64; 3]) -> Matrix3<f64>;
type Decompose = fn(&Matrix3<f64>) -> [f64; 3];

/// Words of conventions in files, and the rotation of three angles.
const CONVENTIONS: [(&str, Compose); 4] = [
    ("rpy", |[a, b, c]| turn(2, c) * turn(1, b) * turn(0, a)),
    ("abc", |[a, b, c]| turn(2, a) * turn(1, b) * turn(0, c)),
    ("xyz", |[a, b, c]| turn(0, a) * turn(1, b) * turn(2, c)),
    ("zyz", |[a, b, c]| turn(2, a) * turn(1, b) * turn(2, c)),
];

/// The angles of a rotation in the conventions that have one set of them.
const ANGLES: [Option<Decompose>; 4] = [
    Some(|r| Pose::new(*r, Vector3::zeros()).rpy()),
    Some(|r| {
        let [a, b, c] = Pose::new(*r, Vector3::zeros()).rpy();
        [c, b, a]
    }),
    Some(|r| {
        // Rx(a) Ry(b) Rz(c) is the transpose of Rz(−c) Ry(−b) Rx(−a).
        Pose::new(r.transpose(), Vector3::zeros()).rpy().map(|angle| -angle)
    }),
    None,
];

fn turn(axis: usize, angle: f64) -> Matrix3<f64> {
    Pose::rot(axis, angle).rotation
}

/// Rotation vectors of a rotation: three angles may add up to more than half a turn.
fn vectors(r: &Matrix3<f64>) -> impl Iterator<Item = [f64; 3]> + use<> {
    let v = rotation_log(r);
    let norm = v.norm();
    let others = [0.0, -TAU, TAU].map(|by| if norm > 1e-9 { v * (1.0 + by / norm) } else { v });
    // No angle is beyond half a turn to either side, or a whole one where angles count from zero.
    others.into_iter().filter(|v| v.amax() <= TAU + 1e-9 && v.norm() <= 3.0 * PI).map(|v| [v.x, v.y, v.z])
}

/// Nominal orientations without the tool, and measured ones.
fn rows(chain: &Chain, data: &Dataset) -> Vec<(Matrix3<f64>, Matrix3<f64>)> {
    let bare = chain.clone().with_tool(Placed::default());
    let bare = bare.as_ref().unwrap_or(chain);
    let measured: Vec<usize> = (0..data.len()).filter(|&row| data.orientation[row].is_some()).collect();
    let step = measured.len().div_ceil(ROWS).max(1);
    let one = |&row: &usize| {
        let joints: Vec<f64> = data.joints.iter().map(|column| column[row]).collect();
        Some((bare.forward(&joints).rotation, data.measured_rotation(row)?))
    };
    measured.iter().step_by(step).filter_map(one).collect()
}

/// RMS of the angles with the best tool, each row read as that of its candidates that fits best; none with too few rows.
fn left(rows: &[(Matrix3<f64>, Vec<Matrix3<f64>>)]) -> Option<f64> {
    if rows.len() < 3 {
        return None;
    }
    let nearest = |tool: &Matrix3<f64>, (nominal, read): &(Matrix3<f64>, Vec<Matrix3<f64>>)| {
        let wanted = nominal * tool;
        let angle = |r: &Matrix3<f64>| rotation_log(&(wanted.transpose() * r)).norm();
        read.iter().map(|r| (angle(r), nominal.transpose() * r)).min_by(|a, b| a.0.total_cmp(&b.0))
    };
    let rms = |tool: &Matrix3<f64>| {
        let squares: f64 =
            rows.iter().filter_map(|row| nearest(tool, row)).map(|(angle, _)| angle * angle).sum();
        (squares / rows.len() as f64).sqrt()
    };
    let starts = rows.iter().step_by(rows.len().div_ceil(STARTS));
    let mut best: Option<(f64, Matrix3<f64>)> = None;
    for tool in starts.flat_map(|(nominal, read)| read.iter().map(move |r| nominal.transpose() * r)) {
        let found = rms(&tool);
        if best.as_ref().is_none_or(|(least, _)| found < *least) {
            best = Some((found, tool));
        }
    }
    let (mut least, mut tool) = best?;
    for _ in 0..3 {
        let sum: Matrix3<f64> = rows.iter().filter_map(|row| nearest(&tool, row)).map(|(_, r)| r).sum();
        let svd = sum.svd(true, true);
        let (Some(u), Some(v)) = (svd.u, svd.v_t) else { break };
        let sign = (u * v).determinant().signum();
        tool = u * Matrix3::from_diagonal(&Vector3::new(1.0, 1.0, sign)) * v;
        least = least.min(rms(&tool));
    }
    Some(least)
}
