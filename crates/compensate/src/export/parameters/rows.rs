//! Values of a description as a table of named numbers.

use super::super::geometry::split;
use super::described::{Described, Form};
use super::known::Knowledge;
use super::{JointOffset, Parameter, ParameterPart, ParameterTable, PartKind};
use nalgebra::{DMatrix, RowDVector, Vector3};
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
    pub knowledge: Knowledge,
    /// How all numbers move with the coefficients.
    pub moves: &'a DMatrix<f64>,
    /// How the constants of all sites do.
    pub of_sites: &'a DMatrix<f64>,
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
                offsets.push(self.offset(JointId(part)));
            }
            parts.push(ParameterPart { name: name.into(), kind, parameters });
        }
        parts.extend((0..chain.targets().len()).map(|k| self.target(&chain, TargetId(k))));
        ParameterTable { parts, offsets, chain }
    }

    fn sd(&self, number: usize) -> f64 {
        let moves = self.moves.row(number).into_owned();
        self.knowledge.uncertainty(&moves, self.described.numbers[number].length)
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
        let mut of_twist = DMatrix::zeros(6, 6);
        for k in 0..6 {
            let moved = |by: f64| {
                let mut twist = twist.to_vec();
                twist[k] += by;
                numbers(&form.pose(&twist), Some(&calibrated))
            };
            let (forward, back) = (moved(STEP), moved(-STEP));
            (0..6).for_each(|row| of_twist[(row, k)] = (forward[row] - back[row]) / (2.0 * STEP));
        }
        let moves = of_twist * self.moves.rows(at, 6);
        let one = |k: usize| Parameter {
            name: PLACE[k].0,
            unit: PLACE[k].1,
            nominal: known.then_some(nominal[k]),
            calibrated: calibrated[k],
            standard_uncertainty: self.knowledge.uncertainty(&moves.row(k).into_owned(), k < 3),
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
                standard_uncertainty: self.knowledge.uncertainty(&self.of_sites.row(site).into_owned(), true),
            }
        };
        ParameterPart {
            name: found.name.clone(),
            kind: PartKind::Target,
            parameters: (0..3).map(one).collect(),
        }
    }

    /// How the zero of a joint's variable is put together from the numbers of its part.
    fn along(&self, joint: JointId) -> Vec<(usize, f64)> {
        let chain = self.described.chain;
        let (part, slides) = (joint.0, chain.joint(joint).kind == JointKind::Prismatic);
        let along: Vec<(usize, f64)> = match self.described.parts[part] {
            Form::Placed(_) => {
                let axis = split(chain, joint).2;
                let first = if slides { 0 } else { 3 };
                (0..3).map(|k| (self.described.place(part, first + k), axis[k])).collect()
            }
            _ => vec![(self.described.place(part, usize::from(slides)), 1.0)],
        };
        along.into_iter().filter(|(_, by)| by.abs() > 1e-12).collect()
    }

    fn offset(&self, joint: JointId) -> JointOffset {
        let chain = self.described.chain;
        let movable = chain.movable();
        let own = self.along(joint);
        let estimated = own.iter().any(|(number, _)| self.kept.contains(number));
        // The controller's value of the joint, from the variables of the joints: u = C⁻¹ q.
        let mut all = Vec::new();
        for (k, &other) in movable.iter().enumerate() {
            let mut unit = vec![0.0; movable.len()];
            unit[k] = 1.0;
            chain.joints_to_controller(&mut unit);
            let by = chain.coordinate(joint).map_or(0.0, |own| unit[own]);
            if by.abs() > 0.0 {
                all.extend(self.along(other).into_iter().map(|(number, part)| (number, by * part)));
            }
        }
        let sum = |terms: &[(usize, f64)]| terms.iter().map(|&(number, by)| by * self.values[number]).sum();
        let mut moves = RowDVector::zeros(self.moves.ncols());
        for &(number, by) in &all {
            moves += self.moves.row(number) * by;
        }
        let part_of = match estimated {
            true => None,
            false if movable.first() == Some(&joint) => Some("base"),
            false if movable.last() == Some(&joint) => Some("tool"),
            false => Some("another joint"),
        };
        let slides = chain.joint(joint).kind == JointKind::Prismatic;
        JointOffset {
            joint,
            offset: sum(&all),
            of_variable: chain.couplings().iter().any(|c| c.joint == joint).then(|| sum(&own)),
            standard_uncertainty: if estimated { self.knowledge.uncertainty(&moves, slides) } else { 0.0 },
            part_of,
        }
    }
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
