//! Rows of a campaign by what they touched, met or measured, before anything of the robot is fitted.

use super::carried::Carried;
use super::contacts::{self, Contact};
use super::gauge::Gauge;
use super::sensors::{self, SensorFound, Sensors};
use super::ties::{Structure, tied};
use crate::IdentifyError;
use std::collections::BTreeSet;
use truepose_errormodel::{Dataset, Surroundings, Visits};
use truepose_kinematics::Chain;

/// The rows, and what was observed in them.
pub(super) struct Prepared {
    pub data: Dataset,
    pub surroundings: Surroundings,
    pub contacts: Vec<Contact>,
    pub sensors: Sensors,
    pub carried: Carried,
    pub structure: Structure,
    /// Whether a position, or a known landmark, was measured.
    pub measured: bool,
    /// The same, or points of known place were seen by a carried camera: they are as good as measured positions.
    pub outside: bool,
    /// Whether some row says where the base is.
    pub has_base: bool,
    /// Whether some row says how long anything is.
    pub has_scale: bool,
    /// Whether nothing but the targets on the tool says so: their places are exact.
    pub by_targets: bool,
    /// Whether a robot as small as a point would agree with every row, so that a distance between landmarks has to be held.
    pub scale_is_open: bool,
    pub remarks: Vec<String>,
}

impl Prepared {
    /// Contacts of these numbers keep a landmark each; `frozen`: no effect changes the arm.
    pub fn of(
        (chain, data, surroundings): (&Chain, &Dataset, &Surroundings),
        contacts: &[Contact],
        (kept, frozen): (&BTreeSet<usize>, bool),
    ) -> Result<Self, IdentifyError> {
        let described = surroundings.landmarks.len();
        let (data, surroundings) = match contacts.is_empty() {
            true => (data.clone(), surroundings.clone()),
            false => contacts::prepared((chain, data, surroundings), contacts, kept),
        };
        let mut data = sensors::one_number_a_row(&data, &surroundings);
        let mut of_row: Vec<Option<usize>> = (0..data.len()).map(|row| data.landmark(row)).collect();
        let sensors = Sensors::of(&data, &of_row, &surroundings)?;
        let carried = Carried::of(chain, &data, &of_row, (&surroundings, &|row| sensors.follows(row)))?;
        data.set_points(None);
        for (at, sensor) in of_row.iter_mut().zip(&sensors.of_row) {
            *at = at.filter(|_| sensor.is_none());
        }
        let measured = settle_known(&mut data, &mut of_row, (&surroundings, &sensors));
        let outside = measured || carried.spans();
        let mut remarks = Vec::new();
        let structure = tied(&of_row, &surroundings, &mut remarks)?;
        for at in &mut of_row {
            *at = at.and_then(|k| structure.number[k]);
        }
        data.set_landmarks(Some(&of_row));
        apart(&mut data, &sensors);
        let mut contacts = contacts.to_vec();
        contacts::find_rows(&mut contacts, &data, |k| structure.declared[k] >= described);
        let gauge = Gauge {
            outside,
            distances: !structure.distances.is_empty() || contacts.iter().any(|of| of.distance > 0.0),
            kept: match contacts.iter().any(|of| of.distance > 0.0) {
                true => Vec::new(),
                false => surroundings.distances.iter().filter(|of| structure.keeps(of)).collect(),
            },
            touched: !structure.points.is_empty() || !contacts.is_empty(),
            frozen,
            sized: sized(chain, &data, (&sensors, &carried)),
            sensors: &sensors,
        };
        if let Some(why) = gauge.refusal() {
            let names: Vec<&str> = sensors.found.iter().map(|found| found.name.as_str()).collect();
            return Err(IdentifyError::Landmark { name: names.join(", "), why });
        }
        let words = gauge.words(&surroundings);
        let by_targets = gauge.by_targets();
        let (has_base, has_scale) = (gauge.has_base(), gauge.has_scale());
        let scale_is_open = gauge.lets_landmarks_shrink();
        remarks.extend(words);
        remarks.extend(contacts::mounts(chain, &contacts));
        Ok(Prepared {
            data,
            surroundings,
            contacts,
            sensors,
            carried,
            structure,
            measured,
            outside,
            has_base,
            has_scale,
            by_targets,
            scale_is_open,
            remarks,
        })
    }
}

/// Targets that are nearer to each other, m, are one point.
const APART: f64 = 1e-3;

/// Whether a camera in the cell, of known lens, saw targets that are apart, on a robot all of whose targets are of known place.
fn sized(chain: &Chain, data: &Dataset, (sensors, carried): (&Sensors, &Carried)) -> bool {
    let apart = |found: &SensorFound| {
        let standing = found.rows.iter().filter(|&&row| carried.point(row).is_none());
        let mut places = standing.filter_map(|&row| Some(chain.targets().get(data.target[row]?.0)?.position));
        places.next().is_some_and(|first| places.any(|place| (place - first).norm() > APART))
    };
    let lens = |found: &&SensorFound| found.camera().is_some_and(|camera| !camera.free_intrinsics);
    let known = chain.tools().len() == 1 && chain.targets().iter().all(|target| target.known);
    known && sensors.found.iter().filter(lens).any(apart)
}

/// Of a standstill, rows with a position, rows that measured a number, and each row in which two tools met are pose measurements of their own: the
/// rows with a number share the displacement of the robot along their directions, a difference of two positions does not contain it.
fn apart(data: &mut Dataset, sensors: &Sensors) {
    let mut next = data.visit.iter().max().map_or(0, |last| last + 1);
    for rows in Visits::of(data).rows {
        let mut of_kind = [None; 2];
        for (place, row) in rows.into_iter().enumerate() {
            let known = match data.meets(row) {
                Some(_) => &mut None,
                None => &mut of_kind[usize::from(sensors.of_row[row].is_some())],
            };
            data.visit[row] = *known.get_or_insert_with(|| {
                // The first row of a visit keeps its number, so that no number is left without a row.
                next += usize::from(place > 0);
                if place > 0 { next - 1 } else { data.visit[row] }
            });
        }
    }
}

/// Landmarks whose place is known are measured positions; whether anything outside of the robot was measured.
fn settle_known(
    data: &mut Dataset,
    of_row: &mut [Option<usize>],
    (surroundings, sensors): (&Surroundings, &Sensors),
) -> bool {
    let mut outside = false;
    for (row, at) in of_row.iter_mut().enumerate() {
        let known = at.and_then(|k| surroundings.landmarks.get(k)).filter(|landmark| landmark.known);
        if let Some(position) = known.and_then(|landmark| landmark.position) {
            data.position[row] = position.into();
            *at = None;
        }
        outside |= at.is_none() && sensors.of_row[row].is_none() && data.seen(row).count() > 0;
    }
    outside
}
