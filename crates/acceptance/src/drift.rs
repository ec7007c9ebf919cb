//! Drift of pose characteristics dAP and dRP: AP and RP of blocks of ten cycles in the order of time, against the first block.
//!
//! ```text
//! dAP_p = max_t |AP_p(1) − AP_p(t)|        dRP_p = max_t |RP(1) − RP(t)|
//! ```
//!
//! What all readings of a pose share cancels in the means, not in the length AP_p; it is left out of dAP. Source: ISO 9283:1998, 7.6, where a
//! block has ten cycles.

use crate::figure::{Figure, Method, welch_satterthwaite};
use crate::pose::{PoseFigures, pose_figures};
use nalgebra::Vector3;

/// Cycles of a block.
pub const BLOCK: usize = 10;

/// Drift of one pose.
#[derive(Debug, Clone, PartialEq)]
pub struct DriftFigures {
    /// Number of blocks.
    pub blocks: usize,
    /// Time from the first to the last cycle, s; none where the data has no time.
    pub duration: Option<f64>,
    /// dAP_p, m.
    pub dap: Figure,
    /// dRP_p, m.
    pub drp: Figure,
    /// AP_p of each block, m.
    pub ap: Vec<f64>,
    /// RP_l of each block, m.
    pub rp: Vec<f64>,
}

/// Of deviations in the order of time; none with fewer than two blocks. Cycles behind the last whole block are left out.
pub fn drift_figures(positions: &[Vector3<f64>], times: Option<&[f64]>) -> Option<DriftFigures> {
    let blocks: Vec<PoseFigures> =
        positions.chunks_exact(BLOCK).map(|block| pose_figures(block, &[], 0.0)).collect();
    let (first, later) = blocks.split_first().filter(|(_, later)| !later.is_empty())?;
    let largest = |of: fn(&PoseFigures) -> &Figure| {
        let begin = of(first);
        let one = |block: &PoseFigures| {
            let (now, parts) =
                (of(block), [(begin.u.powi(2), begin.freedom), (of(block).u.powi(2), of(block).freedom)]);
            let u = (parts[0].0 + parts[1].0).sqrt();
            Figure::with_u(
                (begin.value - now.value).abs(),
                u,
                welch_satterthwaite(&parts),
                Method::FirstOrder,
            )
        };
        later.iter().map(one).fold(None, |most: Option<Figure>, next| match most {
            Some(most) if most.value >= next.value => Some(most),
            _ => Some(next),
        })
    };
    let duration = times.and_then(|times| Some(times.last()? - times.first()?));
    Some(DriftFigures {
        blocks: blocks.len(),
        duration,
        dap: largest(|block| &block.ap)?,
        drp: largest(|block| &block.rp)?,
        ap: blocks.iter().map(|block| block.ap.value).collect(),
        rp: blocks.iter().map(|block| block.rp.value).collect(),
    })
}
