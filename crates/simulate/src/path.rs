//! What the path between poses leaves behind in each joint.

use crate::{Campaign, Plant, SimulateError, Visit};
use truepose_kinematics::Conditions;

impl Plant {
    /// Error of each movable joint at each pose that depends on the path there, rad or m: friction with memory, creep, heat of its own. Before its
    /// first pose the robot came from the middle of its campaign, from far enough that the direction decides.
    pub(crate) fn path_errors(&self, campaign: &Campaign) -> Result<Vec<Vec<f64>>, SimulateError> {
        let movable = self.chain().movable();
        let mut errors = vec![vec![0.0; movable.len()]; campaign.visits.len()];
        let truths = || movable.iter().map(|joint| &self.truth().joints[joint.index()]);
        let loads = match truths().any(|truth| truth.creep.is_some() || truth.heating.is_some()) {
            true => self.loads_of(campaign)?,
            false => Vec::new(),
        };
        let times = campaign.times();
        for (coordinate, truth) in truths().enumerate() {
            let values: Vec<f64> = campaign.visits.iter().map(|visit| visit.joints[coordinate]).collect();
            let mut add = |more: Vec<f64>| {
                errors.iter_mut().zip(more).for_each(|(errors, more)| errors[coordinate] += more);
            };
            let load = || loads.iter().map(|loads| loads[coordinate]).collect::<Vec<f64>>();
            if let Some(creep) = &truth.creep {
                add(creep.errors(&times, &load()));
            }
            if let Some(heating) = &truth.heating {
                add(heating.errors(&times, &values, &load()));
            }
            let Some(friction) = &truth.presliding else { continue };
            let mut before = values.iter().sum::<f64>() / values.len().max(1) as f64;
            let mut memory = friction.fresh();
            for (errors, value) in errors.iter_mut().zip(values) {
                friction.advance(&mut memory, value - before);
                before = value;
                errors[coordinate] += friction.error(&memory);
            }
        }
        Ok(errors)
    }

    /// Load of each movable joint at each visit, N·m or N.
    fn loads_of(&self, campaign: &Campaign) -> Result<Vec<Vec<f64>>, SimulateError> {
        let at = |visit: &Visit| {
            self.joint_loads(&Conditions::at(self.chain(), &visit.joints).with_load(visit.load))
        };
        campaign.visits.iter().map(at).collect()
    }
}

#[cfg(test)]
mod tests {
    use crate::physics::presliding::Presliding;
    use crate::{Campaign, Plant, Truth};
    use truepose_kinematics::samples;

    #[test]
    fn friction_makes_a_pose_depend_on_where_it_came_from() {
        let chain = samples::ur10();
        let mut truth = Truth::of(&chain);
        truth.joints[0].presliding = Some(Presliding::Dahl { amplitude: 1e-4, width: 0.05 });
        let plant = Plant::new(&chain, truth).expect("a plant");
        let posture = |q: f64| [q, -1.0, 1.0, 0.3, 0.4, 0.5].to_vec();
        // To 0 from below, from above, and from just above.
        let way = [-1.0, 0.0, 1.0, 0.0, 1.0, -1.0, 0.02, 0.0];
        let campaign = Campaign::of(way.map(posture).to_vec());
        let errors = plant.path_errors(&campaign).expect("errors");
        assert!((errors[1][0] + 1e-4).abs() < 1e-12 && (errors[3][0] - 1e-4).abs() < 1e-12);
        assert!(errors[7][0].abs() < 9e-5, "{}", errors[7][0]);
        assert!(errors.iter().all(|e| e[1..].iter().all(|v| *v == 0.0)));
        let seen = plant.observe(&campaign, 1).expect("data");
        let apart = (seen.true_positions[1] - seen.true_positions[3]).norm();
        // 0.2 mrad on a reach of some hundred millimetres.
        assert!((2e-5..3e-4).contains(&apart), "{apart}");
        assert_eq!(seen.data.joints[0][1].to_bits(), 0f64.to_bits());
    }
}
