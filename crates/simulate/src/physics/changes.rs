//! Changes with time: thermal growth, drift, and sudden shifts.
//!
//! ```text
//! growth   κ · (T(t) − T_ref) · direction           T from a body of its own lag
//! drift    f(t) · direction                         f a smooth walk that begins at zero
//! shift    direction from the instant t_b on, nothing before
//! ```
//!
//! | symbol | here | unit | frame |
//! | --- | --- | --- | --- |
//! | direction | `Mover` | per unit of the amount | base, tool, a joint's own motion, a link's length, a slide's scale |
//! | T − T_ref | amount of a growth | K | |
//! | f | amount of a drift | 1 | |
//!
//! A [`Mover`] is the direction of one unit of a change; an [`Amount`] is the number of units at time t.
//! Source: Slocum, *Precision Machine Design*, section 2.3.5 (thermal growth).

use super::curve::SmoothCurve;

/// Direction in which one unit of a change moves the robot. Places are counted from 0.
#[derive(Debug, Clone, Copy, PartialEq)]
pub enum Mover {
    /// The base, `[tx ty tz rx ry rz]` in frame 0's axes, m and rad a unit.
    Base([f64; 6]),
    /// The tool, in the tool's axes, m and rad a unit.
    Tool([f64; 6]),
    /// A joint's own motion: its place and rad or m a unit.
    Joint(usize, f64),
    /// A link's length: the place of the joint in front of it, and strain a unit.
    Length(usize, f64),
    /// The scale of a slide: its place, and strain a unit.
    Scale(usize, f64),
    /// The compliance of a joint: its place, and by how much its logarithm grows a unit.
    Softer(usize, f64),
}

/// How many units of a change there are, over time.
#[derive(Debug, Clone, PartialEq)]
pub enum Amount {
    /// A temperature difference (K) or a walk (1), over s.
    Curve(SmoothCurve),
    /// None before the instant (s), one from it on.
    Since(f64),
    /// One between two instants (s), none before and after.
    During([f64; 2]),
    /// None before the instant `at` (s); then one, of which `part` goes back as 1 − 1/(1 + t/`time`).
    Settling {
        /// s.
        at: f64,
        /// 1.
        part: f64,
        /// s.
        time: f64,
    },
}

/// Something that changes with time.
#[derive(Debug, Clone, PartialEq)]
pub struct Change {
    /// The direction.
    pub mover: Mover,
    /// The amount.
    pub amount: Amount,
}

/// The sum of all changes at one moment.
#[derive(Debug, Clone, PartialEq)]
pub struct Moved {
    /// Of the base, in frame 0's axes.
    pub base: [f64; 6],
    /// Of the tool, in its axes.
    pub tool: [f64; 6],
    /// Of each joint's own motion, rad or m.
    pub joints: Vec<f64>,
    /// Strain of each link's length.
    pub lengths: Vec<f64>,
    /// Strain of each slide's scale.
    pub scales: Vec<f64>,
    /// Logarithm of the growth of each joint's compliance.
    pub softer: Vec<f64>,
}

impl Moved {
    /// Sum of these changes at this time (s) on a robot of `joints` joints.
    pub fn at(changes: &[Change], time: f64, joints: usize) -> Self {
        let mut moved = Moved {
            base: [0.0; 6],
            tool: [0.0; 6],
            joints: vec![0.0; joints],
            lengths: vec![0.0; joints],
            scales: vec![0.0; joints],
            softer: vec![0.0; joints],
        };
        let add = |sum: &mut [f64; 6], direction: [f64; 6], amount: f64| {
            for (sum, part) in sum.iter_mut().zip(direction) {
                *sum += amount * part;
            }
        };
        for change in changes {
            let amount = match &change.amount {
                Amount::Curve(curve) => curve.value(time),
                Amount::Since(instant) => f64::from(u8::from(time >= *instant)),
                Amount::During([from, until]) => f64::from(u8::from((*from..*until).contains(&time))),
                Amount::Settling { at, .. } if time < *at => 0.0,
                Amount::Settling { at, part, time: half } => {
                    let age = (time - at) / half;
                    1.0 - part * age / (1.0 + age)
                }
            };
            match change.mover {
                Mover::Base(direction) => add(&mut moved.base, direction, amount),
                Mover::Tool(direction) => add(&mut moved.tool, direction, amount),
                Mover::Joint(place, rate) => moved.joints[place] += amount * rate,
                Mover::Length(place, rate) => moved.lengths[place] += amount * rate,
                Mover::Scale(place, rate) => moved.scales[place] += amount * rate,
                Mover::Softer(place, rate) => moved.softer[place] += amount * rate,
            }
        }
        moved
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn changes_add_up_at_their_place_and_time() {
        let ramp = SmoothCurve::through(0.0, 100.0, vec![0.0, 5.0]).expect("a ramp");
        let changes = [
            Change { mover: Mover::Joint(1, 1e-5), amount: Amount::Curve(ramp.clone()) },
            Change { mover: Mover::Joint(1, 2e-4), amount: Amount::Since(50.0) },
            Change { mover: Mover::Tool([1e-3, 0.0, 0.0, 0.0, 0.0, 2e-3]), amount: Amount::Since(50.0) },
            Change { mover: Mover::Length(0, 1.2e-5), amount: Amount::Curve(ramp) },
        ];
        let before = Moved::at(&changes, 40.0, 2);
        assert!((before.joints[1] - 2e-5).abs() < 1e-15);
        assert_eq!(before.tool.to_vec(), [0.0; 6]);
        let after = Moved::at(&changes, 50.0, 2);
        assert!((after.joints[1] - 2.25e-4).abs() < 1e-15);
        assert_eq!(after.tool.to_vec(), [1e-3, 0.0, 0.0, 0.0, 0.0, 2e-3]);
        assert!((after.lengths[0] - 3e-5).abs() < 1e-18);
        let of =
            |amount, time| Moved::at(&[Change { mover: Mover::Softer(1, 0.1), amount }], time, 2).softer[1];
        let during = [49.0, 50.0, 60.0].map(|t| of(Amount::During([50.0, 60.0]), t));
        assert!(during.iter().zip([0.0, 0.1, 0.0]).all(|(found, expected)| (found - expected).abs() < 1e-15));
        let settling = Amount::Settling { at: 50.0, part: 0.8, time: 10.0 };
        assert!(
            (of(settling.clone(), 50.0) - 0.1).abs() < 1e-15 && (of(settling, 60.0) - 0.06).abs() < 1e-15
        );
    }
}
