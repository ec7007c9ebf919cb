//! Rows of sockets, plates, wires and cameras: what is read where the robot really is.

use super::sheet::{Dwell, Observed, Sheet};
use crate::cell::{Thing, What};
use crate::flaws::normal;
use crate::moment::Stand;
use crate::rigid::Rigid;
use crate::{Plant, SimulateError};
use nalgebra::{Point3, UnitQuaternion, Vector3};
use truepose_kinematics::TargetId;

impl Plant {
    /// One row, or of a camera one for each point that it sees.
    pub(super) fn observations(
        &self,
        (thing, target): (usize, Option<TargetId>),
        dwell: &Dwell<'_>,
        sheet: &mut Sheet,
    ) -> Result<(), SimulateError> {
        let thing = self.thing(thing)?;
        match thing.what_at(dwell.moment.time) {
            What::Camera(camera) if camera.carried => {
                let of = self.true_target(None)?;
                let stand = self.stand(&dwell.conditions, dwell.moment, &of)?;
                let turned = UnitQuaternion::from_scaled_axis(dwell.moment.turned);
                let tool = Rigid::from_parts(stand.at.into(), turned * stand.reached.rotation);
                for (point, pixel) in camera.image(&tool) {
                    let noisy = pixel.map(|value| value + thing.sd * normal(&mut sheet.of_reading));
                    if camera.shows(&noisy) {
                        let values = [noisy[0], noisy[1], 0.0];
                        let observed = Observed { point: Some(point), ..of_thing(thing, values) };
                        self.observed(dwell, (None, of), (&stand, observed), sheet);
                    }
                }
            }
            What::Camera(camera) => {
                for &target in &thing.targets {
                    let of = self.true_target(target)?;
                    let stand = self.stand(&dwell.conditions, dwell.moment, &of)?;
                    let Some(pixel) = What::Camera(camera.clone()).reading(&stand.at) else { continue };
                    let noisy =
                        [pixel[0], pixel[1]].map(|value| value + thing.sd * normal(&mut sheet.of_reading));
                    if camera.shows(&noisy) {
                        let observed = of_thing(thing, [noisy[0], noisy[1], 0.0]);
                        self.observed(dwell, (target, of), (&stand, observed), sheet);
                    }
                }
            }
            what => {
                let of = self.true_target(target)?;
                let stand = self.stand(&dwell.conditions, dwell.moment, &of)?;
                let mut values = what.reading(&stand.at).unwrap_or_default();
                let noise = |value: &mut f64| *value += thing.sd * normal(&mut sheet.of_reading);
                values[..thing.numbers()].iter_mut().for_each(noise);
                self.observed(dwell, (target, of), (&stand, of_thing(thing, values)), sheet);
            }
        }
        Ok(())
    }

    fn observed(
        &self,
        dwell: &Dwell<'_>,
        (target, of): (Option<TargetId>, Vector3<f64>),
        (stand, observed): (&Stand, Observed),
        sheet: &mut Sheet,
    ) {
        let point = (stand.tool * Point3::from(of)).coords;
        sheet.no_position();
        sheet.row(self, dwell, (target, dwell.moment.time), (stand, point), observed);
    }
}

fn of_thing(thing: &Thing, values: [f64; 3]) -> Observed {
    Observed { landmark: Some(thing.number), point: None, kind: thing.kind(), values }
}
