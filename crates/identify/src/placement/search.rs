//! Where the instrument stood, and what the tool and the targets are: found from the data, without a guess.
//!
//! | symbol | here | unit | frame |
//! | --- | --- | --- | --- |
//! | B = (R_B, t_B) | base | m | measurement ← frame 0 |
//! | F_k | `A_1 … A_n` at row k, nominal | m | frame 0 ← flange |
//! | y_τ | target τ seen from the flange | m | flange |
//! | p_k, R_k | what was measured | m | measurement |
//!
//! ```text
//! p_k = R_B (F_k y_τ) + t_B        R_k = R_B R_Fk R_T
//! ```
//!
//! For a given R_B all other unknowns of the positions are linear, so that only a rotation has to be searched: starts
//! are a closed form (the relaxation in which R_B is any 3 × 3 matrix; with measured orientations the
//! singular vector of `R_k R_T' = R_B R_Fk`, Shah 2013) and the 24 rotations of the cube, from one of which every
//! rotation lies within 63°. Each start is refined by Levenberg and Marquardt's method over all unknowns at once
//! (alternating between base and tool converges only linearly, and painfully slowly where a tool is short), and the
//! best one wins. Nothing depends on where the description puts the base.

use super::refine::{Refined, Unknowns, refine};
use super::sight::Sight;
use super::start::starts;
use super::undetermined::{Undetermined, undetermined};
use crate::IdentifyError;
use truepose_errormodel::Dataset;
use truepose_kinematics::{Chain, Placed, Pose};

/// A robot whose base, tool and targets stand where the data says.
#[derive(Debug, Clone, PartialEq)]
pub struct Placement {
    /// The robot, with everything known.
    pub chain: Chain,
    /// What was looked for: `base`, `tool`, names of targets.
    pub found: Vec<String>,
    /// RMS of the 3-D distance that the placement leaves, m.
    pub rms: f64,
    /// Directions that the data does not fix, and what would.
    pub undetermined: Vec<Undetermined>,
    /// Measured numbers beyond the unknowns that they determine: with none of them any placement fits exactly.
    pub spare: usize,
}

impl Placement {
    /// Of a robot all of whose places are known.
    pub(super) fn known(chain: Chain) -> Self {
        Placement { chain, found: Vec::new(), rms: 0.0, undetermined: Vec::new(), spare: 0 }
    }

    /// Refuses a placement that no measured number is left to check: it fits exactly, right or wrong.
    ///
    /// # Errors
    /// When something was found from as many numbers as it has unknowns.
    pub fn checked(self) -> Result<Self, IdentifyError> {
        if self.found.is_empty() || self.spare > 0 {
            return Ok(self);
        }
        let open = self.undetermined.iter().find(|open| !open.turn_of_tools_alone);
        Err(match open {
            Some(Undetermined { what, advice, .. }) => {
                IdentifyError::Placement { what: what.clone(), why: advice.clone() }
            }
            None => IdentifyError::Placement {
                what: self.found.join(", "),
                why: "there are no more measured numbers than unknowns, so that any place fits: measure more poses, or declare \
                      what is known"
                    .into(),
            },
        })
    }
}

/// Rows that a start is judged on; the refinement of the best start uses more.
const ROWS_TO_START: usize = 150;
pub(super) const ROWS_TO_REFINE: usize = 3000;

/// Finds base, tool and targets that are marked `known = false`; none of them: the chain as it is.
///
/// # Errors
/// When too little was measured to find anything at all.
pub fn place(chain: &Chain, data: &Dataset) -> Result<Placement, IdentifyError> {
    data.validate(chain)?;
    let unknowns = Unknowns::of(chain, data);
    if unknowns.is_empty() {
        return Ok(Placement::known(chain.clone()));
    }
    let sights = sights(chain, data, ROWS_TO_REFINE);
    let final_one = best(chain, &unknowns, &sights)?;
    let (undetermined, spare) = undetermined(chain, &unknowns, &final_one, &sights, data);
    let placed = final_one.state.applied(chain, &unknowns)?;
    Ok(Placement { rms: final_one.rms, found: unknowns.words(chain), chain: placed, undetermined, spare })
}

/// The best placement from nothing.
pub(super) fn best(chain: &Chain, unknowns: &Unknowns, sights: &[Sight]) -> Result<Refined, IdentifyError> {
    let refused =
        |why: &str| IdentifyError::Placement { what: unknowns.words(chain).join(", "), why: why.into() };
    if !sights.iter().any(|sight| sight.position.is_some() || sight.rotation.is_some()) {
        return Err(refused("no row has a complete position or an orientation"));
    }
    let step = sights.len().div_ceil(ROWS_TO_START);
    let few: Vec<Sight> = sights.iter().step_by(step.max(1)).cloned().collect();
    let length = chain.characteristic_length();
    let mut best: Option<Refined> = None;
    for start in starts(chain, unknowns, &few) {
        let candidate = refine(chain, unknowns, &few, start, length, 60);
        if best.as_ref().is_none_or(|b| candidate.cost < b.cost * (1.0 - 1e-6)) {
            best = Some(candidate);
        }
    }
    let best = best.ok_or_else(|| refused("there is no start"))?;
    Ok(refine(chain, unknowns, sights, best.state, length, 100))
}

/// Rows as sights, at most `limit`, evenly taken.
fn sights(chain: &Chain, data: &Dataset, limit: usize) -> Vec<Sight> {
    let bare = vec![Placed::default(); chain.tools().len()];
    let bare = chain.clone().with_base(Placed::default()).and_then(|c| c.with_placed_tools(&bare));
    let bare = bare.as_ref().unwrap_or(chain);
    let mut joints = vec![0.0; data.joints.len()];
    let flange = |row: usize| {
        for (value, column) in joints.iter_mut().zip(&data.joints) {
            *value = column[row];
        }
        bare.forward_to(data.tool(row), &joints)
    };
    sights_of(data, limit, flange)
}

/// Rows with these flanges (frame 0 ← flange) as sights, at most `limit`, evenly taken.
pub(super) fn sights_of(data: &Dataset, limit: usize, mut flange: impl FnMut(usize) -> Pose) -> Vec<Sight> {
    let usable: Vec<usize> = (0..data.len())
        .filter(|&row| data.landmark(row).is_none() && data.meets(row).is_none())
        .filter(|&row| data.seen(row).position.iter().all(|&s| s) || data.seen(row).orientation)
        .collect();
    let step = usable.len().div_ceil(limit).max(1);
    let sight = |row: usize| {
        let position = data.measured_position(row);
        Sight {
            flange: flange(row),
            position: position.iter().all(|v| v.is_finite()).then_some(position),
            rotation: data.measured_rotation(row),
            tool: data.tool(row),
            target: data.target[row],
        }
    };
    usable.into_iter().step_by(step).map(sight).collect()
}

#[cfg(test)]
mod tests {
    use super::*;
    use nalgebra::Vector3;
    use rand::{RngExt, SeedableRng};
    use rand_chacha::ChaCha8Rng;
    use truepose_errormodel::{DatasetBuilder, Measurement};
    use truepose_kinematics::{Pose, Target, TargetId, samples};

    /// A rotation uniform on SO(3), and a place up to 50 m away.
    fn anywhere(rng: &mut ChaCha8Rng) -> Pose {
        let q: [f64; 4] = loop {
            let q: [f64; 4] = std::array::from_fn(|_| rng.random_range(-1.0..1.0));
            let n = q.iter().map(|v| v * v).sum::<f64>();
            if n > 1e-3 && n <= 1.0 {
                break q;
            }
        };
        let t = Vector3::from_fn(|_, _| rng.random_range(-29.0..29.0));
        Pose::new(Pose::rotation_from_quaternion(q), t)
    }

    /// Sights of a robot whose base, tool and targets are really there; joints in ± `reach`, noise of `sd` m.
    fn seen(
        chain: &Chain,
        rows: usize,
        oriented: bool,
        reach: f64,
        sd: f64,
        rng: &mut ChaCha8Rng,
    ) -> Dataset {
        let n = chain.movable().len();
        let mut builder = DatasetBuilder::new(chain);
        for row in 0..rows {
            let joints: Vec<f64> = (0..n).map(|_| rng.random_range(-reach..reach)).collect();
            let target = (!chain.targets().is_empty()).then(|| TargetId(row % chain.targets().len()));
            let tool = chain.forward(&joints);
            let p = target.map_or(tool.translation, |t| tool.apply(&chain.targets()[t.0].position));
            let jitter = Vector3::from_fn(|_, _| sd * rng.random_range(-1.7..1.7));
            let seen = Measurement::at(joints).position(p + jitter).target(target).visit(row as u64);
            builder.push(if oriented { seen.orientation(tool.quaternion()) } else { seen }).unwrap();
        }
        builder.finish()
    }

    fn with_targets(count: usize, rng: &mut ChaCha8Rng) -> Vec<Target> {
        (0..count)
            .map(|k| Target {
                name: format!("T{k}"),
                position: Vector3::from_fn(|_, _| rng.random_range(-0.2..0.2)),
                known: true,
                tool: truepose_kinematics::ToolId::FIRST,
            })
            .collect()
    }

    #[test]
    fn found_from_anywhere_with_every_kind_of_measurement() {
        let mut rng = ChaCha8Rng::seed_from_u64(20);
        for trial in 0..24 {
            let robots = [samples::ur10(), samples::heavy(), samples::seven(), samples::skewed()];
            let count = [0, 1, 3][trial % 3];
            let oriented = trial % 2 == 0;
            let truth = robots[trial % 4]
                .clone()
                .with_targets(with_targets(count, &mut rng))
                .and_then(|c| c.with_base(Placed { pose: anywhere(&mut rng), known: true }))
                .and_then(|c| {
                    let mut tool = anywhere(&mut rng);
                    tool.translation *= 0.01;
                    c.with_tool(Placed { pose: tool, known: true })
                })
                .unwrap();
            let data = seen(&truth, 40, oriented, 1.5, 1e-4, &mut rng);
            // The description knows nothing: base and tool at the identity, targets at zero.
            let blank = truth
                .clone()
                .with_base(Placed { pose: Pose::IDENTITY, known: false })
                .and_then(|c| c.with_tool(Placed { pose: Pose::IDENTITY, known: false }))
                .and_then(|c| {
                    let unknown = truth.targets().iter().map(|t| Target {
                        position: Vector3::zeros(),
                        known: false,
                        ..t.clone()
                    });
                    c.with_targets(unknown.collect())
                })
                .unwrap();
            let placed = place(&blank, &data).unwrap();
            assert!(placed.rms < 4e-4, "trial {trial}, {}: {} m", truth.name(), placed.rms);
            let again = Residual::of(&placed.chain, &seen(&truth, 30, oriented, 1.5, 0.0, &mut rng));
            assert!(again.worst < 2e-3, "trial {trial}: elsewhere {} m", again.worst);
        }
    }

    struct Residual {
        worst: f64,
    }

    impl Residual {
        fn of(chain: &Chain, data: &Dataset) -> Self {
            let mut worst = 0.0f64;
            for row in 0..data.len() {
                let joints: Vec<f64> = data.joints.iter().map(|c| c[row]).collect();
                let tool = chain.forward(&joints);
                let p =
                    data.target[row].map_or(tool.translation, |t| tool.apply(&chain.targets()[t.0].position));
                worst = worst.max((p - data.measured_position(row)).norm());
            }
            Residual { worst }
        }
    }

    #[test]
    fn a_single_moved_axis_is_said() {
        let mut rng = ChaCha8Rng::seed_from_u64(3);
        let truth = samples::ur10().with_base(Placed { pose: anywhere(&mut rng), known: true }).unwrap();
        let mut data = seen(&truth, 30, false, 1.5, 0.0, &mut rng);
        for k in [0, 1, 3, 4, 5] {
            data.joints[k].fill(0.3);
        }
        for row in 0..data.len() {
            let joints: Vec<f64> = data.joints.iter().map(|c| c[row]).collect();
            data.position[row] = truth.forward(&joints).translation.into();
        }
        let blank = truth.clone().with_base(Placed { pose: Pose::IDENTITY, known: false }).unwrap();
        let blank = blank.with_tool(Placed { pose: Pose::IDENTITY, known: false }).unwrap();
        let placed = place(&blank, &data).unwrap();
        assert!(placed.rms < 1e-6);
        let said = &placed.undetermined[0];
        assert!(said.what.contains("position of the base"), "{said:?}");
        assert_eq!(said.advice, "only j3 moved: move at least two joints whose axes are not parallel");
    }

    #[test]
    fn a_placement_that_any_measurement_fits_is_refused() {
        let mut rng = ChaCha8Rng::seed_from_u64(5);
        let truth = samples::ur10().with_base(Placed { pose: anywhere(&mut rng), known: true }).unwrap();
        let blank = truth.clone().with_base(Placed { pose: Pose::IDENTITY, known: false }).unwrap();
        let blank = blank.with_tool(Placed { pose: Pose::IDENTITY, known: false }).unwrap();
        // Nine unknowns, since positions do not show how the tool is turned.
        for (poses, spare) in [(2, 0), (3, 0), (4, 3)] {
            let placed = place(&blank, &seen(&truth, poses, false, 1.5, 0.0, &mut rng)).unwrap();
            assert_eq!((placed.spare, placed.checked().is_ok()), (spare, spare > 0), "{poses} poses");
        }
    }

    #[test]
    fn known_placements_stay() {
        let mut rng = ChaCha8Rng::seed_from_u64(4);
        let truth = samples::pps();
        let data = seen(&truth, 10, false, 0.2, 0.0, &mut rng);
        assert_eq!(place(&truth, &data).unwrap().chain, truth);
    }
}
