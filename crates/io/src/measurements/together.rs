//! Values of one row that depend on several cells: plausible joints, an orientation, a load.

use super::columns::Role;
use super::row::{Kind, RowReader};
use super::scalars::{SCALARS, usual_unit};
use super::visits::in_session;
use crate::IoError;
use truepose_errormodel::observation::{Camera, Distance, FRAMES, KINDS, Linear, Relative};
use truepose_kinematics::nalgebra::{Matrix3, Vector3};
use truepose_kinematics::{Load, Payload, Pose, Wrench, rotation_vector};

/// Further from one than this, a quaternion is something else.
const UNIT_TOLERANCE: f64 = 1e-3;

impl RowReader {
    /// Values that depend on several cells.
    pub(super) fn understand(&mut self) -> Result<(), IoError> {
        let line = self.row.line;
        if let Some(slots) = &self.header.slots.joints {
            for (joint, &k) in slots.iter().enumerate() {
                let (value, plausible) = (self.numbers[k], &self.plausible[joint]);
                if value < plausible.lower || value > plausible.upper {
                    plausible
                        .judge(value, &self.header.columns[k])
                        .map_err(|message| self.header.cell_error(line, k, message))?;
                    self.beyond[joint].get_or_insert((line, 0)).1 += 1;
                }
            }
        }
        if self.position_needed
            && let Some(slots) = self.header.slots.position
            && let Some(&k) = slots.iter().find(|&&k| self.numbers[k].is_nan())
        {
            return Err(self.header.cell_error(line, k, "is empty; a desired pose needs all of x, y, z"));
        }
        if let Some(k) = self.header.slots.visit {
            self.row.visit = Some(in_session(self.numbers[k] as i64, self.row.session));
        }
        self.carried_by(line)?;
        self.observed(line)?;
        if let Some(k) = self.header.slots.time {
            self.row.time = self.numbers[k];
        }
        if !self.position_needed
            && let Some(slots) = self.header.slots.position
            && slots.iter().all(|&k| self.numbers[k].abs() < f64::MIN_POSITIVE)
            && self.lost.is(&self.header, &self.numbers, self.row.target)
        {
            self.row.lost = true;
            self.lost.add(line);
            return self.loaded();
        }
        if let Some(slots) = self.header.slots.quaternion {
            self.row.orientation = self.quaternion(slots)?;
        }
        if let Some(slots) = self.header.slots.rotation_vector {
            self.row.orientation = self.rotation_vector(slots)?;
        }
        if let Some((slots, convention)) = self.header.slots.angles {
            self.row.orientation = self
                .all_or_none(slots, "the orientation")?
                .and_then(|angles| convention.rotation(angles))
                .map(|rotation| Pose::new(rotation, Vector3::zeros()).quaternion());
        }
        for slots in [self.header.slots.position_sd, self.header.slots.orientation_sd].into_iter().flatten() {
            if let Some(&k) = slots.iter().find(|&&k| self.numbers[k] <= 0.0) {
                let message =
                    "a standard deviation has to be above zero; leave the cell empty where none is stated";
                return Err(self.header.cell_error(line, k, message));
            }
        }
        self.loaded()
    }

    /// A row that names a target and a tool names the tool that carries the target.
    fn carried_by(&mut self, line: u64) -> Result<(), IoError> {
        let named = self.row.target.zip(self.row.tool);
        let Some((target, tool)) = named.filter(|(target, tool)| self.carrier(*target) != *tool) else {
            return Ok(());
        };
        let carrier = &self.tools[self.carrier(target).0];
        let message = format!(
            "the row is of tool `{}`, but target `{}` is on tool `{carrier}`",
            self.tools[tool.0], self.targets[target.0]
        );
        let at = self.header.columns.iter().position(|column| column.role == Role::Tool).unwrap_or(0);
        Err(self.header.cell_error(line, at, message))
    }

    /// Kind, landmark and measured number belong together.
    fn observed(&mut self, line: u64) -> Result<(), IoError> {
        let slots = &self.header.slots;
        let Some(kind) = slots.kind else { return Ok(()) };
        let error = |at: usize, message: String| Err(self.header.cell_error(line, at, message));
        let word = match self.row.kind {
            Kind::Pose => "position",
            Kind::SamePoint => "same_point",
            Kind::Number(k) => KINDS[k],
        };
        let wanted = match word {
            Distance::KIND => &[0][..],
            Linear::KIND => &[1],
            Camera::KIND => &[2, 3],
            _ => &[],
        };
        for (k, slot) in slots.scalars.iter().enumerate() {
            let value = slot.map_or(f64::NAN, |slot| self.numbers[slot]);
            match (slot, wanted.contains(&k)) {
                (None, true) => {
                    let name = SCALARS[k];
                    let unit = usual_unit(k);
                    return error(
                        kind,
                        format!("`{word}` needs a column `{name}[{unit}]`: what was measured"),
                    );
                }
                (Some(slot), true) if value.is_nan() => {
                    return error(*slot, format!("is empty; a row of kind `{word}` has a measured number"));
                }
                // Where two points touched there is none.
                (Some(_), false) if word == FRAMES && k == 0 && (value.is_nan() || value >= 0.0) => {}
                (Some(slot), false) if word == FRAMES && k == 0 => {
                    return error(*slot, "a distance is not negative".into());
                }
                (Some(slot), false) if !value.is_nan() => {
                    return error(
                        *slot,
                        format!("is not used by a row of kind `{word}`; leave the cell empty"),
                    );
                }
                _ => {}
            }
        }
        match (self.row.kind, self.row.landmark, slots.landmark) {
            (Kind::Pose, None, _) => return Ok(()),
            (Kind::Pose, Some(_), landmark) => {
                let message = "is not used by a measured position; leave the cell empty, or write the kind `same_point`";
                return error(landmark.unwrap_or(kind), message.into());
            }
            (_, None, None) => {
                let what = match word {
                    "same_point" => "which point was touched",
                    FRAMES => "which target or tool the row's own met",
                    _ => "what was observed",
                };
                return error(kind, format!("`{word}` needs a column `landmark`: {what}"));
            }
            (_, None, Some(landmark)) => {
                let what = match word {
                    "same_point" => "the point that was touched",
                    FRAMES => "the target or tool that the row's own met",
                    _ => "what was observed",
                };
                return error(landmark, format!("is empty; a row of kind `{word}` names {what}"));
            }
            _ => {}
        }
        if word == Relative::KIND {
            return match slots.position {
                None => error(
                    kind,
                    format!(
                        "`{word}` needs columns `x[mm]`, `y[mm]`, `z[mm]`: where the target was in the frame of its series"
                    ),
                ),
                Some(slots) => match slots.iter().find(|&&k| self.numbers[k].is_nan()) {
                    Some(&k) => error(k, format!("is empty; a row of kind `{word}` has a whole position")),
                    None => Ok(()),
                },
            };
        }
        match slots.position.iter().flatten().find(|&&k| !self.numbers[k].is_nan()) {
            Some(&k) => {
                error(k, format!("a row of kind `{word}` has no measured position; leave x, y, z empty"))
            }
            None => Ok(()),
        }
    }

    /// Number of the kind, from one, and the measured numbers, as channels of the data.
    pub(super) fn observation(&self) -> [f64; 4] {
        let Kind::Number(k) = self.row.kind else { return [0.0; 4] };
        if let (true, Some([x, y, z])) = (self.is_relative(), self.header.slots.position) {
            return [(k + 1) as f64, self.numbers[x], self.numbers[y], self.numbers[z]];
        }
        let values = self.header.slots.scalars.iter().flatten().map(|&slot| self.numbers[slot]);
        let mut values = values.filter(|value| !value.is_nan());
        [(k + 1) as f64, values.next().unwrap_or(0.0), values.next().unwrap_or(0.0), 0.0]
    }

    /// Whether the row's position is one in the frame of its series.
    pub(super) fn is_relative(&self) -> bool {
        matches!(self.row.kind, Kind::Number(k) if KINDS[k] == Relative::KIND)
    }

    fn loaded(&mut self) -> Result<(), IoError> {
        self.row.load = self.load()?;
        Ok(())
    }

    fn load(&self) -> Result<Load, IoError> {
        let slots = &self.header.slots;
        if let Some(slots) = slots.wrench
            && let Some(w) = self.all_or_none(slots, "the wrench")?
        {
            return Ok(Load::Wrench(Wrench {
                force: Vector3::new(w[0], w[1], w[2]),
                moment: Vector3::new(w[3], w[4], w[5]),
            }));
        }
        let Some(k) = slots.payload else {
            return Ok(Load::None);
        };
        let mass = self.numbers[k];
        if mass < 0.0 {
            return Err(self.header.cell_error(self.row.line, k, "a mass cannot be negative"));
        }
        let mut com = slots.same_centre.map_or_else(Vector3::zeros, Vector3::from);
        if let Some(slots) = slots.centre {
            com = Vector3::from(slots.map(|k| self.numbers[k]));
            if com.iter().any(|v| v.is_nan()) {
                if mass > 0.0 {
                    let k = slots[com.iter().position(|v| v.is_nan()).unwrap_or(0)];
                    return Err(self.header.cell_error(
                        self.row.line,
                        k,
                        "is empty; a mass needs its centre of gravity",
                    ));
                }
                com = Vector3::zeros();
            }
        }
        Ok(Load::Payload(Payload { mass, com }))
    }

    fn quaternion(&self, slots: [usize; 4]) -> Result<Option<[f64; 4]>, IoError> {
        let Some(q) = self.all_or_none(slots, "the quaternion")? else {
            return Ok(None);
        };
        let norm = q.iter().map(|v| v * v).sum::<f64>().sqrt();
        if norm.is_nan() || (norm - 1.0).abs() > UNIT_TOLERANCE {
            let message = format!(
                "the quaternion has length {}, not 1; check the order qw qx qy qz",
                super::plausible::rounded(norm)
            );
            return Err(self.header.cell_error(self.row.line, slots[0], message));
        }
        Ok(Some(q.map(|v| v / norm)))
    }

    fn rotation_vector(&self, slots: [usize; 3]) -> Result<Option<[f64; 4]>, IoError> {
        let Some(v) = self.all_or_none(slots, "the rotation vector")? else {
            return Ok(None);
        };
        let v = Vector3::from(v);
        let turn = v.norm();
        if turn.is_nan() || turn > 3.0 * std::f64::consts::PI {
            let message = format!(
                "the rotation vector turns by {} rad, beyond any plausible turn; check the unit",
                super::plausible::rounded(turn)
            );
            return Err(self.header.cell_error(self.row.line, slots[0], message));
        }
        let rotation: Matrix3<f64> = rotation_vector(&v);
        Ok(Some(Pose::new(rotation, Vector3::zeros()).quaternion()))
    }

    /// The cells of one thing: all of them, or none when all are empty.
    fn all_or_none<const N: usize>(
        &self,
        slots: [usize; N],
        what: &str,
    ) -> Result<Option<[f64; N]>, IoError> {
        let values = slots.map(|k| self.numbers[k]);
        match values.iter().filter(|v| v.is_nan()).count() {
            0 => Ok(Some(values)),
            empty if empty == N => Ok(None),
            _ => {
                let k = slots[values.iter().position(|v| v.is_nan()).unwrap_or(0)];
                let message =
                    format!("is empty while other cells of {what} are filled; fill or empty all of them");
                Err(self.header.cell_error(self.row.line, k, message))
            }
        }
    }
}
