//! Causes that have a form in everyday units.

use super::cause::Cause;
use super::hidden::Hidden;
use truepose_simulate::description::PlantOptions;
use truepose_simulate::flaws::{self, BacklashSide, Wheel};

impl Hidden {
    /// Errors in everyday units.
    pub fn options(&self, options: &mut PlantOptions, size: f64) {
        let joint = self.name.clone();
        let (mrad, mm) = (0.1 * size, 0.1 * size * self.reach);
        let errors = &mut options.errors;
        match self.cause {
            Cause::JointCompliance => errors.joint_compliance.push(flaws::JointCompliance {
                joint,
                stiffness: Some(self.stiffness(size)),
                ..flaws::JointCompliance::default()
            }),
            Cause::LinkBending => {
                // Deflection F L³/3EI of about 0.1 mm × size, with F L the largest moment.
                let bending = self.load.1 * self.reach * self.reach / (3.0 * 1e-4 * size * self.reach);
                errors.link_compliance.push(flaws::LinkCompliance {
                    joint,
                    bending_nm2: [bending * (0.6 + self.u[0]), bending],
                    torsion_nm2: bending * (0.5 + self.u[1]),
                    ..flaws::LinkCompliance::default()
                });
            }
            Cause::BaseTilt => {
                let tilt = self.load.1 / (1e-4 * size);
                let tilt = [tilt * (0.5 + self.u[0]), tilt * (0.5 + self.u[1]), 4.0 * tilt];
                errors.base_compliance =
                    Some(flaws::BaseCompliance { tilt_stiffness: Some(tilt), sink_stiffness: None });
            }
            Cause::Backlash | Cause::Wear => errors.backlash.push(flaws::Backlash {
                joint,
                width_mrad: (!self.slide).then_some(mrad),
                width_mm: self.slide.then_some(mm),
                side: BacklashSide::Approach,
                flank_load: None,
            }),
            Cause::Eccentric | Cause::Mesh => errors.transmission.push(flaws::Transmission {
                joint,
                wheel: if self.cause == Cause::Mesh { Wheel::Mesh } else { Wheel::Eccentric },
                amplitude_mrad: mrad,
                cycles: (self.cause == Cause::Mesh).then(|| (3.0 + 20.0 * self.u[0]).round()),
                phase_deg: None,
            }),
            Cause::Coupling => errors.coupling.push(flaws::Dragging {
                joint,
                driver: self.driver.clone(),
                ratio_milli: mrad,
                eccentricity_mrad: 0.3 * mrad,
            }),
            Cause::Masses => errors.mass_scatter = 0.1 * size,
            Cause::Everything if self.masses_are_off() => errors.mass_scatter = 0.1,
            _ => {}
        }
    }
}
