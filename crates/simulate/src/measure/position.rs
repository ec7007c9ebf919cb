//! Rows of positions, and of the tool's orientation, that the instrument measures.

use super::sheet::{Dwell, Observed, Sheet};
use crate::moment::three;
use crate::rigid::{Rigid, from_pose};
use crate::{Campaign, Plant, SimulateError};
use nalgebra::{Point3, UnitQuaternion, Vector3};
use rand::RngExt;
use rand_chacha::ChaCha8Rng;
use truepose_errormodel::Dataset;
use truepose_kinematics::{Conditions, Pose, TargetId};

impl Plant {
    /// One row for each target.
    pub(super) fn positions(
        &self,
        campaign: &Campaign,
        dwell: &Dwell<'_>,
        sheet: &mut Sheet,
    ) -> Result<(), SimulateError> {
        for (k, target) in self.measured_targets(campaign).into_iter().enumerate() {
            let time = dwell.moment.time + campaign.row_s * k as f64;
            let conditions = Conditions { time, ..dwell.conditions.clone() };
            let of = self.true_target(target)?;
            let stand = self.stand(&conditions, dwell.moment, &of)?;
            let point = (stand.tool * Point3::from(of)).coords;
            let row = sheet.seen.data.len();
            let station = sheet.station.as_ref();
            let mut seen_at = station.map_or(stand.at, |path| path.seen(dwell.index, &stand.at));
            if let Some(beam) = &self.disturbances.beam {
                let facing = stand.reached.rotation * Vector3::z();
                seen_at += beam.displacement(&self.instrument.station, &stand.at, &self.up(), &facing);
            }
            let stood = station.map(|path| path.rotation(dwell.index));
            let mut measured = seen_at + self.instrument.error(&point, &mut sheet.of_row);
            if sheet.of_outlier.random::<f64>() < self.blunders.outlier_share {
                let size = self.blunders.outlier_size * (0.5 + sheet.of_outlier.random::<f64>());
                measured += three(&mut sheet.of_outlier).normalize() * size;
                sheet.seen.outliers.push(row);
            }
            self.write_position(&mut sheet.seen.data, &measured);
            let turned = (&dwell.moment.turned, stood);
            self.write_orientation(&mut sheet.seen.data, &stand.reached, turned, &mut sheet.of_orientation);
            sheet.row(self, dwell, (target, time), (&stand, point), Observed::default());
        }
        Ok(())
    }

    fn measured_targets(&self, campaign: &Campaign) -> Vec<Option<TargetId>> {
        let declared = self.chain().targets().len();
        match (campaign.targets.is_empty(), declared) {
            (false, _) => campaign.targets.clone(),
            (true, 0) => vec![None],
            (true, count) => (0..count).map(|k| Some(TargetId(k))).collect(),
        }
    }

    fn write_position(&self, data: &mut Dataset, measured: &Vector3<f64>) {
        let seen = |k: usize, value: f64| if self.instrument.axes[k] { value } else { f64::NAN };
        data.position.push(std::array::from_fn(|k| seen(k, measured[k])));
        let covariance = self.instrument.covariance(measured);
        let (stated, factor) = (self.instrument.states_sd, self.disturbances.stated_factor);
        data.position_sd.push(std::array::from_fn(|k| {
            if stated { seen(k, factor * covariance[(k, k)].sqrt()) } else { f64::NAN }
        }));
    }

    fn write_orientation(
        &self,
        data: &mut Dataset,
        tool: &Rigid,
        (turned, stand): (&Vector3<f64>, Option<UnitQuaternion<f64>>),
        rng: &mut ChaCha8Rng,
    ) {
        let Some(sd) = self.instrument.orientation_sd else {
            data.orientation.push(None);
            data.orientation_sd.push([f64::NAN; 3]);
            return;
        };
        let noise = Vector3::from_fn(|_, _| self.instrument.unit(rng)) * sd;
        let turned = UnitQuaternion::from_scaled_axis(noise + turned) * tool.rotation;
        let measured = stand.map_or(turned, |stand| stand * turned);
        data.orientation.push(Some(upper(&measured)));
        let stated = self.disturbances.stated_factor * sd;
        data.orientation_sd.push([if self.instrument.states_sd { stated } else { f64::NAN }; 3]);
    }
}

/// The orientation of a pose as a unit quaternion (w, x, y, z).
pub(super) fn quaternion(pose: &Pose) -> [f64; 4] {
    upper(&from_pose(pose).rotation)
}

/// (w, x, y, z) with w zero or more.
fn upper(rotation: &UnitQuaternion<f64>) -> [f64; 4] {
    let [x, y, z, w]: [f64; 4] = rotation.into_inner().coords.into();
    let sign = if w < 0.0 { -1.0 } else { 1.0 };
    [w, x, y, z].map(|v| v * sign)
}
