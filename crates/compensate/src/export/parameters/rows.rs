//! Values of a description as a table of named numbers.

use super::super::geometry::split;
use super::described::{Described, Form};
use super::{JointOffset, Parameter, ParameterPart, ParameterTable, PartKind};
use nalgebra::{DMatrix, Vector3};
use std::f64::consts::{PI, TAU};
use truepose_kinematics::{Axis, Chain, JointId, JointKind, Placement, Pose, Site, TargetId};

const ROW: [(&str, &str); 5] = [("theta", "rad"), ("d", "m"), ("a", "m"), ("alpha", "rad"), ("beta", "rad")];
const PLACE: [(&str, &str); 6] =
    [("x", "m"), ("y", "m"), ("z", "m"), ("roll", "rad"), ("pitch", "rad"), ("yaw", "rad")];
/// Steps of differences, m and rad.
const STEP: f64 = 1e-6;

/// A solution with its covariance.
pub(super) struct Found<'a> {
    pub described: &'a Described<'a>,
    /// Changes of all numbers.
    pub values: &'a [f64],
    pub kept: &'a [usize],
    /// Covariance of the changes.
    pub spread: &'a DMatrix<f64>,
    /// Covariance of the constants of all sites.
    pub constants: &'a DMatrix<f64>,
}

impl Found<'_> {
    pub fn table(&self, chain: Chain) -> ParameterTable {
        let nominal = self.described.chain;
        let last = self.described.parts.len() - 1;
        let mut parts = Vec::new();
        let mut offsets = Vec::new();
        for (part, form) in self.described.parts.iter().enumerate() {
            let (name, kind, known) = match part {
                0 => ("base", PartKind::Base, nominal.base().known),
                _ if part == last => ("tool", PartKind::Tool, nominal.tool().known),
                _ => {
                    let joint = JointId(part);
                    let kind = match nominal.joint(joint).placement {
                        Placement::Dh { .. } => PartKind::Dh(joint),
                        Placement::Mdh { .. } => PartKind::Mdh(joint),
                        Placement::Origin { .. } => PartKind::Origin(joint),
                    };
                    (nominal.joint(joint).name.as_str(), kind, true)
                }
            };
            let parameters = match form {
                Form::Still(_) => continue,
                Form::Placed(pose) => self.placed(part, pose, known),
                Form::Dh(row) | Form::Mdh(row) => self.row(part, row),
            };
            if part != 0 && part != last {
                offsets.push(self.offset(part));
            }
            parts.push(ParameterPart { name: name.into(), kind, parameters });
        }
        parts.extend((0..chain.targets().len()).map(|k| self.target(&chain, TargetId(k))));
        ParameterTable { parts, offsets, chain }
    }

    fn sd(&self, number: usize) -> f64 {
        resolved(self.spread[(number, number)])
    }

    fn row(&self, part: usize, row: &[f64; 5]) -> Vec<Parameter> {
        let changes = self.described.of(part, self.values);
        let one = |k: usize| Parameter {
            name: ROW[k].0,
            unit: ROW[k].1,
            nominal: Some(row[k]),
            calibrated: row[k] + changes[k],
            standard_uncertainty: self.sd(self.described.place(part, k)),
        };
        // Hayati's parameter where the row needs it.
        let hayati = self.kept.contains(&self.described.place(part, 4));
        (0..if hayati { 5 } else { 4 }).map(one).collect()
    }

    fn placed(&self, part: usize, pose: &Pose, known: bool) -> Vec<Parameter> {
        let twist = self.described.of(part, self.values);
        let form = self.described.parts[part];
        let nominal = numbers(pose, None);
        let calibrated = numbers(&form.pose(twist), Some(&nominal));
        let at = self.described.place(part, 0);
        let block = self.spread.view((at, at), (6, 6));
        let mut moves = DMatrix::zeros(6, 6);
        for k in 0..6 {
            let moved = |by: f64| {
                let mut twist = twist.to_vec();
                twist[k] += by;
                numbers(&form.pose(&twist), Some(&calibrated))
            };
            let (forward, back) = (moved(STEP), moved(-STEP));
            (0..6).for_each(|row| moves[(row, k)] = (forward[row] - back[row]) / (2.0 * STEP));
        }
        let spread = &moves * block * moves.transpose();
        let one = |k: usize| Parameter {
            name: PLACE[k].0,
            unit: PLACE[k].1,
            nominal: known.then_some(nominal[k]),
            calibrated: calibrated[k],
            standard_uncertainty: resolved(spread[(k, k)]),
        };
        (0..6).map(one).collect()
    }

    fn target(&self, chain: &Chain, target: TargetId) -> ParameterPart {
        let (declared, found) = (&self.described.chain.targets()[target.0], &chain.targets()[target.0]);
        let one = |k: usize| {
            let site = chain.site_index(Site::Target(target, Axis::TRANSLATIONS[k]));
            Parameter {
                name: PLACE[k].0,
                unit: "m",
                nominal: declared.known.then_some(declared.position[k]),
                calibrated: found.position[k],
                standard_uncertainty: resolved(self.constants[(site, site)]),
            }
        };
        ParameterPart {
            name: found.name.clone(),
            kind: PartKind::Target,
            parameters: (0..3).map(one).collect(),
        }
    }

    fn offset(&self, part: usize) -> JointOffset {
        let joint = JointId(part);
        let chain = self.described.chain;
        let slides = chain.joint(joint).kind == JointKind::Prismatic;
        // How the offset is put together from the numbers of the part.
        let along: Vec<(usize, f64)> = match self.described.parts[part] {
            Form::Placed(_) => {
                let axis = split(chain, joint).2;
                let first = if slides { 0 } else { 3 };
                (0..3).map(|k| (self.described.place(part, first + k), axis[k])).collect()
            }
            _ => vec![(self.described.place(part, usize::from(slides)), 1.0)],
        };
        let along: Vec<(usize, f64)> = along.into_iter().filter(|(_, by)| by.abs() > 1e-12).collect();
        let kept = along.iter().any(|(number, _)| self.kept.contains(number));
        let variance: f64 = along
            .iter()
            .flat_map(|&(i, a)| along.iter().map(move |&(j, b)| a * b * self.spread[(i, j)]))
            .sum();
        let movable = chain.movable();
        let part_of = match kept {
            true => None,
            false if movable.first() == Some(&joint) => Some("base"),
            false if movable.last() == Some(&joint) => Some("tool"),
            false => Some("another joint"),
        };
        JointOffset {
            joint,
            offset: along.iter().map(|&(number, by)| by * self.values[number]).sum(),
            standard_uncertainty: resolved(variance),
            part_of,
        }
    }
}

/// Standard deviation of a variance; zero where it is round-off, below a picometre or a picoradian.
fn resolved(variance: f64) -> f64 {
    if variance > 1e-24 { variance.sqrt() } else { 0.0 }
}

/// x y z, roll, pitch, yaw, the angles on the branch near others.
fn numbers(pose: &Pose, near: Option<&[f64; 6]>) -> [f64; 6] {
    let [x, y, z]: [f64; 3] = pose.translation.into();
    let [roll, pitch, yaw] = angles(pose, near.map(|n| Vector3::new(n[3], n[4], n[5]))).into();
    [x, y, z, roll, pitch, yaw]
}

fn angles(pose: &Pose, near: Option<Vector3<f64>>) -> Vector3<f64> {
    let first = Vector3::from(pose.rpy());
    let Some(near) = near else { return first };
    let second = Vector3::new(first.x + PI, PI - first.y, first.z + PI);
    let wrapped = |angles: Vector3<f64>| angles.zip_map(&near, |a, n| a - TAU * ((a - n) / TAU).round());
    let [first, second] = [wrapped(first), wrapped(second)];
    if (second - near).norm() < (first - near).norm() { second } else { first }
}
