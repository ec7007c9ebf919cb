//! Which member of a set of errors that look alike is kept: a fixed order, in which names play no part.
//!
//! base, tool and targets, joint motions, lengths, the rest; after the constant errors everything else in the order
//! of the model. Ties go to the lower frame, then to the order of a twist.

use truepose_errormodel::ErrorModel;
use truepose_kinematics::{Axis, Chain, FrameId, JointId, JointKind, Site};

/// Columns from the most to the least preferred.
pub fn preference(model: &ErrorModel) -> Vec<usize> {
    let chain = model.chain();
    let columns = model.columns();
    let mut order: Vec<usize> = (0..columns.len()).collect();
    order.sort_by_key(|&column| match columns[column].site {
        Some(site) => (class(chain, site), chain.site_index(site), column),
        None => (Class::Function, 0, column),
    });
    order
}

#[derive(Debug, Clone, Copy, PartialEq, Eq, PartialOrd, Ord)]
enum Class {
    Base,
    ToolOrTarget,
    Motion,
    Length,
    Rest,
    Function,
}

fn class(chain: &Chain, site: Site) -> Class {
    match site {
        Site::Frame(FrameId::BASE, _) => Class::Base,
        Site::Frame(frame, _) if chain.tool_of(frame).is_some() => Class::ToolOrTarget,
        Site::Target(..) => Class::ToolOrTarget,
        Site::Frame(..) if motion_at(chain, site).is_some() => Class::Motion,
        Site::Frame(_, axis) if !axis.is_rotation() => Class::Length,
        Site::Frame(..) => Class::Rest,
    }
}

/// The joint whose own motion lies along this site, and its sign (an axis may be negative). A skew axis lies
/// along no single site.
pub fn motion_at(chain: &Chain, site: Site) -> Option<(JointId, f64)> {
    let Site::Frame(frame, axis) = site else { return None };
    (1..=chain.joints().len()).map(JointId).find_map(|joint| {
        let motion = chain.joint_motion(joint)?;
        let turns = motion.kind == JointKind::Revolute;
        let along = motion.axis[axis.direction()];
        (motion.frame == frame && turns == axis.is_rotation() && along.abs() > 1.0 - 1e-12)
            .then_some((joint, along.signum()))
    })
}

/// A column in a reader's words, and the sign with which they stand for it: `y@j2`, `turn(j2)`, `slide(d1)`.
pub fn column_word(model: &ErrorModel, column: usize) -> (String, f64) {
    let chain = model.chain();
    let described = &model.columns()[column];
    match described.site {
        Some(site @ Site::Frame(frame, _)) if frame != FrameId::BASE && chain.tool_of(frame).is_none() => {
            match motion_at(chain, site) {
                Some((joint, sign)) => {
                    let verb = if site.axis() >= Axis::Rx { "turn" } else { "slide" };
                    (format!("{verb}({})", chain.joint(joint).name), sign)
                }
                None => (described.name.clone(), 1.0),
            }
        }
        _ => (described.name.clone(), 1.0),
    }
}
