//! Changes during the measurement: thermal growth, drift, sudden shifts.

use super::{Draft, Install, normal};
use crate::SimulateError;
use crate::physics::changes::{Amount, Change, Mover};
use crate::physics::curve::{Centred, SmoothCurve};
use nalgebra::Vector3;
use rand::Rng;
use rand_chacha::ChaCha8Rng;
use serde::{Deserialize, Serialize};
use truepose_kinematics::JointKind;

/// What grows with temperature.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Default, Serialize, Deserialize)]
#[serde(rename_all = "lowercase")]
pub enum Growing {
    /// The length of the link behind the joint, µm/(m·K).
    #[default]
    Length,
    /// The scale of a slide, µm/(m·K).
    Scale,
    /// The joint's own motion, µrad/K or µm/K.
    Motion,
    /// The base or the tool: translations µm/K and rotations µrad/K in a direction that is drawn.
    Frame,
}

/// Growth with temperature, at once or late.
#[derive(Debug, Clone, PartialEq, Default, Serialize, Deserialize)]
#[serde(default, deny_unknown_fields)]
pub struct Thermal {
    /// A joint's name, `base` or `tool`.
    pub at: String,
    /// What grows there.
    pub grows: Growing,
    /// How much a kelvin, in the units of `grows`.
    pub per_kelvin: f64,
    /// Time constant of the body, s; zero follows at once.
    pub lag_s: f64,
}

/// A slow walk away from where it began: its root mean square over the shop's day.
#[derive(Debug, Clone, PartialEq, Default, Serialize, Deserialize)]
#[serde(default, deny_unknown_fields)]
pub struct Drift {
    /// A joint's name, `base` or `tool`.
    pub at: String,
    /// Translation of base or tool, or of a slide, mm.
    pub size_mm: f64,
    /// Rotation of base or tool, or of a turn, mrad.
    pub size_mrad: f64,
    /// Memory, s; zero: half the shop's day.
    pub correlation_s: f64,
}

/// A bump.
#[derive(Debug, Clone, PartialEq, Default, Serialize, Deserialize)]
#[serde(default, deny_unknown_fields)]
pub struct Shift {
    /// A joint's name, `base` or `tool`.
    pub at: String,
    /// When, s.
    pub when_s: f64,
    /// Translation of base or tool, or of a slide, mm.
    pub size_mm: f64,
    /// Rotation of base or tool, or of a turn, mrad.
    pub size_mrad: f64,
}

impl Install for Thermal {
    fn install(&self, draft: &mut Draft<'_>, rng: &mut ChaCha8Rng) -> Result<(), SimulateError> {
        let micro = 1e-6 * self.per_kelvin;
        let mover = match self.grows {
            Growing::Length => Mover::Length(draft.joint(&self.at)?.index(), micro),
            Growing::Scale => {
                let slide = draft.joint_of(&self.at, JointKind::Prismatic, "growth of a scale")?;
                Mover::Scale(slide.index(), micro)
            }
            Growing::Motion => {
                Mover::Joint(draft.moving(&self.at, "growth of a joint's motion")?.index(), micro)
            }
            Growing::Frame => place(draft, &self.at, (micro, micro), rng)?,
        };
        let amount = Amount::Curve(draft.shop.body(self.lag_s)?);
        draft.truth.changes.push(Change { mover, amount });
        Ok(())
    }
}

impl Install for Drift {
    fn install(&self, draft: &mut Draft<'_>, rng: &mut ChaCha8Rng) -> Result<(), SimulateError> {
        let mover = place(draft, &self.at, (1e-3 * self.size_mm, 1e-3 * self.size_mrad), rng)?;
        let range = draft.shop.air.range();
        let memory = if self.correlation_s > 0.0 { self.correlation_s } else { (range.1 - range.0) / 2.0 };
        let walk = SmoothCurve::draw(range, memory, 1.0, Centred::Start, rng)?;
        draft.truth.changes.push(Change { mover, amount: Amount::Curve(walk) });
        Ok(())
    }
}

impl Install for Shift {
    fn install(&self, draft: &mut Draft<'_>, rng: &mut ChaCha8Rng) -> Result<(), SimulateError> {
        let mover = place(draft, &self.at, (1e-3 * self.size_mm, 1e-3 * self.size_mrad), rng)?;
        draft.truth.changes.push(Change { mover, amount: Amount::Since(self.when_s) });
        Ok(())
    }
}

/// A direction at base or tool, drawn, of this length and angle (m, rad); or a joint's own motion.
fn place(
    draft: &Draft<'_>,
    at: &str,
    (length, angle): (f64, f64),
    rng: &mut impl Rng,
) -> Result<Mover, SimulateError> {
    let mut direction = |size: f64| Vector3::from_fn(|_, _| normal(rng)).normalize() * size;
    let (t, r) = (direction(length), direction(angle));
    let six = [t.x, t.y, t.z, r.x, r.y, r.z];
    match at {
        "base" => Ok(Mover::Base(six)),
        "tool" => Ok(Mover::Tool(six)),
        name => {
            let id = draft.moving(name, "a change of a joint's motion")?;
            let turn = draft.chain.joint(id).kind == JointKind::Revolute;
            Ok(Mover::Joint(id.index(), if turn { angle } else { length }))
        }
    }
}

#[cfg(test)]
mod tests {
    use super::super::Flaws;
    use super::*;
    use crate::physics::changes::Moved;
    use crate::physics::temperature::Shop;
    use truepose_kinematics::samples;

    #[test]
    fn changes_have_their_place_and_size() {
        let air = SmoothCurve::through(0.0, 7200.0, vec![20.0, 25.0]).expect("a line");
        let shop = Shop { reference: 20.0, air };
        let flaws = Flaws {
            thermal: vec![Thermal { at: "a2".into(), per_kelvin: 12.0, ..Thermal::default() }],
            drift: vec![Drift { at: "tool".into(), size_mm: 0.1, ..Drift::default() }],
            shift: vec![Shift { at: "base".into(), when_s: 3000.0, size_mm: 0.3, size_mrad: 0.2 }],
            ..Flaws::default()
        };
        let (truth, _) = flaws.on(&samples::heavy(), &shop, 2).expect("a truth");
        let (early, late) = (Moved::at(&truth.changes, 0.0, 6), Moved::at(&truth.changes, 7200.0, 6));
        assert_eq!((early.base, early.tool), ([0.0; 6], [0.0; 6]));
        assert!((late.lengths[1] - 60e-6).abs() < 1e-12);
        let size = |v: &[f64]| v.iter().map(|x| x * x).sum::<f64>().sqrt();
        assert!((size(&late.base[..3]) - 3e-4).abs() < 1e-15 && (size(&late.base[3..]) - 2e-4).abs() < 1e-15);
        let square: f64 = (0..=100)
            .map(|k| size(&Moved::at(&truth.changes, 72.0 * f64::from(k), 6).tool[..3]).powi(2))
            .sum();
        assert!(((square / 101.0).sqrt() / 1e-4 - 1.0).abs() < 0.1);
    }
}
