//! Directions of a placement that the data does not fix, in words, and what would fix them.

use super::refine::{Refined, Unknowns, scales};
use super::sight::Sight;
use nalgebra::{DMatrix, Vector3};
use truepose_errormodel::Dataset;
use truepose_kinematics::{Chain, JointKind};
use truepose_solvers::ColumnScale;

/// One direction that stays as described.
#[derive(Debug, Clone, PartialEq)]
pub struct Undetermined {
    /// What is not fixed, in words.
    pub what: String,
    /// What would fix it.
    pub advice: String,
    /// Whether it is how tools are turned, and nothing else.
    pub turn_of_tools_alone: bool,
}

/// Directions along which the sights would not notice a move: a metre (or the angle that moves the arm's end by a
/// metre) changes them by less than this many metres.
const UNNOTICED: f64 = 1e-7;

/// Those directions, and how many measured numbers there are beyond the unknowns that they determine.
pub(super) fn undetermined(
    chain: &Chain,
    unknowns: &Unknowns,
    refined: &Refined,
    sights: &[Sight],
    data: &Dataset,
) -> (Vec<Undetermined>, usize) {
    let measured =
        |sight: &Sight| 3 * (usize::from(sight.position.is_some()) + usize::from(sight.rotation.is_some()));
    let measured: usize = sights.iter().map(measured).sum();
    let spare = |null: usize| measured.saturating_sub(unknowns.count() - null);
    let scale = scales(unknowns, chain.characteristic_length());
    let Ok(turned) = refined.factor.directions(ColumnScale::Given(&scale)) else {
        return (Vec::new(), spare(0));
    };
    let least = UNNOTICED * (sights.len() as f64).sqrt();
    let null: Vec<usize> = (0..turned.values.len()).filter(|&k| turned.values[k] < least).collect();
    if null.is_empty() {
        return (Vec::new(), spare(0));
    }
    let basis = turned.vectors.select_columns(&null);
    let involved = involved(chain, unknowns, &basis);
    let directions = if basis.ncols() == 1 {
        "one direction".to_string()
    } else {
        format!("{} directions", basis.ncols())
    };
    let words: Vec<&str> = involved.iter().map(|block| block.words.as_str()).collect();
    let found = Undetermined {
        what: format!("{directions} of {}", words.join(", ")),
        advice: advice(chain, unknowns, sights, data),
        turn_of_tools_alone: involved.iter().all(|block| block.turns_a_tool),
    };
    (vec![found], spare(null.len()))
}

/// Three unknowns.
struct Block {
    words: String,
    at: usize,
    turns_a_tool: bool,
}

/// Which unknowns take part in the directions.
fn involved(chain: &Chain, unknowns: &Unknowns, basis: &DMatrix<f64>) -> Vec<Block> {
    let block = |words: String, at: usize| Block { words, at, turns_a_tool: false };
    let mut blocks: Vec<Block> = Vec::new();
    if unknowns.base {
        blocks.push(block("position of the base".into(), 0));
        blocks.push(block("orientation of the base".into(), 3));
    }
    for &tool in &unknowns.tools {
        if let Some(at) = unknowns.tool_column(tool) {
            let word = chain.frame_word(chain.frame_of_tool(tool));
            blocks.push(block(format!("position of the {word}"), at));
            let turn = block(format!("orientation of the {word}"), at + 3);
            blocks.push(Block { turns_a_tool: true, ..turn });
        }
    }
    for &target in &unknowns.targets {
        if let Some(at) = unknowns.target_column(target) {
            blocks.push(block(format!("position of target {}", chain.targets()[target.0].name), at));
        }
    }
    blocks.retain(|block| basis.view((block.at, 0), (3, basis.ncols())).norm() > 1e-3);
    blocks
}

fn advice(chain: &Chain, unknowns: &Unknowns, sights: &[Sight], data: &Dataset) -> String {
    let moved: Vec<&str> = chain
        .movable()
        .iter()
        .enumerate()
        .filter(|(k, _)| {
            let column = &data.joints[*k];
            let first = column.first().copied().unwrap_or(0.0);
            column.iter().any(|v| (v - first).abs() > 1e-6)
        })
        .map(|(_, &joint)| chain.joint(joint).name.as_str())
        .collect();
    let turning = chain
        .movable()
        .iter()
        .filter(|j| {
            chain.joint(**j).kind == JointKind::Revolute && moved.contains(&chain.joint(**j).name.as_str())
        })
        .count();
    let turned = sights.iter().any(|s| s.rotation.is_some());
    let mut seen: Vec<Vector3<f64>> = Vec::new();
    for sight in sights {
        let at = sight.target.map_or(Vector3::zeros(), |t| chain.targets()[t.0].position);
        if !seen.iter().any(|s| (s - at).norm() < 1e-9) {
            seen.push(at);
        }
    }
    if moved.len() < 2 {
        let only = moved.first().map_or("no joint moved".to_string(), |name| format!("only {name} moved"));
        return format!("{only}: move at least two joints whose axes are not parallel");
    }
    if turning < 2 && !turned {
        return "move at least two turning joints whose axes are not parallel, or measure orientations"
            .into();
    }
    if !turned && !unknowns.tools.is_empty() && seen.len() < 3 {
        return "positions of fewer than three targets do not show how the tool is turned: measure orientations, or \
                three targets that are not on a line; until then the tool's orientation stays as described"
            .into();
    }
    if !turned && collinear(&seen) {
        return "all targets lie on one line: add one beside it".into();
    }
    "move more joints, over wider ranges".into()
}

fn collinear(points: &[Vector3<f64>]) -> bool {
    let Some(first) = points.first() else { return true };
    let Some(far) = points.iter().max_by(|a, b| (*a - first).norm().total_cmp(&(*b - first).norm())) else {
        return true;
    };
    let along = far - first;
    points.iter().all(|p| (p - first).cross(&along).norm() < 1e-6 * along.norm_squared().max(1e-12))
}
