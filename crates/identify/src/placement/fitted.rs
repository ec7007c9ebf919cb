//! The placement of a robot whose errors are known: an identified arm in another installation.
//!
//! ```text
//! p_k = R_B (F_k y_τ) + t_B,    F_k = (B E_base)⁻¹ … of the fitted model at row k, with everything that it knows
//! ```
//!
//! F_k is the flange as the fitted model has it, base and tool left out; all other unknowns are those of [`super::search`]. What the model
//! says depends on the placement a little (the weight of a payload acts elsewhere, where the base is turned against gravity), so that it is
//! asked again at the placement found, until nothing moves.

use super::refine::{State, Unknowns, refine};
use super::search::{Placement, ROWS_TO_REFINE, best, sights_of};
use super::sight::Sight;
use super::undetermined::undetermined;
use crate::IdentifyError;
use nalgebra::Vector3;
use truepose_errormodel::{Dataset, FittedModel};
use truepose_kinematics::{Chain, Conditions, Placed, Pose, Target};

/// How often the model is asked at most; each time leaves the product of two small errors of the time before.
const ROUNDS: usize = 12;
/// Steps of the refinement from one placement to the next.
const STEPS: usize = 20;
/// A move, m or rad, below which the placement stands.
const STILL: f64 = 1e-11;

/// Finds base, tool and targets that are marked `known = false` in `chain`, for the arm of a fit with all of its errors; none of them: the
/// chain as it is. `chain` is the fit's robot, with another base, tool or targets.
///
/// # Errors
/// When the data lacks what the model reads, or too little was measured to find anything at all.
pub fn place_fitted(fitted: &FittedModel, chain: &Chain, data: &Dataset) -> Result<Placement, IdentifyError> {
    data.validate(chain)?;
    let unknowns = Unknowns::of(chain, data);
    if unknowns.is_empty() {
        return Ok(Placement::known(chain.clone()));
    }
    let data = &*data.derived_for(fitted.model())?;
    let mut state = State::of(chain);
    let mut found = None;
    for _ in 0..ROUNDS {
        let (sights, offsets) = sights(&fitted.on(at(chain, &unknowns, &state)?)?, data)?;
        // The tool is part of the flange: what is found is how it moves.
        let targets = state.targets.iter().zip(&offsets).map(|(at, offset)| at + offset).collect();
        let tools = vec![Pose::IDENTITY; state.tools.len()];
        let start = State { base: state.base, tools, targets };
        let bare = at(chain, &unknowns, &start)?;
        let refined = match found {
            None => best(&bare, &unknowns, &sights)?,
            Some(_) => refine(&bare, &unknowns, &sights, start, chain.characteristic_length(), STEPS),
        };
        let next = State {
            base: refined.state.base,
            tools: both(&state.tools, &refined.state.tools).map(|(a, b)| (*a * *b).renormalised()).collect(),
            targets: refined.state.targets.iter().zip(&offsets).map(|(at, offset)| at - offset).collect(),
        };
        let still = distance(&state, &next) < STILL;
        state = next;
        found = Some((bare, sights, refined));
        if still {
            break;
        }
    }
    let placed = state.applied(chain, &unknowns)?;
    let Some((bare, sights, refined)) = found else {
        return Ok(Placement::known(placed));
    };
    let (undetermined, spare) = undetermined(&bare, &unknowns, &refined, &sights, data);
    Ok(Placement { chain: placed, found: unknowns.words(chain), rms: refined.rms, undetermined, spare })
}

/// The robot with these values, and what is unknown still marked so.
fn at(chain: &Chain, unknowns: &Unknowns, state: &State) -> Result<Chain, IdentifyError> {
    let wrong = |error: truepose_kinematics::ChainError| IdentifyError::Placement {
        what: unknowns.words(chain).join(", "),
        why: error.to_string(),
    };
    let targets = chain.targets().iter().zip(&state.targets);
    let targets = targets.map(|(target, &position)| Target { position, ..target.clone() }).collect();
    let placed = both(chain.tools(), &state.tools);
    let tools: Vec<Placed> = placed.map(|(tool, &pose)| Placed { pose, ..tool.placed }).collect();
    chain
        .clone()
        .with_base(Placed { pose: state.base, ..*chain.base() })
        .and_then(|c| c.with_placed_tools(&tools))
        .and_then(|c| c.with_targets(targets))
        .map_err(wrong)
}

/// The tools of two lists, one by one.
fn both<'a, A, B>(a: &'a [A], b: &'a [B]) -> impl Iterator<Item = (&'a A, &'a B)> {
    a.iter().zip(b)
}

/// Largest move of base, tool or a target, m and rad.
fn distance(a: &State, b: &State) -> f64 {
    let apart =
        |a: &Pose, b: &Pose| (a.translation - b.translation).norm() + (a.rotation - b.rotation).norm();
    let targets = a.targets.iter().zip(&b.targets).map(|(a, b)| (a - b).norm());
    let tools = both(&a.tools, &b.tools).map(|(a, b)| apart(a, b));
    tools.chain(targets).fold(apart(&a.base, &b.base), f64::max)
}

/// Rows with the tool's pose as flange, and by how much the fit moves each target, m, tool axes.
fn sights(fitted: &FittedModel, data: &Dataset) -> Result<(Vec<Sight>, Vec<Vector3<f64>>), IdentifyError> {
    let mut predictor = fitted.bind(&data.schema)?;
    let chain = fitted.chain();
    let frame = chain.base().pose.inverse();
    let mut conditions = Conditions::default();
    let mut offsets = vec![Vector3::zeros(); chain.targets().len()];
    let sights = sights_of(data, ROWS_TO_REFINE, |row| {
        data.conditions_into(row, &mut conditions);
        let tool = predictor.predict(&conditions, None);
        if let Some(target) = data.target[row] {
            offsets[target.0] = predictor.errors(&conditions).target(target);
        }
        frame * tool
    });
    Ok((sights, offsets))
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::Residuals;
    use rand::{RngExt, SeedableRng};
    use rand_chacha::ChaCha8Rng;
    use truepose_errormodel::effects::{Geometric, JointCompliance};
    use truepose_errormodel::{DatasetBuilder, ErrorModel, Measurement};
    use truepose_kinematics::{TargetId, samples};

    /// An arm that bends and has wrong lengths, with three targets.
    fn arm() -> FittedModel {
        let targets = [[0.1, 0.0, 0.02], [-0.05, 0.08, 0.0], [0.0, -0.1, 0.05]];
        let targets = targets.iter().enumerate().map(|(k, at)| Target {
            name: format!("T{k}"),
            position: Vector3::from(*at),
            known: true,
            tool: truepose_kinematics::ToolId::FIRST,
        });
        let chain = samples::ur10().with_targets(targets.collect()).unwrap();
        let effects: Vec<Box<dyn truepose_errormodel::AnyEffect>> =
            vec![Box::new(Geometric::default()), Box::new(JointCompliance::default())];
        let model = ErrorModel::new(chain, effects).unwrap();
        let mut rng = ChaCha8Rng::seed_from_u64(3);
        let coefficients = model.columns().iter().map(|c| c.scale * rng.random_range(-2.0..2.0)).collect();
        let covariance = nalgebra::DMatrix::zeros(model.columns().len(), model.columns().len());
        FittedModel::new(model, coefficients, covariance).unwrap()
    }

    #[test]
    fn an_arm_is_found_in_another_installation_with_another_tool() {
        let fitted = arm();
        let chain = fitted.chain();
        let mut rng = ChaCha8Rng::seed_from_u64(5);
        let base = Pose::from_xyz_rpy([3.0, -2.0, 0.7], [0.3, -0.2, 2.0]);
        let tool = Pose::from_xyz_rpy([0.05, 0.02, 0.3], [0.4, 1.0, -0.6]);
        let there = chain.clone().with_base(Placed { pose: base, known: true });
        let there = there.and_then(|c| c.with_tool(Placed { pose: tool, known: true })).unwrap();
        let truth = fitted.on(there.clone()).unwrap();
        let mut builder = DatasetBuilder::new(&there);
        let mut predictor = truth.bind(&Dataset::default().schema).unwrap();
        for row in 0..18 {
            let joints: Vec<f64> = (0..6).map(|_| rng.random_range(-1.5..1.5)).collect();
            let target = Some(TargetId(row % 3));
            let at = Conditions { joints: joints.clone(), ..Conditions::default() };
            let seen = Measurement::at(joints).position(predictor.predict(&at, target).translation);
            builder.push(seen.target(target).visit(row as u64 / 3)).unwrap();
        }
        let data = builder.finish();
        let blank = chain.clone().with_base(Placed { pose: Pose::IDENTITY, known: false });
        let blank = blank.and_then(|c| c.with_tool(Placed { pose: Pose::IDENTITY, known: false })).unwrap();
        let placed = place_fitted(&fitted, &blank, &data).unwrap();
        assert_eq!(placed.found, ["base", "tool"]);
        let again = fitted.on(placed.chain.clone()).unwrap();
        let residual = Residuals::of(&again, &data).unwrap().positions().max;
        assert!(residual < 1e-9, "{residual}");
        assert!((placed.chain.base().pose.translation - base.translation).norm() < 1e-8);
        assert!((placed.chain.tool().pose.rotation - tool.rotation).norm() < 1e-8);
    }
}
