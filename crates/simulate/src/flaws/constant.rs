//! Constant errors: frames, targets, and weights that differ from the description.

use super::{Draft, Install, normal};
use crate::SimulateError;
use nalgebra::Vector3;
use rand_chacha::ChaCha8Rng;
use serde::{Deserialize, Serialize};
use truepose_kinematics::Link;

/// Random constant errors: every component of every frame and target, normally distributed.
#[derive(Debug, Clone, PartialEq, Default, Serialize, Deserialize)]
#[serde(default, deny_unknown_fields)]
pub struct Geometric {
    /// Standard deviation of a translation, mm.
    pub position_mm: f64,
    /// Standard deviation of a rotation, mrad.
    pub angle_mrad: f64,
    /// Standard deviation of a target's coordinates, mm.
    pub target_mm: f64,
    /// Only at these frames (`base`, a joint's name, `tool`); empty: at all.
    pub frames: Vec<String>,
}

/// The constant error of one frame.
#[derive(Debug, Clone, PartialEq, Default, Serialize, Deserialize)]
#[serde(default, deny_unknown_fields)]
pub struct Displacement {
    /// `base`, a joint's name (the frame behind it), or `tool`.
    pub frame: String,
    /// Translation in the frame's axes, mm.
    pub xyz_mm: [f64; 3],
    /// Rotation vector in the frame's axes, mrad.
    pub turn_mrad: [f64; 3],
}

/// The true weight of a link.
#[derive(Debug, Clone, PartialEq, Default, Serialize, Deserialize)]
#[serde(default, deny_unknown_fields)]
pub struct LinkWeight {
    /// The joint that moves it.
    pub joint: String,
    /// kg.
    pub mass_kg: f64,
    /// Centre of mass in the frame after the joint, mm.
    pub com_mm: [f64; 3],
}

/// A target that is not where it is declared.
#[derive(Debug, Clone, PartialEq, Default, Serialize, Deserialize)]
#[serde(default, deny_unknown_fields)]
pub struct WrongTarget {
    /// Its name.
    pub target: String,
    /// How far off, tool axes, mm.
    pub offset_mm: [f64; 3],
}

/// The scatter of all link masses.
pub(super) struct Weights;

impl Install for Geometric {
    fn install(&self, draft: &mut Draft<'_>, rng: &mut ChaCha8Rng) -> Result<(), SimulateError> {
        let mut wanted = vec![self.frames.is_empty(); draft.truth.frames.len()];
        for name in &self.frames {
            wanted[frame(draft, name)?] = true;
        }
        for (by, wanted) in draft.truth.frames.iter_mut().zip(wanted) {
            for (k, value) in by.iter_mut().enumerate() {
                let size = 1e-3 * if k < 3 { self.position_mm } else { self.angle_mrad };
                let drawn = size * normal(rng);
                *value += if wanted { drawn } else { 0.0 };
            }
        }
        for off in &mut draft.truth.targets {
            *off += Vector3::from_fn(|_, _| 1e-3 * self.target_mm * normal(rng));
        }
        Ok(())
    }
}

impl Install for Displacement {
    fn install(&self, draft: &mut Draft<'_>, _: &mut ChaCha8Rng) -> Result<(), SimulateError> {
        let frame = frame(draft, &self.frame)?;
        for (k, value) in draft.truth.frames[frame].iter_mut().enumerate() {
            *value += 1e-3 * if k < 3 { self.xyz_mm[k] } else { self.turn_mrad[k - 3] };
        }
        Ok(())
    }
}

impl Install for LinkWeight {
    fn install(&self, draft: &mut Draft<'_>, _: &mut ChaCha8Rng) -> Result<(), SimulateError> {
        if self.mass_kg.is_nan() || self.mass_kg < 0.0 {
            let what = "the mass of a link";
            return Err(SimulateError::Size { what, value: self.mass_kg, need: "zero or more" });
        }
        let joint = draft.joint(&self.joint)?;
        let com = Vector3::from(self.com_mm) * 1e-3;
        draft.truth.joints[joint.index()].link = Some(Link { mass: self.mass_kg, com });
        Ok(())
    }
}

impl Install for Weights {
    fn install(&self, draft: &mut Draft<'_>, rng: &mut ChaCha8Rng) -> Result<(), SimulateError> {
        for joint in &mut draft.truth.joints {
            let factor = (draft.mass_scatter * normal(rng)).exp();
            if let Some(link) = &mut joint.link {
                link.mass *= factor;
            }
        }
        Ok(())
    }
}

impl Install for WrongTarget {
    fn install(&self, draft: &mut Draft<'_>, _: &mut ChaCha8Rng) -> Result<(), SimulateError> {
        let target = draft.chain.target_named(&self.target).ok_or_else(|| SimulateError::Unknown {
            what: "target",
            name: self.target.clone(),
            known: draft.chain.targets().iter().map(|target| target.name.clone()).collect(),
        })?;
        draft.truth.targets[target.0] += Vector3::from(self.offset_mm) * 1e-3;
        Ok(())
    }
}

/// The number of the frame of this name.
fn frame(draft: &Draft<'_>, name: &str) -> Result<usize, SimulateError> {
    draft.chain.frame_named(name).map(|frame| frame.0).ok_or_else(|| SimulateError::Unknown {
        what: "frame",
        name: name.into(),
        known: draft.chain.frames().map(|frame| draft.chain.frame_word(frame).to_owned()).collect(),
    })
}

#[cfg(test)]
mod tests {
    use super::super::Flaws;
    use super::*;
    use crate::physics::temperature::Shop;
    use truepose_kinematics::samples;

    #[test]
    fn constant_errors_stand_where_they_were_put() {
        let chain = samples::heavy();
        let flaws = Flaws {
            geometric: Some(Geometric {
                position_mm: 1.0,
                frames: vec!["a3".into()],
                ..Geometric::default()
            }),
            displacement: vec![Displacement {
                frame: "tool".into(),
                xyz_mm: [1.0, 0.0, 0.0],
                turn_mrad: [0.0, 0.0, 2.0],
            }],
            target: vec![WrongTarget { target: "T2".into(), offset_mm: [0.0, 0.5, 0.0] }],
            mass_scatter: 0.05,
            ..Flaws::default()
        };
        let shop = Shop::steady(20.0).expect("a shop");
        let (truth, _) = flaws.on(&chain, &shop, 8).expect("a truth");
        let touched: Vec<usize> = (0..8).filter(|&k| truth.frames[k].iter().any(|v| v.abs() > 0.0)).collect();
        assert_eq!(touched, [3, 7]);
        assert_eq!(truth.frames[7].to_vec(), [1e-3, 0.0, 0.0, 0.0, 0.0, 2e-3]);
        assert_eq!(truth.targets[1], Vector3::new(0.0, 5e-4, 0.0));
        let ratio = truth.joints[1].link.expect("a link").mass / 260.0;
        assert!((ratio - 1.0).abs() > 1e-6 && (0.8..1.25).contains(&ratio), "{ratio}");
    }
}
