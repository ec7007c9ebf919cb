//! The sheet on which a campaign is written down, row by row.

use super::Observation;
use crate::cell::{Cell, Name};
use crate::disturbance::StationPath;
use crate::moment::{Moment, Stand};
use crate::rigid::to_pose;
use crate::stream::Stream;
use crate::{Campaign, Plant, SimulateError};
use nalgebra::Vector3;
use rand_chacha::ChaCha8Rng;
use truepose_errormodel::observation::KINDS;
use truepose_errormodel::{Dataset, Schema};
use truepose_kinematics::{Conditions, Load, TargetId};

/// One visit while the robot stands there.
pub(super) struct Dwell<'m> {
    pub index: usize,
    /// As it is declared.
    pub load: Load,
    /// As they are.
    pub conditions: Conditions,
    pub moment: &'m Moment,
    /// Joint values as they are logged.
    pub logged: Vec<f64>,
}

/// What a row observed, if not a position.
#[derive(Debug, Clone, Copy, Default)]
pub(super) struct Observed {
    pub landmark: Option<usize>,
    pub point: Option<usize>,
    pub kind: Option<&'static str>,
    pub values: [f64; 3],
}

/// What is written, with the random numbers of each column.
pub(super) struct Sheet {
    pub seen: Observation,
    pub of_row: ChaCha8Rng,
    pub of_orientation: ChaCha8Rng,
    pub of_outlier: ChaCha8Rng,
    pub of_reading: ChaCha8Rng,
    /// Where the instrument stands in each visit.
    pub station: Option<StationPath>,
    of_flicker: ChaCha8Rng,
    observed: Vec<Observed>,
}

impl Sheet {
    pub fn new(plant: &Plant, campaign: &Campaign, seed: u64) -> Self {
        let motion = plant.disturbances.station;
        let path = |motion: crate::StationMotion| {
            let poses = campaign.visits.len();
            motion.path(plant.instrument.station, poses, &mut Stream::Station.of(seed))
        };
        Sheet {
            seen: Observation {
                data: empty(plant, campaign),
                true_poses: Vec::new(),
                true_positions: Vec::new(),
                outliers: Vec::new(),
                wrong_payloads: Vec::new(),
                bad_poses: Vec::new(),
                misnamed: Vec::new(),
            },
            of_row: Stream::Instrument.of(seed),
            of_orientation: Stream::Orientation.of(seed),
            of_outlier: Stream::Outliers.of(seed),
            of_reading: Stream::Readings.of(seed),
            station: motion.map(path),
            of_flicker: Stream::Flicker.of(seed),
            observed: Vec::new(),
        }
    }

    /// The columns that every row has.
    pub fn row(
        &mut self,
        plant: &Plant,
        dwell: &Dwell<'_>,
        (target, time): (Option<TargetId>, f64),
        (stand, point): (&Stand, Vector3<f64>),
        observed: Observed,
    ) {
        let row = self.seen.data.len();
        if dwell.moment.carried != dwell.load {
            self.seen.wrong_payloads.push(row);
        }
        let data = &mut self.seen.data;
        for (column, q) in data.joints.iter_mut().zip(&dwell.logged) {
            column.push(plant.disturbances.recorded(*q, &mut self.of_flicker));
        }
        for (column, side) in data.approach.iter_mut().zip(&dwell.conditions.approach) {
            column.push(*side);
        }
        data.target.push(target);
        data.visit.push(dwell.index);
        data.load.push(dwell.load);
        data.time.push(time);
        self.seen.true_poses.push(to_pose(&stand.tool));
        self.seen.true_positions.push(point);
        self.observed.push(observed);
    }

    /// No position and no orientation.
    pub fn no_position(&mut self) {
        let data = &mut self.seen.data;
        data.position.push([f64::NAN; 3]);
        data.position_sd.push([f64::NAN; 3]);
        data.orientation.push(None);
        data.orientation_sd.push([f64::NAN; 3]);
    }

    /// What was written, with the wrong names of this cell.
    pub fn finish(mut self, cell: &Cell) -> Result<Observation, SimulateError> {
        for wrong in &cell.misnamed {
            let rows = self.observed.len();
            let observed = self.observed.get_mut(wrong.row).filter(|observed| observed.landmark.is_some());
            let Some(observed) = observed else {
                return Err(SimulateError::Misnamed { row: wrong.row + 1, rows });
            };
            match (wrong.named, &mut observed.point) {
                (Name::Landmark(number), Some(point)) => *point = number,
                (Name::Landmark(number), None) => observed.landmark = Some(number),
                (Name::Target(target), _) => self.seen.data.target[wrong.row] = Some(target),
            }
            self.seen.misnamed.push(wrong.row);
        }
        let (observed, data) = (&self.observed, &mut self.seen.data);
        let all = |of: &dyn Fn(&Observed) -> Option<usize>| -> Option<Vec<Option<usize>>> {
            let all: Vec<Option<usize>> = observed.iter().map(of).collect();
            all.iter().any(Option::is_some).then_some(all)
        };
        data.set_landmarks(all(&|observed| observed.landmark).as_deref());
        data.set_points(all(&|observed| observed.point).as_deref());
        if let Some(kinds) = all(&|observed| KINDS.iter().position(|kind| Some(*kind) == observed.kind)) {
            let kinds = kinds.iter().map(|kind| kind.map_or(0.0, |kind| (kind + 1) as f64)).collect();
            let values =
                [0, 1, 2].map(|k| Some(observed.iter().map(|observed| observed.values[k]).collect()));
            data.set_kinds(Some(kinds), values);
        }
        Ok(self.seen)
    }
}

fn empty(plant: &Plant, campaign: &Campaign) -> Dataset {
    let movable = plant.chain().movable().len();
    Dataset {
        schema: Schema {
            channels: campaign.channels.iter().map(|plan| plan.channel()).collect(),
            time: true,
            load: campaign.visits.iter().any(|visit| visit.load != Load::None),
            approach: true,
        },
        joints: vec![Vec::new(); movable],
        approach: vec![Vec::new(); movable],
        ..Dataset::default()
    }
}
