//! Constant generalized errors: the six components of `E_i`, and the positions of targets.
//!
//! `ε_i = c`, one unknown a site.

use super::checks::{frame_exists, target_exists};
use crate::lanes::{LaneEmission, LanePosture};
use crate::{Column, Effect, Emission, ModelError, UNBOUNDED};
use serde::{Deserialize, Serialize};
use truepose_kinematics::{Axis, Chain, FrameId, Posture, Site, TargetId};

/// Expected size of an angle, rad; lengths are expected at this share of the arm's characteristic length, so that all
/// columns move the end of the arm about equally far.
pub(super) const EXPECTED_ANGLE: f64 = 5e-4;

/// A frame, or all targets: the members of the `frames` list of a declaration.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Serialize, Deserialize)]
#[serde(untagged)]
pub enum Where {
    /// One frame, by its number.
    Frame(FrameId),
    /// The word `targets`: the positions of all declared targets.
    Targets(AllTargets),
}

/// The word `targets`.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Serialize, Deserialize)]
pub enum AllTargets {
    /// All declared targets.
    #[serde(rename = "targets")]
    All,
}

/// Constant errors of frames and targets.
#[derive(Debug, Clone, PartialEq, Default, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct Geometric {
    /// At which frames; all of them and the targets when absent.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub frames: Option<Vec<Where>>,
    /// Which components; all six when absent.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub components: Option<Vec<Axis>>,
}

impl Geometric {
    /// Calls `each` for every site of this effect, in the order of its columns.
    fn for_each_site(&self, chain: &Chain, mut each: impl FnMut(Site)) {
        let wanted = |axis: &Axis| self.components.as_ref().is_none_or(|list| list.contains(axis));
        let frame_sites = |frame: FrameId, each: &mut dyn FnMut(Site)| {
            Axis::ALL.into_iter().filter(wanted).for_each(|axis| each(Site::Frame(frame, axis)));
        };
        let target_sites = |each: &mut dyn FnMut(Site)| {
            for target in (0..chain.described_targets().len()).map(TargetId) {
                let axes = Axis::TRANSLATIONS.into_iter().filter(wanted);
                axes.for_each(|axis| each(Site::Target(target, axis)));
            }
        };
        match &self.frames {
            None => {
                chain.frames().for_each(|frame| frame_sites(frame, &mut each));
                target_sites(&mut each);
            }
            Some(list) => {
                for place in list {
                    match place {
                        Where::Frame(frame) => frame_sites(*frame, &mut each),
                        Where::Targets(AllTargets::All) => target_sites(&mut each),
                    }
                }
            }
        }
    }
}

impl Effect for Geometric {
    const FAMILY: &'static str = "geometric";
    const ABOUT: &'static str = "constant generalized errors of frames and targets";

    fn load_dependent(&self) -> bool {
        false
    }

    fn columns(&self, chain: &Chain) -> Vec<Column> {
        let length = chain.characteristic_length();
        let mut columns = Vec::new();
        self.for_each_site(chain, |site| {
            let axis = site.axis();
            let scale = if axis.is_rotation() { EXPECTED_ANGLE } else { EXPECTED_ANGLE * length };
            columns.push(Column {
                name: chain.site_word(site),
                unit: axis.unit().into(),
                scale,
                site: Some(site),
                bounds: UNBOUNDED,
            });
        });
        columns
    }

    fn eval(&self, at: &Posture<'_>, out: &mut Emission) {
        let mut column = 0;
        self.for_each_site(at.chain(), |site| {
            out.push(column, site, 1.0);
            column += 1;
        });
    }

    fn eval_lanes(&self, at: &LanePosture<'_>, out: &mut LaneEmission) -> bool {
        let mut column = 0;
        self.for_each_site(at.chain(), |site| {
            out.push(column, site, LaneEmission::ONE);
            column += 1;
        });
        true
    }

    fn validate(&self, chain: &Chain) -> Result<(), ModelError> {
        for place in self.frames.iter().flatten() {
            match place {
                Where::Frame(frame) => frame_exists(Self::FAMILY, *frame, chain)?,
                Where::Targets(AllTargets::All) => target_exists(Self::FAMILY, TargetId(0), chain)?,
            }
        }
        let refused_for =
            |reason: &str| ModelError::Parameters { kind: Self::FAMILY.into(), reason: reason.into() };
        if self.frames.as_ref().is_some_and(Vec::is_empty) {
            return Err(refused_for("`frames` is empty; leave it out for all frames"));
        }
        if self.components.as_ref().is_some_and(Vec::is_empty) {
            return Err(refused_for("`components` is empty; leave it out for all components"));
        }
        if let Some(list) = &self.frames {
            for (k, place) in list.iter().enumerate() {
                if list[..k].contains(place) {
                    return Err(refused_for("a frame stands twice in `frames`"));
                }
            }
        }
        if let Some(list) = &self.components {
            for (k, axis) in list.iter().enumerate() {
                if list[..k].contains(axis) {
                    return Err(refused_for("a component stands twice in `components`"));
                }
            }
        }
        Ok(())
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::testkit::check_effect;
    use truepose_kinematics::samples;

    #[test]
    fn conforms() {
        for chain in samples::all() {
            check_effect(&Geometric::default(), &chain);
        }
    }

    #[test]
    fn default_covers_every_frame_and_target() {
        let chain = samples::pps();
        assert_eq!(Effect::columns(&Geometric::default(), &chain).len(), chain.site_count());
    }

    #[test]
    fn a_part_can_be_chosen() {
        let chain = samples::pps();
        let json = r#"{"frames": [0, 2, "targets"], "components": ["x", "rz"]}"#;
        let effect: Geometric = serde_json::from_str(json).unwrap();
        let names: Vec<String> = Effect::columns(&effect, &chain).into_iter().map(|c| c.name).collect();
        let expected = ["x@base", "rz@base", "x@d2", "rz@d2", "x@target P1", "x@target P2", "x@target P3"];
        assert_eq!(names, expected);
        check_effect(&effect, &chain);
    }
}
