//! A robot with couplings: [`Coupling`] has the equation.

use crate::couplings::{Coupling, Couplings};
use crate::{Chain, ChainError, JointId};

impl Chain {
    /// With these couplings between the controller's values and the joints' variables. Limits of joints are taken as those of the
    /// controller's values; those of the variables become what the values can add up to. Joints that follow others still do.
    ///
    /// # Errors
    /// When a coupling is of joints that do not move or move differently, stands twice, has a factor that is not finite, or couplings
    /// form a circle.
    pub fn with_couplings(mut self, couplings: Vec<Coupling>) -> Result<Self, ChainError> {
        let terms = self.by_coordinates(&couplings)?;
        let movable = self.movable().to_vec();
        let limits: Vec<Option<(f64, f64)>> = movable.iter().map(|&joint| self.own_limits(joint)).collect();
        let coupled = Couplings::new(couplings, terms, limits.clone())?;
        for (k, (&joint, limits)) in movable.iter().zip(limits).enumerate() {
            let none = coupled.declared.is_empty();
            self.joint_mut(joint).limits = if none { limits } else { coupled.extent(k) };
        }
        let mimics = std::mem::take(&mut self.couplings.mimics);
        self.couplings = coupled;
        self.with_mimics(mimics)
    }

    /// With the couplings and limits of another description of the same moving joints.
    ///
    /// # Errors
    /// As [`Chain::with_couplings`]: when the moving joints are others.
    pub fn coupled_as(mut self, other: &Chain) -> Result<Self, ChainError> {
        let movable = self.movable().to_vec();
        let here = |joint: JointId| other.coordinate(joint).and_then(|k| movable.get(k)).copied();
        let mut declared = Vec::new();
        for (number, coupling) in other.couplings().iter().enumerate() {
            let reason = "a joint does not move";
            let (Some(joint), Some(driver)) = (here(coupling.joint), here(coupling.driver)) else {
                return Err(ChainError::Coupling { number: number + 1, reason });
            };
            declared.push(Coupling { joint, driver, factor: coupling.factor });
        }
        self.by_coordinates(&declared)?;
        for (&joint, &like) in movable.iter().zip(other.movable()) {
            self.joint_mut(joint).limits = other.joint(like).limits;
        }
        let mut mimics = other.mimics().to_vec();
        for (number, mimic) in mimics.iter_mut().enumerate() {
            let reason = "a joint does not move";
            let (Some(joint), Some(driver)) = (here(mimic.joint), here(mimic.driver)) else {
                return Err(ChainError::Coupling { number: number + 1, reason });
            };
            (mimic.joint, mimic.driver) = (joint, driver);
        }
        self.couplings = other.couplings.clone();
        self.couplings.declared = declared;
        self.couplings.mimics = mimics;
        Ok(self)
    }

    /// The couplings, as declared; none for most robots.
    pub fn couplings(&self) -> &[Coupling] {
        &self.couplings.declared
    }

    /// Lower and upper limit of a joint's value in the controller, rad or m. Without couplings these are the joint's limits.
    pub fn controller_limits(&self, joint: JointId) -> Option<(f64, f64)> {
        self.narrowed(joint, self.own_limits(joint))
    }

    fn own_limits(&self, joint: JointId) -> Option<(f64, f64)> {
        match self.coordinate(joint).and_then(|k| self.couplings.limits(k)) {
            Some(limits) => limits,
            None => self.joint(joint).limits,
        }
    }

    /// Turns the controller's values into the joints' variables, in place: one for each movable joint, rad or m.
    #[inline]
    pub fn joints_from_controller(&self, values: &mut [f64]) {
        self.couplings.variables(values);
    }

    /// Turns the joints' variables into the controller's values, in place.
    #[inline]
    pub fn joints_to_controller(&self, joints: &mut [f64]) {
        self.couplings.values(joints);
    }

    /// Whether the controller's values of these variables (one for each movable joint, rad or m) are within their limits, to 1e-9.
    /// True without couplings, where the joints' own limits are all there is.
    pub fn within_controller_limits(&self, joints: &[f64]) -> bool {
        self.couplings.within(joints)
    }

    /// Joint, driver and factor by coordinates.
    fn by_coordinates(&self, couplings: &[Coupling]) -> Result<Vec<(usize, usize, f64)>, ChainError> {
        let mut terms = Vec::new();
        for (number, coupling) in couplings.iter().enumerate() {
            let wrong = |reason| ChainError::Coupling { number: number + 1, reason };
            let coordinate = |joint: JointId| {
                let moving = Some(joint).filter(|joint| joint.0 > 0).and_then(|joint| self.coordinate(joint));
                moving.ok_or(wrong("a joint does not move"))
            };
            let (joint, driver) = (coordinate(coupling.joint)?, coordinate(coupling.driver)?);
            if joint == driver {
                return Err(wrong("a joint is not coupled to itself"));
            }
            if self.joint(coupling.joint).kind != self.joint(coupling.driver).kind {
                return Err(wrong("a revolute and a prismatic joint cannot be coupled"));
            }
            if !coupling.factor.is_finite() {
                return Err(wrong("the factor is not a finite number"));
            }
            if terms.iter().any(|&(a, b, _)| (a, b) == (joint, driver)) {
                return Err(wrong("the same two joints are coupled twice"));
            }
            terms.push((joint, driver, coupling.factor));
        }
        Ok(terms)
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::{Joint, JointKind, Placement, samples};
    use proptest::prelude::*;

    fn coupling(joint: usize, driver: usize, factor: f64) -> Coupling {
        Coupling { joint: JointId(joint), driver: JointId(driver), factor }
    }

    /// Joint 6 follows 5, which follows 4; joint 3 follows 2. Declared in no order.
    fn coupled() -> Chain {
        let list =
            vec![coupling(6, 5, -0.5), coupling(6, 4, 0.25), coupling(3, 2, 1.0), coupling(5, 4, 0.02)];
        samples::ur10().with_couplings(list).unwrap()
    }

    proptest! {
        #[test]
        fn variables_are_what_the_definition_says(u in prop::array::uniform6(-3.0..3.0f64)) {
            let chain = coupled();
            let expected = [
                u[0], u[1], u[2] + u[1], u[3], u[4] + 0.02 * u[3], u[5] - 0.5 * u[4] + 0.25 * u[3],
            ];
            let mut values = u;
            chain.joints_from_controller(&mut values);
            for k in 0..6 {
                prop_assert!((values[k] - expected[k]).abs() < 1e-14);
                prop_assert!((chain.couplings.value(k, &values) - u[k]).abs() < 1e-14);
            }
            chain.joints_to_controller(&mut values);
            for k in 0..6 {
                prop_assert!((values[k] - u[k]).abs() < 1e-14);
            }
        }
    }

    #[test]
    fn limits_are_those_of_the_controller() {
        let joint = |name: &str, lower: f64, upper: f64| {
            let row = Placement::Dh { theta: 0.0, d: 0.0, a: 1.0, alpha: 0.0 };
            Joint::new(name, JointKind::Revolute, row).with_limits(lower, upper)
        };
        let plain = Chain::new("r", vec![joint("a", -1.0, 2.0), joint("b", -0.5, 0.25)]).unwrap();
        let chain = plain.clone().with_couplings(vec![coupling(2, 1, -1.0)]).unwrap();
        assert_eq!(chain.joint(JointId(2)).limits, Some((-2.5, 1.25)));
        assert_eq!(chain.controller_limits(JointId(2)), Some((-0.5, 0.25)));
        // q = (2, −2): u_b = q_b + u_a = 0. q = (0, −2): u_b = −2.
        assert!(chain.within_controller_limits(&[2.0, -2.0]));
        assert!(!chain.within_controller_limits(&[0.0, -2.0]));
        // Once more, or on another robot of the same joints, nothing becomes wider.
        let again = chain.clone().with_couplings(chain.couplings().to_vec()).unwrap();
        assert_eq!(again, chain);
        assert_eq!(plain.clone().coupled_as(&chain).unwrap(), chain);
        assert_eq!(chain.with_couplings(vec![]).unwrap(), plain);
    }

    #[test]
    fn what_is_no_coupling_is_refused() {
        let error = |list: Vec<Coupling>| samples::scara().with_couplings(list).unwrap_err().to_string();
        assert_eq!(error(vec![coupling(1, 9, 1.0)]), "coupling 1: a joint does not move");
        assert_eq!(error(vec![coupling(1, 1, 1.0)]), "coupling 1: a joint is not coupled to itself");
        assert!(error(vec![coupling(3, 4, 1.0)]).contains("a revolute and a prismatic joint"));
        assert!(error(vec![coupling(2, 1, f64::NAN)]).contains("not a finite number"));
        assert!(error(vec![coupling(2, 1, 1.0), coupling(2, 1, 1.0)]).contains("coupling 2: the same two"));
        assert!(error(vec![coupling(2, 1, 1.0), coupling(1, 2, 1.0)]).contains("form a circle"));
    }
}
