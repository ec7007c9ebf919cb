//! The loads of all joints in the nominal postures of a record, computed once: every history of a load asks for them again.

use nalgebra::DMatrix;
use std::sync::{Arc, Mutex, PoisonError};
use truepose_kinematics::{Chain, Conditions, Load, PostureBuffer};

/// Loads of the robot that asked last; nothing that a record is compared by.
#[derive(Debug, Default)]
pub(super) struct NominalLoads(Mutex<Option<(Chain, Arc<DMatrix<f64>>)>>);

impl PartialEq for NominalLoads {
    fn eq(&self, _: &Self) -> bool {
        true
    }
}

impl NominalLoads {
    /// The loads of this robot at these joint values (a column for each joint) and loads of the tool, N·m or N: poses × movable joints.
    pub fn of(&self, chain: &Chain, poses: (&[Vec<f64>], &[Load])) -> Arc<DMatrix<f64>> {
        // A thread that panicked while it computed has left what was there before.
        let mut known = self.0.lock().unwrap_or_else(PoisonError::into_inner);
        if let Some((of, loads)) = &*known
            && of == chain
        {
            return Arc::clone(loads);
        }
        let loads = Arc::new(computed(chain, poses));
        *known = Some((chain.clone(), Arc::clone(&loads)));
        loads
    }
}

fn computed(chain: &Chain, (joints, load): (&[Vec<f64>], &[Load])) -> DMatrix<f64> {
    let mut buffer = PostureBuffer::new(chain);
    let mut conditions = Conditions::at(chain, &vec![0.0; chain.movable().len()]);
    let mut loads = DMatrix::zeros(load.len(), chain.movable().len());
    for (pose, &own) in load.iter().enumerate() {
        for (value, column) in conditions.joints.iter_mut().zip(joints) {
            *value = column[pose];
        }
        conditions.load = own;
        let posture = buffer.update(chain, &conditions);
        for (column, &joint) in chain.movable().iter().enumerate() {
            loads[(pose, column)] = posture.joint_load(joint);
        }
    }
    loads
}

#[cfg(test)]
mod tests {
    use super::*;
    use truepose_kinematics::{Payload, samples};

    #[test]
    fn loads_are_those_of_the_robot_that_asks() {
        let chain = samples::ur10();
        let count = chain.movable().len();
        let joints: Vec<Vec<f64>> =
            (0..count).map(|j| (0..5).map(|k| (0.7 * ((k + 2) * (j + 1)) as f64).sin()).collect()).collect();
        let load = [Load::Payload(Payload { mass: 8.0, com: [0.1, 0.0, 0.0].into() }); 5];
        let known = NominalLoads::default();
        let own = known.of(&chain, (&joints, &load));
        assert!(Arc::ptr_eq(&own, &known.of(&chain, (&joints, &load))), "computed once");
        assert!(own.amax() > 1.0);
        let same_joints = |other: &Chain| other.movable().len() == count && *other != chain;
        let other = samples::all().into_iter().find(same_joints).expect("another robot of six joints");
        assert_ne!(known.of(&other, (&joints, &load)), own);
        assert_eq!(known.of(&chain, (&joints, &load)), own);
    }
}
