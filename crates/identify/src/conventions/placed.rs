//! Base, tool and targets where they fit the positions best.

use crate::{Placement, place};
use truepose_errormodel::Dataset;
use truepose_kinematics::{Chain, Placed, Pose};

/// Base and tool where they fit the positions best.
pub(super) fn placed(chain: &Chain, rows: &Dataset) -> Option<Placement> {
    let free = |placed: &Placed| Placed { known: false, ..*placed };
    let base = free(chain.base());
    let chain = chain.clone().with_base(base).and_then(|chain| chain.map_tools(free)).ok()?;
    let mut positions = rows.clone();
    positions.orientation.fill(None);
    place(&chain, &positions).ok()
}

/// RMS of the positions with base and tool where they fit best, m.
pub(super) fn left(chain: &Chain, rows: &Dataset) -> Option<f64> {
    placed(chain, rows).map(|placement| placement.rms)
}

/// The flange in frame 0 at each row.
pub(super) fn flanges(chain: &Chain, rows: &Dataset) -> Vec<Pose> {
    let bare = chain.clone().with_base(Placed::default()).and_then(|c| c.map_tools(|_| Placed::default()));
    let bare = bare.unwrap_or_else(|_| chain.clone());
    let joints = |row: usize| rows.joints.iter().map(|column| column[row]).collect::<Vec<f64>>();
    (0..rows.len()).map(|row| bare.forward(&joints(row))).collect()
}

/// Rows with a whole position, no more than so many, evenly taken.
pub(super) fn some(data: &Dataset, most: usize) -> Dataset {
    let whole = |row: &usize| data.whole_position(*row);
    let measured: Vec<usize> = (0..data.len()).filter(whole).collect();
    let few: Vec<usize> = measured.iter().step_by(measured.len().div_ceil(most).max(1)).copied().collect();
    data.select(&few)
}
