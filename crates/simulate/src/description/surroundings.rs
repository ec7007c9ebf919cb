//! The cell of a plant: its own description, and for what that leaves out the robot description.

use super::PlantDescription;
use super::cameras::CameraDescription;
use super::landmarks::{LandmarkDescription, MoveDescription};
use crate::cell::{Cell, Misnamed, Name, Thing, What};
use crate::{Plant, SimulateError, Task, Visit};
use nalgebra::Vector3;
use serde::{Deserialize, Serialize};
use truepose_errormodel::{Landmark, Surroundings};
use truepose_kinematics::{Chain, Load, TargetId};

/// A row with a wrong association.
#[derive(Debug, Clone, PartialEq, Default, Serialize, Deserialize)]
#[serde(default, deny_unknown_fields)]
pub struct MisnamedRow {
    /// The row of the measurements, from 1.
    pub row: usize,
    /// What it names instead: a landmark (of a camera on the robot: a point that it sees), or a target.
    pub named: String,
}

/// Names of landmarks, with what is known of them.
struct Names<'d> {
    described: &'d Surroundings,
    names: Vec<String>,
}

impl Names<'_> {
    /// The number of a name. Where the robot description lists its landmarks, others are refused.
    fn number(&mut self, name: &str) -> Result<usize, SimulateError> {
        if let Some(number) = self.names.iter().position(|known| known == name) {
            return Ok(number);
        }
        if !self.described.open && !self.described.landmarks.is_empty() {
            return Err(SimulateError::Unknown {
                what: "landmark",
                name: name.into(),
                known: self.names.clone(),
            });
        }
        self.names.push(name.into());
        Ok(self.names.len() - 1)
    }

    fn described(&self, number: usize) -> Option<&Landmark> {
        self.described.landmarks.get(number)
    }
}

impl PlantDescription {
    /// What stands around the robot.
    pub(super) fn cell(&self, chain: &Chain, described: &Surroundings) -> Result<Cell, SimulateError> {
        let names = described.landmarks.iter().map(|landmark| landmark.name.clone()).collect();
        let mut names = Names { described, names };
        let mut things = Vec::new();
        let thing = |number, what, sd: f64, targets: &[String], moved: Option<&MoveDescription>| {
            if !(sd >= 0.0 && sd.is_finite()) {
                let what = "the standard deviation of an observation";
                return Err(SimulateError::Size { what, value: sd, need: "zero or more" });
            }
            let (targets, moves) = (named_targets(chain, targets)?, moved.map(MoveDescription::on));
            Ok(Thing { number, what, sd, targets, moves })
        };
        for landmark in &self.landmarks {
            let number = names.number(&landmark.name)?;
            let what = landmark.what(names.described(number))?;
            things.push(thing(
                number,
                what,
                1e-6 * landmark.sd_um,
                &landmark.targets,
                landmark.moved.as_ref(),
            )?);
        }
        for camera in &self.cameras {
            let number = names.number(&camera.name)?;
            let points = match camera.carried(names.described(number)) {
                true => points(camera, &things, &mut names)?,
                false => Vec::new(),
            };
            let what = camera.what(names.described(number), points)?;
            things.push(thing(number, what, camera.sd_px, &camera.targets, camera.moved.as_ref())?);
        }
        let wrong = |wrong: &MisnamedRow| misnamed(wrong, chain, &names.names);
        let misnamed = self.misnamed.iter().map(wrong).collect::<Result<_, _>>()?;
        Ok(Cell { names: names.names, things, misnamed })
    }

    /// The visits with each landmark and each camera, their postures still to be found.
    pub(super) fn visits(&self, plant: &Plant) -> Result<Vec<Visit>, SimulateError> {
        let counts = self.landmarks.iter().map(|landmark: &LandmarkDescription| landmark.rows);
        let counts = counts.chain(self.cameras.iter().map(|camera| camera.images));
        let mut visits = Vec::new();
        for (thing, count) in counts.enumerate() {
            let targets = &plant.thing(thing)?.targets;
            visits.extend((0..count).map(|k| Visit {
                joints: vec![0.0; plant.chain().movable().len()],
                load: Load::None,
                approach: None,
                task: Task::Observed { thing, target: targets[k % targets.len()] },
            }));
        }
        Ok(visits)
    }
}

/// What a camera on the robot looks at: landmarks where they really are.
fn points(
    camera: &CameraDescription,
    things: &[Thing],
    names: &mut Names<'_>,
) -> Result<Vec<(usize, Vector3<f64>)>, SimulateError> {
    let really = |number: usize| {
        things.iter().find(|thing| thing.number == number).and_then(|thing| match &thing.what {
            What::Socket(at) => Some(*at),
            _ => None,
        })
    };
    let described = |number: usize| {
        let known = names.described.landmarks.get(number).filter(|known| known.observed.is_none());
        known.and_then(|known| known.position)
    };
    if camera.points.is_empty() {
        let all = (0..names.names.len()).filter(|&number| described(number).is_some());
        return Ok(all.filter_map(|number| Some((number, really(number).or(described(number))?))).collect());
    }
    let wanted = camera.points.iter().map(|name| {
        let known = names.names.iter().position(|known| known == name);
        let number = known.ok_or_else(|| SimulateError::Unknown {
            what: "landmark",
            name: name.clone(),
            known: names.names.clone(),
        })?;
        let place = really(number).or(described(number));
        let nowhere = || camera.wrong(&format!("the place of its point `{name}` is in neither file"));
        Ok((number, place.ok_or_else(nowhere)?))
    });
    wanted.collect()
}

/// Targets of these names; without any all that the robot has, or its tool's origin.
fn named_targets(chain: &Chain, names: &[String]) -> Result<Vec<Option<TargetId>>, SimulateError> {
    let declared = chain.targets().len();
    match (names.is_empty(), declared) {
        (true, 0) => Ok(vec![None]),
        (true, count) => Ok((0..count).map(|k| Some(TargetId(k))).collect()),
        (false, _) => names.iter().map(|name| target(chain, name).map(Some)).collect(),
    }
}

fn target(chain: &Chain, name: &str) -> Result<TargetId, SimulateError> {
    chain.target_named(name).ok_or_else(|| SimulateError::Unknown {
        what: "target",
        name: name.into(),
        known: chain.targets().iter().map(|target| target.name.clone()).collect(),
    })
}

fn misnamed(wrong: &MisnamedRow, chain: &Chain, names: &[String]) -> Result<Misnamed, SimulateError> {
    let row = wrong.row.checked_sub(1).ok_or(SimulateError::Size {
        what: "`row` of a misnamed row",
        value: 0.0,
        need: "1 or more: rows count from 1",
    })?;
    let landmark = names.iter().position(|name| *name == wrong.named).map(Name::Landmark);
    let named = match landmark {
        Some(landmark) => landmark,
        None => Name::Target(target(chain, &wrong.named).map_err(|_| SimulateError::Unknown {
            what: "landmark or target",
            name: wrong.named.clone(),
            known: names.to_vec(),
        })?),
    };
    Ok(Misnamed { row, named })
}
