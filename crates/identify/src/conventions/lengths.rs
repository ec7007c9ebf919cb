//! Which single length, corrected, explains what the nominal robot leaves.
//!
//! ```text
//! r_k = ∂p_k/∂(base, targets) · x + ∂p_k/∂l · δ        in the least-squares sense, for each length l of the description
//! ```
//!
//! | symbol | here | shape | unit |
//! | --- | --- | --- | --- |
//! | r_k | measured minus placed nominal position | 3 | m |
//! | x | change of base (6) and of each target seen from the flange (3) | 6 + 3 a target | m, rad |
//! | δ | change of the length | 1 | m |
//!
//! The equation is linear in base and targets only to first order: what it proposes is placed anew, corrected once, and judged by
//! what it leaves.

use super::misread::{Misread, Misreading, better, explains};
use super::placed::{flanges, left, placed};
use super::variants::undone;
use nalgebra::{DMatrix, DVector, Vector3};
use truepose_errormodel::Dataset;
use truepose_kinematics::{Chain, Joint, Placement, skew};

/// Proposals that are placed anew.
const TRIED: usize = 3;
/// Of the squares, a proposal explains this share at least.
const EXPLAINED: f64 = 0.5;

/// The length that, corrected, explains these rows, where there is one.
pub(super) fn misread(chain: &Chain, rows: &Dataset, before: f64) -> Option<Misread> {
    let mut proposals: Vec<(f64, usize, &'static str, f64)> = changes(chain, rows, lengths(chain))?
        .into_iter()
        .filter(|(after, ..)| *after < (1.0 - EXPLAINED).sqrt() * before)
        .collect();
    proposals.sort_by(|a, b| a.0.total_cmp(&b.0));
    let mut best = None;
    for (_, joint, parameter, mut change) in proposals.into_iter().take(TRIED) {
        let with = |change: f64| undone(&Misreading::Length { joint, parameter, change }, chain);
        let Some(once) = with(change) else { continue };
        // Once more from there: a base that has turned is only linear to first order.
        if let Some(&(_, _, _, more)) =
            changes(&once, rows, vec![(joint, parameter)]).as_deref().and_then(|found| found.first())
        {
            change += more;
        }
        let Some(after) = with(change).and_then(|other| left(&other, rows)) else { continue };
        if explains(before, after, chain.characteristic_length()) {
            let what = Misreading::Length { joint, parameter, change };
            better(&mut best, Misread { what, before, after });
        }
    }
    best
}

/// Joints and parameters of the lengths that may be wrong.
fn lengths(chain: &Chain) -> Vec<(usize, &'static str)> {
    let of = |joint: &Joint| -> &'static [&'static str] {
        match joint.placement {
            Placement::Origin { .. } => &["x", "y", "z"],
            _ => &["a", "d"],
        }
    };
    let joints = chain.joints().iter().enumerate();
    joints.flat_map(|(k, joint)| of(joint).iter().map(move |&parameter| (k, parameter))).collect()
}

/// For each of these lengths: the RMS that its best change leaves (m), and the change (m).
fn changes(
    chain: &Chain,
    rows: &Dataset,
    lengths: Vec<(usize, &'static str)>,
) -> Option<Vec<(f64, usize, &'static str, f64)>> {
    let placement = placed(chain, rows)?;
    let chain = &placement.chain;
    let flanges = flanges(chain, rows);
    let tool = chain.tool().pose;
    let point = |row: usize| rows.target[row].map_or(Vector3::zeros(), |t| chain.targets()[t.0].position);
    let offsets = 1 + chain.targets().len();
    let unknowns = 6 + 3 * offsets + 1;
    let mut a = DMatrix::<f64>::zeros(3 * rows.len(), unknowns);
    let mut r = DVector::<f64>::zeros(3 * rows.len());
    for (row, flange) in flanges.iter().enumerate() {
        let whole = chain.base().pose * *flange;
        let at = whole.apply(&tool.apply(&point(row)));
        let lever = at - chain.base().pose.translation;
        a.fixed_view_mut::<3, 3>(3 * row, 0).fill_with_identity();
        a.fixed_view_mut::<3, 3>(3 * row, 3).copy_from(&-skew(&lever));
        let offset = 6 + 3 * rows.target[row].map_or(0, |t| t.0 + 1);
        a.fixed_view_mut::<3, 3>(3 * row, offset).copy_from(&whole.rotation);
        r.fixed_rows_mut::<3>(3 * row).copy_from(&(rows.measured_position(row) - at));
    }
    let step = 1e-4 * chain.characteristic_length();
    let mut found = Vec::new();
    for (joint, parameter) in lengths {
        let Some(other) = undone(&Misreading::Length { joint, parameter, change: step }, chain) else {
            continue;
        };
        for (row, (from, to)) in flanges.iter().zip(super::placed::flanges(&other, rows)).enumerate() {
            let end = tool.apply(&point(row));
            let slope = chain.base().pose.rotation * (to.apply(&end) - from.apply(&end)) / step;
            a.fixed_view_mut::<3, 1>(3 * row, unknowns - 1).copy_from(&slope);
        }
        // Directions that base and targets share are no matter: what is left is asked for.
        let Ok(x) = a.clone().svd(true, true).solve(&r, 1e-9 * a.norm()) else { continue };
        let after = ((&r - &a * &x).norm_squared() / rows.len() as f64).sqrt();
        found.push((after, joint, parameter, x[unknowns - 1]));
    }
    Some(found)
}
