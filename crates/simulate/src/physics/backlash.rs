//! Backlash: a dead band, and the flank on which the joint lies.
//!
//! ```text
//! δ = (w/2) · side,      side = −approach                          by approach: the link lags behind the motor
//!                        side = sat(τ/τ_f)                         by load: the load determines the flank
//!                        side = −approach (1 − p + p |τ|/(|τ| + τ_h))   friction that grows with the load and saturates
//!                        side = sat(τ/τ_f) where |τ| ≥ τ_f, else a mixture of both
//! ```
//!
//! | symbol | here | unit |
//! | --- | --- | --- |
//! | w | `width` | rad or m: the whole dead band |
//! | τ_f | `flank_load` | N·m or N: the load that presses the joint against its flank |
//! | p, τ_h | `part`, `half_load`: the part of the wind-up that follows the load, and the load at which half of it is reached | 1, N·m or N |
//! | approach | the direction of the last move | −1, 0, +1 |
//!
//! Inside the band, friction and seals act as a low stiffness: below τ_f the position is proportional to the load.
//! Source: Nordin and Gutman, *Controlling mechanical systems with backlash – a survey* (2002), section 2.

/// What determines the flank on which the joint lies.
#[derive(Debug, Clone, Copy, PartialEq)]
pub enum Side {
    /// The direction of the last move.
    Approach,
    /// The load about or along the axis.
    Load {
        /// N·m or N.
        flank_load: f64,
    },
    /// The last move, by friction that grows with the load.
    Friction {
        /// The part that follows the load.
        part: f64,
        /// N·m or N.
        half_load: f64,
    },
    /// The load where it is heavy enough, the last move where it is not.
    LoadThenApproach {
        /// N·m or N.
        flank_load: f64,
    },
}

/// The dead band of one joint.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct DeadBand {
    /// The whole dead band, rad or m.
    pub width: f64,
    /// What determines the flank.
    pub side: Side,
}

impl DeadBand {
    /// The joint's error, rad or m, for the direction of its last move and the load about or along its axis.
    pub fn error(&self, approach: f64, load: f64) -> f64 {
        let pressed = |flank_load: f64| (load / flank_load).clamp(-1.0, 1.0);
        let side = match self.side {
            Side::Approach => -approach,
            Side::Load { flank_load } => pressed(flank_load),
            Side::Friction { part, half_load } => {
                -approach * (1.0 - part + part * load.abs() / (load.abs() + half_load))
            }
            Side::LoadThenApproach { flank_load } => {
                let pressed = pressed(flank_load);
                pressed - approach * (1.0 - pressed.abs())
            }
        };
        0.5 * self.width * side
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[track_caller]
    fn check(side: Side, approach: f64, load: f64, expected: f64) {
        let got = DeadBand { width: 2.0, side }.error(approach, load);
        assert!((got - expected).abs() < 1e-15, "{got} against {expected}");
    }

    #[test]
    fn by_approach_the_link_lags_behind() {
        check(Side::Approach, 1.0, 500.0, -1.0);
        check(Side::Approach, -1.0, 500.0, 1.0);
        check(Side::Approach, 0.0, 500.0, 0.0);
    }

    #[test]
    fn by_load_the_link_lies_on_the_flank_of_its_load() {
        check(Side::Load { flank_load: 20.0 }, 1.0, -500.0, -1.0);
        check(Side::Load { flank_load: 20.0 }, 1.0, 5.0, 0.25);
    }

    #[test]
    fn under_a_light_load_the_last_move_determines_the_flank() {
        let side = Side::LoadThenApproach { flank_load: 20.0 };
        check(side, 1.0, 0.0, -1.0);
        check(side, 1.0, 10.0, 0.0);
        check(side, 1.0, 60.0, 1.0);
    }
}
