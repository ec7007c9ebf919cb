//! What the path between poses leaves behind in each joint.

use crate::{Campaign, Plant};

impl Plant {
    /// Error of each movable joint at each pose that depends on the path there, rad or m: friction with memory. Before its
    /// first pose the robot came from the middle of its campaign, from far enough that the direction decides.
    pub(crate) fn path_errors(&self, campaign: &Campaign) -> Vec<Vec<f64>> {
        let movable = self.chain().movable();
        let mut errors = vec![vec![0.0; movable.len()]; campaign.visits.len()];
        for (coordinate, joint) in movable.iter().enumerate() {
            let Some(friction) = &self.truth().joints[joint.index()].presliding else { continue };
            let at = |k: usize| campaign.visits[k].joints[coordinate];
            let count = campaign.visits.len();
            let mut before = (0..count).map(at).sum::<f64>() / count.max(1) as f64;
            let mut memory = friction.fresh();
            for (k, errors) in errors.iter_mut().enumerate() {
                friction.advance(&mut memory, at(k) - before);
                before = at(k);
                errors[coordinate] = friction.error(&memory);
            }
        }
        errors
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
        let errors = plant.path_errors(&campaign);
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
