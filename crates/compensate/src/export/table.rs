//! The corrected axes as a table of four numbers a link: Denavit and Hartenberg, modified (Craig), or Hayati.
//!
//! ```text
//! T(q) = base · Z(q_1) L_1 · Z(q_2) L_2 · … · Z(q_n) · tool          Z(q): turn about, or slide along, z
//! L_i  = Rz(θ) Tz(d) Tx(a) Rx(α)              common normal                    (dh; mdh shifts the cut by half a link)
//! L_i  = Rz(θ) Tx(a) Rx(α) Ry(β)              nearly parallel axes             (Hayati)
//! ```
//!
//! | symbol | here | unit | |
//! | --- | --- | --- | --- |
//! | θ, d, a, α | [`AxisLink::Common`] | rad, m, m, rad | d = distance along z to the common normal |
//! | θ, a, α, β | [`AxisLink::Hayati`] | rad, m, rad, rad | the next axis met in the plane through this origin |
//!
//! Between axes that are parallel to within an angle φ, the common normal lies anywhere: d grows as 1/φ. There Hayati's
//! parameter stands in for d, or the table is refused. Source: Hayati and Mirmirani 1985; Denavit and Hartenberg 1955.

use super::comparison::of_chain;
use super::geometry::{corrected_chain, split};
use super::options::ExportOptions;
use super::origins::placed;
use super::reference::Reference;
use super::remaining::{Exported, judged};
use crate::CompensateError;
use nalgebra::{Rotation3, Unit, Vector3};
use truepose_errormodel::FittedModel;
use truepose_kinematics::{Chain, Joint, JointId, Placed, Placement, Pose};

/// From one axis to the next.
#[derive(Debug, Clone, Copy, PartialEq)]
pub enum AxisLink {
    /// `Rz(θ) Tz(d) Tx(a) Rx(α)`.
    Common {
        /// θ, rad.
        theta: f64,
        /// d, m.
        d: f64,
        /// a, m.
        a: f64,
        /// α, rad.
        alpha: f64,
    },
    /// `Rz(θ) Tx(a) Rx(α) Ry(β)`.
    Hayati {
        /// θ, rad.
        theta: f64,
        /// a, m.
        a: f64,
        /// α, rad.
        alpha: f64,
        /// β, rad.
        beta: f64,
    },
}

impl AxisLink {
    /// As a transform.
    pub fn pose(&self) -> Pose {
        match *self {
            AxisLink::Common { theta, d, a, alpha } => {
                Pose::rot(2, theta) * Pose::trans(2, d) * Pose::trans(0, a) * Pose::rot(0, alpha)
            }
            AxisLink::Hayati { theta, a, alpha, beta } => {
                Pose::rot(2, theta) * Pose::trans(0, a) * Pose::rot(0, alpha) * Pose::rot(1, beta)
            }
        }
    }
}

/// One movable joint and the link behind it.
#[derive(Debug, Clone, PartialEq)]
pub struct AxisRow {
    /// The joint.
    pub joint: JointId,
    /// To the next axis; none behind the last one, where the tool's pose begins.
    pub link: Option<AxisLink>,
}

/// The table.
#[derive(Debug, Clone, PartialEq)]
pub struct AxisTable {
    /// Measurement frame to the first axis, along z.
    pub base: Pose,
    /// One a movable joint.
    pub rows: Vec<AxisRow>,
    /// Last axis to the tool.
    pub tool: Pose,
    /// The targets, m, in the tool's axes.
    pub targets: Vec<Vector3<f64>>,
}

/// What a table may contain.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct AxisTableOptions {
    /// Whether Hayati's parameter may stand in for d where axes are nearly parallel; else the table is refused.
    pub hayati: bool,
    /// Angle between axes below which they are taken to be nearly parallel, rad.
    pub parallel: f64,
    /// Lengths beyond so many characteristic lengths of the robot are absurd.
    pub absurd: f64,
}

impl Default for AxisTableOptions {
    fn default() -> Self {
        AxisTableOptions { hayati: true, parallel: 0.02, absurd: 3.0 }
    }
}

impl AxisTable {
    /// The same robot as a chain of origins and axes, with names and limits of the one given.
    ///
    /// # Errors
    /// When the given robot has other joints.
    pub fn to_chain(&self, like: &Chain) -> Result<Chain, CompensateError> {
        let mut before = Pose::IDENTITY;
        let mut joints = Vec::new();
        for row in &self.rows {
            let described = like.joint(row.joint);
            joints.push(Joint {
                placement: Placement::Origin { pose: before, axis: Vector3::z_axis() },
                link: None,
                ..described.clone()
            });
            before = row.link.map_or(Pose::IDENTITY, |link| link.pose());
        }
        Ok(Chain::new(like.name(), joints)?
            .coupled_as(like)?
            .with_base(Placed { pose: self.base, known: true })?
            .with_tool(Placed { pose: before * self.tool, known: true })?
            .with_targets(placed(like, &self.targets))?)
    }
}

/// The table of a fitted robot's axes.
///
/// # Errors
/// [`CompensateError::ParallelAxes`] where only absurd numbers would do and Hayati's parameter is not allowed;
/// [`CompensateError::AbsurdLength`] where even that does not help.
pub fn axis_table(
    fitted: &FittedModel,
    options: &ExportOptions,
    allow: &AxisTableOptions,
) -> Result<Exported<AxisTable>, CompensateError> {
    if !fitted.chain().is_serial() {
        return Err(CompensateError::Branches { what: "tables of axes" });
    }
    let exported = corrected_chain(fitted, options)?;
    let chain = &exported.value;
    let table = table_of(chain, allow)?;
    let read_back = table.to_chain(chain)?;
    let reference = Reference::of(fitted, options)?;
    let (remaining_error, comparison) = judged(fitted, &reference, |row| of_chain(&read_back, row))?;
    Ok(Exported { value: table, left_out: exported.left_out, remaining_error, comparison })
}

fn table_of(chain: &Chain, allow: &AxisTableOptions) -> Result<AxisTable, CompensateError> {
    // Every axis at q = 0: a frame with z along it.
    let mut pose = chain.base().pose;
    let mut axes: Vec<(JointId, Pose)> = Vec::new();
    for index in 0..chain.joints().len() {
        let id = JointId(index + 1);
        let (pre, post, axis) = split(chain, id);
        pose = pose * pre;
        if chain.joint(id).moves() {
            axes.push((id, pose * Pose::new(z_to(&axis), Vector3::zeros())));
        }
        pose = pose * post;
    }
    let end = pose * chain.tool().pose;
    let Some(&(_, base)) = axes.first() else {
        return Err(CompensateError::Geometry(truepose_kinematics::ChainError::NothingMoves));
    };
    let size = chain.characteristic_length();
    let mut here = base;
    let mut rows = Vec::new();
    for (k, &(joint, _)) in axes.iter().enumerate() {
        let link = match axes.get(k + 1) {
            None => None,
            Some((next_id, next)) => {
                let names = (chain.joint(joint).name.as_str(), chain.joint(*next_id).name.as_str());
                let link = link_to(&(here.inverse() * *next), size, allow, names)?;
                here = here * link.pose();
                Some(link)
            }
        };
        rows.push(AxisRow { joint, link });
    }
    let targets = chain.targets().iter().map(|target| target.position).collect();
    Ok(AxisTable { base, rows, tool: here.inverse() * end, targets })
}

/// The link that leads from z to the z axis of `next`.
fn link_to(
    next: &Pose,
    size: f64,
    allow: &AxisTableOptions,
    (first, second): (&str, &str),
) -> Result<AxisLink, CompensateError> {
    let u: Vector3<f64> = next.rotation.column(2).into();
    let p = next.translation;
    let sine = u.xy().norm();
    let link = if sine < allow.parallel {
        if !allow.hayati {
            let offset_m = p.z + u.xy().dot(&-p.xy()) * u.z / (sine * sine).max(1e-300);
            if offset_m.abs() > allow.absurd * size {
                let (first, second) = (first.to_owned(), second.to_owned());
                return Err(CompensateError::ParallelAxes {
                    first,
                    second,
                    angle_rad: sine.asin(),
                    offset_m,
                });
            }
            common(&u, &p)
        } else {
            // Where the next axis meets the plane z = 0, and its direction seen from there.
            let met = p - u * (p.z / u.z);
            let theta = if met.xy().norm() > 1e-9 * size { met.y.atan2(met.x) } else { 0.0 };
            let turned = Pose::rot(2, -theta).rotation * u;
            // Rx(α) Ry(β) ẑ = [sin β, −sin α cos β, cos α cos β]
            let (beta, alpha) = (turned.x.clamp(-1.0, 1.0).asin(), (-turned.y).atan2(turned.z));
            AxisLink::Hayati { theta, a: met.xy().norm(), alpha, beta }
        }
    } else {
        common(&u, &p)
    };
    let lengths = match link {
        AxisLink::Common { d, a, .. } => [("d", d), ("a", a)],
        AxisLink::Hayati { a, .. } => [("a", a), ("a", a)],
    };
    for (what, value_m) in lengths {
        if value_m.is_nan() || value_m.abs() > allow.absurd * size {
            return Err(CompensateError::AbsurdLength {
                joint: first.to_owned(),
                what,
                value_m,
                size_m: size,
            });
        }
    }
    Ok(link)
}

/// By the common normal of z and the line through p along u.
fn common(u: &Vector3<f64>, p: &Vector3<f64>) -> AxisLink {
    let sine2 = u.xy().norm_squared();
    if sine2 < 1e-300 {
        return AxisLink::Common {
            theta: p.y.atan2(p.x),
            d: p.z,
            a: p.xy().norm(),
            alpha: if u.z > 0.0 { 0.0 } else { std::f64::consts::PI },
        };
    }
    // Foot of the common normal on the next axis: the point of it nearest to z.
    let foot = p - u * (u.xy().dot(&p.xy()) / sine2);
    let normal = Vector3::new(-u.y, u.x, 0.0) / sine2.sqrt();
    let a = normal.dot(&foot);
    // Of the two directions the one with a ≥ 0, or for crossing axes with θ within a quarter turn.
    let flip = if a.abs() > 1e-6 { a < 0.0 } else { normal.x < 0.0 };
    let sign = if flip { -1.0 } else { 1.0 };
    let x = normal * sign;
    // α from z to u about x.
    let alpha = (Vector3::z().cross(u).dot(&x)).atan2(u.z);
    AxisLink::Common { theta: x.y.atan2(x.x), d: foot.z, a: a * sign, alpha }
}

/// A rotation that takes z to the axis; the identity, exactly, when it is z.
fn z_to(axis: &Unit<Vector3<f64>>) -> nalgebra::Matrix3<f64> {
    if *axis == Vector3::z_axis() {
        nalgebra::Matrix3::identity()
    } else {
        Rotation3::rotation_between(&Vector3::z(), axis)
            .map_or(Pose::rot(0, std::f64::consts::PI).rotation, |r| r.into_inner())
    }
}
