//! A robot as it is, with the instrument that measures it.

use crate::equilibrium::{Assembly, Equilibrium};
use crate::physics::temperature::Shop;
use crate::rigid::to_pose;
use crate::{Blunders, Cell, Disturbances, Instrument, Repeatability, SimulateError, Truth};
use nalgebra::{Point3, Vector3};
use truepose_kinematics::{Chain, Conditions, Pose, TargetId};

/// A robot as it is: its description, everything that is wrong with it, and how it is measured.
#[derive(Debug, Clone)]
pub struct Plant {
    chain: Chain,
    assembly: Assembly,
    truth: Truth,
    /// Air and temperature of the shop.
    pub shop: Shop,
    /// The instrument.
    pub instrument: Instrument,
    /// How well the robot comes back.
    pub repeatability: Repeatability,
    /// What people get wrong.
    pub blunders: Blunders,
    /// What disturbs a campaign.
    pub disturbances: Disturbances,
    /// What stands around it.
    pub cell: Cell,
}

impl Plant {
    /// A robot without any error, measured without noise at 20 °C.
    ///
    /// # Errors
    /// None in practice: the shop's numbers are constants.
    pub fn perfect(chain: &Chain) -> Result<Self, SimulateError> {
        Plant::new(chain, Truth::of(chain))
    }

    /// A robot with these errors, measured without noise at 20 °C.
    ///
    /// # Errors
    /// [`SimulateError::Branches`] of a robot that is a tree, [`SimulateError::Shape`] when the truth has not the size of the robot.
    pub fn new(chain: &Chain, truth: Truth) -> Result<Self, SimulateError> {
        if !chain.is_serial() {
            return Err(SimulateError::Branches { robot: chain.name().into() });
        }
        truth.fits(chain)?;
        Ok(Plant {
            chain: chain.clone(),
            assembly: Assembly::of(chain),
            truth,
            shop: Shop::steady(20.0)?,
            instrument: Instrument::default(),
            repeatability: Repeatability::default(),
            blunders: Blunders::default(),
            disturbances: Disturbances::default(),
            cell: Cell::default(),
        })
    }

    /// The robot's description: what the identification is given.
    pub fn chain(&self) -> &Chain {
        &self.chain
    }

    /// Everything that is wrong with it.
    pub fn truth(&self) -> &Truth {
        &self.truth
    }

    /// The same plant with other errors.
    ///
    /// # Errors
    /// [`SimulateError::Shape`] when the truth has not the size of the robot.
    pub fn with_truth(mut self, truth: Truth) -> Result<Self, SimulateError> {
        truth.fits(&self.chain)?;
        self.truth = truth;
        Ok(self)
    }

    /// True pose of the tool in the measurement frame under these conditions, without any noise. The load is taken
    /// to be the true load; temperatures follow from the time alone, not from the channels.
    ///
    /// # Errors
    /// [`SimulateError::Shape`] for a wrong number of joint values, [`SimulateError::NoEquilibrium`] for a robot
    /// that cannot carry its load.
    pub fn true_pose(&self, conditions: &Conditions) -> Result<Pose, SimulateError> {
        Ok(to_pose(&self.equilibrium(conditions)?.tool))
    }

    /// True position of a target (none is the tool's origin) in the measurement frame, m, without any noise.
    ///
    /// # Errors
    /// Those of [`Plant::true_pose`], and [`SimulateError::Shape`] for a target that the robot lacks.
    pub fn true_position(
        &self,
        conditions: &Conditions,
        target: Option<TargetId>,
    ) -> Result<Vector3<f64>, SimulateError> {
        let equilibrium = self.equilibrium(conditions)?;
        Ok((equilibrium.tool * Point3::from(self.true_target(target)?)).coords)
    }

    /// Load about (N·m) or along (N) each joint's axis in static equilibrium, movable joints only.
    ///
    /// # Errors
    /// Those of [`Plant::true_pose`].
    pub fn joint_loads(&self, conditions: &Conditions) -> Result<Vec<f64>, SimulateError> {
        let equilibrium = self.equilibrium(conditions)?;
        Ok(self.chain.movable().iter().map(|joint| equilibrium.loads[joint.index()]).collect())
    }

    pub(crate) fn equilibrium(&self, conditions: &Conditions) -> Result<Equilibrium, SimulateError> {
        self.assembly.equilibrium(&self.truth, conditions)
    }

    /// The direction against gravity; z where there is none.
    pub(crate) fn up(&self) -> Vector3<f64> {
        self.assembly.up()
    }

    /// Where a target really sits in the tool's axes, m.
    pub(crate) fn true_target(&self, target: Option<TargetId>) -> Result<Vector3<f64>, SimulateError> {
        let Some(TargetId(k)) = target else { return Ok(Vector3::zeros()) };
        match (self.chain.targets().get(k), self.truth.targets.get(k)) {
            (Some(declared), Some(error)) => Ok(declared.position + error),
            _ => Err(SimulateError::Shape {
                what: "declared targets",
                have: self.chain.targets().len(),
                need: k + 1,
            }),
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use truepose_kinematics::samples;

    #[test]
    fn a_truth_of_another_robot_is_refused() {
        let truth = Truth::of(&samples::scara());
        assert!(matches!(Plant::new(&samples::ur10(), truth), Err(SimulateError::Shape { .. })));
        let mut truth = Truth::of(&samples::scara());
        truth.frames[2][4] = f64::NAN;
        assert!(matches!(Plant::new(&samples::scara(), truth), Err(SimulateError::Size { .. })));
    }

    #[test]
    fn a_displaced_target_moves_with_the_tool() {
        let chain = samples::heavy();
        let mut truth = Truth::of(&chain);
        truth.targets[1] = Vector3::new(1e-3, 0.0, 0.0);
        let plant = Plant::new(&chain, truth).expect("a plant");
        let perfect = Plant::perfect(&chain).expect("a plant");
        let at = Conditions::at(&chain, &[0.3, -0.4, 0.5, 0.6, -0.7, 0.8]);
        let moved = plant.true_position(&at, Some(TargetId(1))).expect("a position")
            - perfect.true_position(&at, Some(TargetId(1))).expect("a position");
        let x = perfect.true_pose(&at).expect("a pose").rotation.column(0) * 1e-3;
        assert!((moved - x).norm() < 1e-15);
        assert!(plant.true_position(&at, Some(TargetId(7))).is_err());
    }
}
